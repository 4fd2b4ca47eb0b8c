"""The numbers that go into the page: few enough to be drawn quickly, short enough to be sent."""

from __future__ import annotations

import base64

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.diagnosis.diagnose import Diagnosis
from pyport.diagnosis.naming.finding import Finding
from pyport.least_squares.gram import inverted
from pyport.page.picture import Column, Layer, Picture, Side


def visible(diagnosis: Diagnosis) -> list[Array]:
    """Return what each chosen effect takes off the residuals [rad], shape (m,) each.

    An effect's curve less what the model draws of it, in the same weighing as the joint fit. The
    model alone is fitted under a noise of its own; what that changes is shared out evenly, so that
    together they lead exactly from the residuals of the model alone to those of the joint fit.
    """
    problem, joint = diagnosis.problem, diagnosis.after
    gram = diagnosis.weighed.evidence.gram
    model = [problem.part(one) for one in problem.base]
    inverse = inverted(gram.cross(model, model))[0]
    base = problem.expanded(problem.base)
    found = []
    for n in range(len(problem.base), len(joint.choices)):
        chosen = joint.choices[n]
        values = joint.solution.values[joint.slice(n)]
        shift = inverse @ (gram.cross(model, [problem.part(chosen)]) @ values)
        found.append(problem.expanded([chosen]) @ values - base @ shift)
    if not found:
        return found
    rest = diagnosis.left(diagnosis.before) - diagnosis.left(diagnosis.after) - sum(found)
    return [one + rest / len(found) for one in found]


def layers(diagnosis: Diagnosis, curves: list[Array]) -> tuple[list[Layer], list[int | None]]:
    """Return the layers of a diagnosis, and for each finding the number of its layer.

    A layer is called what its findings call it: an effect without a name by its shape.
    """
    chosen = diagnosis.after.choices[len(diagnosis.problem.base) :]
    of_finding = [_layer_of(finding, diagnosis, curves) for finding in diagnosis.findings]
    found = []
    for n, one in enumerate(chosen):
        mine = [f for f, at in zip(diagnosis.findings, of_finding, strict=True) if at == n]
        effect = one.candidate.effect
        names = list(dict.fromkeys(f.effect for f in mine)) or [effect.id]
        name = " and ".join(names).replace("_", " ") + (
            f" ({effect.variant})" if effect.variant else ""
        )
        region = tuple(part for f in mine for part in f.where.region)
        curve = next((f.where.curve for f in mine if f.where.curve), ())
        found.append(Layer(name, region, curve))
    return found, of_finding


def _layer_of(finding: Finding, diagnosis: Diagnosis, curves: list[Array]) -> int | None:
    """Return the number of the chosen effect that a finding is read from, None of a survey."""
    chosen = diagnosis.after.choices[len(diagnosis.problem.base) :]
    effects = [one.candidate.effect for one in chosen]
    if not effects:
        return None
    same = [n for n, one in enumerate(effects) if one.variant == finding.variant] or [
        *range(len(effects))
    ]
    named = [n for n in same if effects[n].id == finding.effect]
    if len(named) == 1:
        return named[0]
    # A shape has no name of its own, and what antennas share may have another: go by the curve.
    curve = finding.curve
    if curve is None:
        return (named or same)[0]
    return max(named or same, key=lambda n: abs(_cosine(curve, curves[n])))


def _cosine(one: Array, other: Array) -> float:
    length = float(np.linalg.norm(one) * np.linalg.norm(other))
    return float(one @ other) / length if length > 0 else 0.0


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
        "line": numbers(picture.line[rows].astype(float), step=1.0),
        "time": _time(picture, rows),
        "columns": [_column(one, rows) for one in picture.columns],
        "labels": {name: words(values[rows]) for name, values in picture.labels.items()},
        "layers": [
            {
                "name": one.name,
                "curve": [[round(a, 3), round(e, 3)] for a, e in one.curve],
            }
            for one in picture.layers
        ],
        "turn": None
        if picture.turn is None
        else [numbers(one[rows]) for one in picture.turn.reshape(4, -1)],
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
        "left": {name: numbers(side.after / scale, EXACT) for name, (side, _) in sides.items()},
        "columns": {
            name: [numbers(one / scale, EXACT) if one.any() else None for one in columns]
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
        "before": numbers(side.before[rows] / scale),
        "layers": [numbers(one[rows] / scale) for one in side.layers],
        "share": numbers(side.share[rows]),
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
        return {**head, "words": words(values.astype(str))}
    regions = [[low, high, layer] for low, high, layer in column.regions]
    return {**head, "numbers": numbers(values.astype(float)), "regions": regions}


def _time(picture: Picture, rows: NDArray[np.intp]) -> dict[str, object] | None:
    """Return times as seconds since the first, and the stretches that the axis is made of."""
    if picture.time is None or not np.isfinite(picture.time).any():
        return None
    first = float(np.floor(np.nanmin(picture.time)))
    return {
        "first": first,
        "seconds": numbers(picture.time[rows] - first, step=1.0),
        "stretches": [[round(a - first), round(b - first)] for a, b in stretches(picture.time)],
    }


#: The code of a number that is not known, by the bytes of a code.
_NOTHING = {2: 0xFFFF, 4: 0xFFFFFFFF}


def numbers(values: Array, step: float = 0.0) -> dict[str, object]:
    """Return numbers as whole steps above the lowest; NaN for what is not known.

    Two bytes a number, or four where 65 534 steps across the range are coarser
    than `step` (0 for whatever two bytes hold).
    """
    known = np.isfinite(values)
    low, high = (
        (float(values[known].min()), float(values[known].max())) if known.any() else (0.0, 0.0)
    )
    size = 2 if step <= 0 or (high - low) / (_NOTHING[2] - 1) <= step else 4
    unit = (high - low) / (_NOTHING[size] - 1)
    # Few digits in the text; rounded up so that the highest still has a code.
    unit = float(f"{unit * (1 + 1e-6):.7g}") or 1.0
    codes = np.full(len(values), _NOTHING[size], f"<u{size}")
    codes[known] = np.round((values[known] - low) / unit)
    return {"low": low, "unit": unit, "bytes": size, "data": _text(codes)}


def words(values: NDArray[np.str_]) -> dict[str, object]:
    """Return labels as their list and a code of two bytes for each."""
    names, codes = np.unique(values, return_inverse=True)
    return {"names": [str(name) for name in names], "data": _text(codes.astype("<u2"))}


def _text(codes: NDArray[np.unsignedinteger]) -> str:
    return base64.b64encode(codes.tobytes()).decode("ascii")


#: Gaps longer than this may be cut out [s].
SHORTEST_GAP = 6 * 3600.0
MOST_STRETCHES = 40


def stretches(time: Array) -> list[tuple[float, float]]:
    """Return the stretches (from, to) [s] in which observations lie close together.

    There are at most `MOST_STRETCHES`: where more campaigns were observed, only
    the longest gaps are cut out.
    """
    known = np.unique(time[np.isfinite(time)])
    if len(known) == 0:
        return []
    gaps = np.diff(known)
    shortest = SHORTEST_GAP
    if (gaps > shortest).sum() >= MOST_STRETCHES:
        shortest = float(np.sort(gaps)[-MOST_STRETCHES])
    cuts = np.flatnonzero(gaps > shortest)
    first = known[np.concatenate([[0], cuts + 1])]
    last = known[np.concatenate([cuts, [len(known) - 1]])]
    return [(float(a), float(b)) for a, b in zip(first, last, strict=True)]
