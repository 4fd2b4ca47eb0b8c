"""What the panels draw: residuals before and after, what each effect adds, and against what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, HOUR, Array, handy
from pyport.columns import SPELLED, shown
from pyport.diagnosis.joint import rms
from pyport.diagnosis.naming.finding import Interval
from pyport.effects.circumstances import mostly_known
from pyport.page.markup import Linear
from pyport.recordings.schema import Recordings, Stack


@dataclass(frozen=True)
class Side:
    """One axis of n recordings; NaN where it was not measured."""

    before: Array  #: residuals of the model alone [rad], shape (n,)
    #: What each effect takes off them, the model refitted [rad], shape (n,) each.
    layers: tuple[Array, ...]
    share: Array  #: how much each counts in an rms, 0 to 1; 0 for an outlier, shape (n,)
    floor: float | None  #: rms of the noise alone [rad], None where it is not known

    @property
    def after(self) -> Array:
        """Return what is left when every layer is taken off [rad], shape (n,)."""
        return self.before - sum(self.layers, np.zeros(len(self.before)))

    def rms(self, values: Array) -> float:
        """Return the rms of values on this axis [rad], each by its share."""
        there = np.isfinite(values)
        return rms(values[there], self.share[there])


@dataclass(frozen=True)
class Column:
    """Something to draw residuals against: numbers in a unit, or labels."""

    #: `name`, `label`, `unit`: as the recordings spell it, in words, and the unit, "" for none.
    name: str
    label: str
    unit: str
    #: Shape (n,), numbers (NaN where unknown) or text.
    values: NDArray[np.float64] | NDArray[np.str_]
    #: Stretches (low, high) to which a finding is confined, and the number of its layer.
    regions: tuple[tuple[float, float, int], ...] = ()

    @property
    def title(self) -> str:
        """Return the label with its unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


@dataclass(frozen=True)
class Layer:
    """An effect that can be taken off: its name, where it is confined to, its edge on the sky."""

    name: str
    region: tuple[Interval, ...] = ()
    curve: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class Picture:
    """All that the panels draw of n recordings.

    `time` in seconds of UTC since 1970 or None; `columns` with azimuth and
    elevation first and the hour angle next, then the others, the one with the most
    structure first; `labels` distinguish recordings when one is pointed at; `show`
    is what is drawn first: before, after or both; `axes` are what the mount calls x and y, and
    `turn` (2, 2, n) turns what is across and along elevation into them, None where it is the same;
    `linear` is what can be fitted again.
    """

    time: Array | None
    line: NDArray[np.int64]
    columns: tuple[Column, ...]
    labels: dict[str, NDArray[np.str_]]
    layers: tuple[Layer, ...]
    x: Side
    y: Side
    names: tuple[str, str]
    show: str
    axes: tuple[str, str]
    linear: Linear | None
    turn: Array | None

    def __len__(self) -> int:
        """Return n."""
        return len(self.line)

    @property
    def unit(self) -> tuple[float, str]:
        """Return the unit [rad] in which residuals are shown, by what is left, and its name."""
        sizes = [side.rms(side.after) for side in (self.x, self.y)]
        return handy(max(sizes))

    def on_sky(self, name: str) -> tuple[Array, Array]:
        """Return residuals, `before` or `after`, across and along elevation, 0 for none [rad]."""
        x, y = (np.nan_to_num(getattr(side, name)) for side in (self.x, self.y))
        if self.turn is None:
            return x, y
        return self.turn[0, 0] * x + self.turn[1, 0] * y, self.turn[0, 1] * x + self.turn[1, 1] * y

    def sides(self) -> list[tuple[str, Side]]:
        """Return the axes on which anything was measured, with their names."""
        both = zip(self.axes, (self.x, self.y), strict=True)
        return [(name, side) for name, side in both if np.isfinite(side.before).any()]


def apart(recordings: Recordings, stack: Stack, values: Array) -> tuple[Array, Array]:
    """Return the numbers of a stack (m,) as an array for each axis, (n,) each, NaN for none."""
    out = np.full((2, len(recordings)), np.nan)
    out[stack.is_y.astype(int), stack.row] = values
    return out[0], out[1]


def sides(
    recordings: Recordings,
    stack: Stack,
    before: Array,
    layers: Sequence[Array],
    share: Array,
    floors: tuple[float | None, float | None] = (None, None),
) -> tuple[Side, Side]:
    """Return both axes from numbers in the order of the stack, (m,) each."""
    first = apart(recordings, stack, before)
    taken = [apart(recordings, stack, one) for one in layers]
    counted = apart(recordings, stack, share)
    one, other = (
        Side(
            first[axis],
            tuple(layer[axis] for layer in taken),
            np.nan_to_num(counted[axis]),
            floors[axis],
        )
        for axis in (0, 1)
    )
    return one, other


#: Bins of equal count that show whether residuals follow a column.
BINS = 12
#: Labels with more values than this are no axis of a panel.
MOST_LABELS = 40
#: Numbers that take no more values than this are drawn as labels are.
FEW_VALUES = 8
#: So many columns beside the sky are kept, the ones with the most structure.
MOST_COLUMNS = 12

#: How regions spell a column -> the column of a panel.
_NAMED = {written: name for name, written in SPELLED.items()}


def columns(
    recordings: Recordings, layers: Sequence[Layer], residuals: Sequence[Array]
) -> tuple[Column, ...]:
    """Return the columns to draw residuals against.

    `recordings`: where, when and in which conditions.
    `layers`: the effects found; the stretches they are confined to come with the columns.
    `residuals`: residuals on each axis, shape (n,) each; what they follow most comes first.
    """
    at = recordings.at
    az, regions = _azimuth(at.az / DEG, _regions("az", layers))
    found = [
        Column("az", "azimuth", "deg", az, regions),
        Column("el", "elevation", "deg", at.el / DEG, _regions("el", layers)),
    ]
    if "hour_angle" in at:
        hours = np.asarray(at.column("hour_angle"), float) / HOUR
        hours = (hours + 12) % 24 - 12
        if np.isfinite(hours).any():
            regions = _regions("hour_angle", layers)
            found.append(Column("hour_angle", "hour angle", "h", hours, regions))
    skipped = {"time", "order", "hour_angle", *recordings.meta.get("bookkeeping", "").split()}
    others = [
        _column(name, values, layers) for name, values in at.columns.items() if name not in skipped
    ]
    kept = [one for one in others if _varies(one)]
    kept.sort(key=lambda one: (not one.regions, -_structure(one, residuals), one.name))
    return (*found, *kept[:MOST_COLUMNS])


def _column(name: str, values: NDArray[np.generic], layers: Sequence[Layer]) -> Column:
    label, unit, scale = shown(name)
    regions = _regions(name, layers)
    if values.dtype.kind not in "fiub":
        return Column(name, label, unit, values.astype(str), regions)
    numbers = np.asarray(values, float) / scale
    distinct = np.unique(numbers[np.isfinite(numbers)])
    if len(distinct) > FEW_VALUES or regions:
        return Column(name, label, unit, numbers, regions)
    signed = "+g" if distinct.min(initial=0) < 0 else "g"
    words = {value: format(value, signed) for value in distinct}
    texts = [words.get(value, "unknown") for value in numbers.tolist()]
    return Column(name, label, unit, np.array(texts, np.str_), regions)


def _azimuth(
    az: Array, regions: tuple[tuple[float, float, int], ...]
) -> tuple[Array, tuple[tuple[float, float, int], ...]]:
    """Return azimuths [deg] about the south or, where that tears them apart less, about the north.

    Stretches that the new zero cuts come back as two.
    """
    about_south = az % 360
    about_north = (az + 180) % 360 - 180
    first = -180.0 if np.ptp(about_north) < 0.8 * np.ptp(about_south) else 0.0
    parts = []
    for low, high, layer in regions:
        start = (low - first) % 360 + first
        # A stretch across the north may come as from 300 to 7 deg.
        stop = start + (360.0 if high - low >= 360 else (high - low) % 360)
        parts.append((start, min(stop, first + 360), layer))
        if stop > first + 360:
            parts.append((first, stop - 360, layer))
    return (about_north if first else about_south), tuple(parts)


def _regions(name: str, layers: Sequence[Layer]) -> tuple[tuple[float, float, int], ...]:
    return tuple(
        (one.low, one.high, n)
        for n, layer in enumerate(layers)
        for one in layer.region
        if _NAMED.get(one.column, one.column) == name
    )


def _varies(column: Column) -> bool:
    """Tell whether a column has more than one value and, if it holds labels, not too many."""
    if column.values.dtype.kind == "U":
        return 1 < len(np.unique(column.values)) <= MOST_LABELS
    known = column.values[np.isfinite(column.values.astype(float))]
    return mostly_known(column.values.astype(float)) and len(np.unique(known)) > 1


def _structure(column: Column, residuals: Sequence[Array]) -> float:
    """Return the largest share of the residuals' variance that a column's bins explain."""
    shares = []
    for residual in residuals:
        rows = np.isfinite(residual)
        if column.values.dtype.kind != "U":
            rows = rows & np.isfinite(column.values.astype(float))
        if rows.sum() > 2 * BINS:
            shares.append(explained(column.values[rows], residual[rows]))
    return max(shares, default=0.0)


def explained(values: NDArray[np.generic], residual: Array) -> float:
    """Return the share of the variance of residuals that bins of a column explain.

    What bins explain by chance is taken off; at most 1, about 0 for nothing.
    """
    order, codes = np.unique(values, return_inverse=True)
    if len(order) > BINS and values.dtype.kind != "U":
        edges = np.quantile(values.astype(float), np.linspace(0, 1, BINS + 1)[1:-1])
        codes = np.searchsorted(edges, values.astype(float))
    limit = 5 * float(np.median(np.abs(residual))) or np.inf
    clipped = np.clip(residual, -limit, limit)
    count = np.bincount(codes)
    mean = np.bincount(codes, clipped) / np.maximum(count, 1)
    total = float(np.var(clipped))
    if total <= 0:
        return 0.0
    bins, n = int((count > 0).sum()), len(residual)
    left = float(np.mean((clipped - mean[codes]) ** 2)) * n / max(n - bins, 1)
    return 1 - left / (total * n / (n - 1))
