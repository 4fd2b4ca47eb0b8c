"""The numbers that go into the page: few enough to be drawn quickly, short enough to be sent."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.page import pack
from pyport.page.clock import stretches
from pyport.page.picture import Column, Picture, Side

#: More recordings than this are not drawn, but a random choice of as many.
MOST_DRAWN = 3000
#: Numbers that are computed with get four bytes.
EXACT = 1e-12
#: Residuals beyond this quantile of their size lie outside the panels' frame.
FRAME = 0.985


def payload(picture: Picture) -> dict[str, object]:
    """Return what the panels need, ready for JSON."""
    rows = drawn(len(picture))
    scale, unit = picture.unit
    return {
        "unit": unit,
        "total": len(picture),
        "names": list(picture.names if picture.layers else ("residuals", "residuals")),
        "show": picture.show if picture.layers else "after",
        "line": pack.numbers(picture.line[rows].astype(float), step=1.0),
        "time": _time(picture, rows),
        "columns": [_column(one, rows) for one in picture.columns],
        "labels": {name: pack.words(values[rows]) for name, values in picture.labels.items()},
        "layers": [
            {
                "name": one.name,
                "since": one.since,
                "curve": [[round(a, 3), round(e, 3)] for a, e in one.curve],
            }
            for one in picture.layers
        ],
        "turn": None
        if picture.turn is None
        else [pack.numbers(one[rows]) for one in picture.turn.reshape(4, -1)],
        "axes": [
            {"name": name, "letter": "x" if side is picture.x else "y", **_side(side, rows, scale)}
            for name, side in picture.sides()
        ],
        "linear": _linear(picture) if len(rows) == len(picture) else None,
    }


def _linear(picture: Picture) -> dict[str, object] | None:
    """Return what one unit of each coefficient adds, and what is left, to ten digits."""
    own, scale = picture.linear, picture.unit[0]
    if own is None:
        return None
    sides = {"x": (picture.x, own.x), "y": (picture.y, own.y)}
    return {
        "names": own.names,
        "labels": own.labels,
        "units": own.units,
        "values": own.values,
        "free": own.free,
        "left": {
            name: pack.numbers(side.after / scale, EXACT) for name, (side, _) in sides.items()
        },
        "columns": {
            name: [pack.numbers(one / scale, EXACT) if one.any() else None for one in columns]
            for name, (_, columns) in sides.items()
        },
    }


def drawn(n: int) -> NDArray[np.intp]:
    """Return which of n recordings are drawn: all, or the same random choice every time."""
    if n <= MOST_DRAWN:
        return np.arange(n)
    return np.sort(np.random.default_rng(0).permutation(n)[:MOST_DRAWN])


def _side(side: Side, rows: NDArray[np.intp], scale: float) -> dict[str, object]:
    return {
        "before": pack.numbers(side.before[rows] / scale),
        "layers": [pack.numbers(one[rows] / scale) for one in side.layers],
        "share": pack.numbers(side.share[rows]),
        "floor": None if side.floor is None else float(f"{side.floor / scale:.6g}"),
        "reach": float(f"{reach(side, side.before, side.after) / scale:.4g}"),
        "near": float(f"{reach(side, side.after) / scale:.4g}"),
    }


def reach(side: Side, *shown: Array) -> float:
    """Return how far the frame of a panel that shows some residuals reaches from zero [rad]."""
    counted = (side.share > 0) & np.isfinite(side.before)
    sizes = np.abs(np.concatenate([one[counted] for one in shown]))
    return 1.25 * float(np.quantile(sizes, FRAME)) if len(sizes) else 1.0


def _column(column: Column, rows: NDArray[np.intp]) -> dict[str, object]:
    head = {"name": column.name, "label": column.label, "unit": column.unit}
    values = column.values[rows]
    if values.dtype.kind == "U":
        return {**head, "words": pack.words(values.astype(str))}
    numbers: Array = values.astype(float)
    regions = [[low, high, layer] for low, high, layer in column.regions]
    return {**head, "numbers": pack.numbers(numbers), "regions": regions}


def _time(picture: Picture, rows: NDArray[np.intp]) -> dict[str, object] | None:
    """Return times as seconds since the first, and the stretches that the axis is made of."""
    if picture.time is None or not np.isfinite(picture.time).any():
        return None
    first = float(np.floor(np.nanmin(picture.time)))
    return {
        "first": first,
        "seconds": pack.numbers(picture.time[rows] - first, step=1.0),
        "stretches": [[round(a - first), round(b - first)] for a, b in stretches(picture.time)],
    }
