"""Normal points as the cells of a file: means of what was summed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array
from pyport.columns import COLUMNS, angle_of
from pyport.least_squares import robust
from pyport.recordings.raw import Raw
from pyport.recordings.stream.cells import Cells, Codes
from pyport.recordings.stream.chunk import Chunk
from pyport.thresholds import OUTLIER_WEIGHT

#: A cell's middle is the median of the means of so many parts, which no few outliers can move.
PARTS = 5
#: Offsets are distinguished by this much, which no recorded digits are multiples of [1/rad].
_COARSE = 7.38905609893e8
#: Steele & Vigna 2022, Software: Practice and Experience 52, 443: a multiplier that mixes bits.
_MIXED = np.uint64(0xD1342543DE82EF95)


@dataclass(frozen=True)
class Middle:
    """What the first pass found."""

    #: The cells; their totals are the middles on both axes [rad], (c, 2), NaN where none.
    cells: Cells
    #: Scatter of a reading about its cell's middle on both axes [rad], for each set of labels of
    #: `cells`, shape (labels, 2); infinite where nothing tells it.
    scale: Array


def first_totals(
    chunk: Chunk, label: Codes, _key: Codes, cell: Codes
) -> tuple[tuple[str, ...], Array]:
    """Return rows, and on each axis counts and sums of the parts and the sum of squares."""
    count = len(label)
    part = cell * PARTS + _parts(chunk)
    out = [np.bincount(cell, minlength=count)[:, None]]
    for values in (chunk.x, chunk.y):
        there = ~np.isnan(values)
        known = np.where(there, values, 0.0)
        out += [
            np.bincount(part, there, count * PARTS).reshape(count, PARTS),
            np.bincount(part, known, count * PARTS).reshape(count, PARTS),
            np.bincount(cell, known * known, count)[:, None],
        ]
    totals = np.concatenate(out, axis=1).astype(float)
    return tuple(map(str, range(totals.shape[1]))), totals


def _parts(chunk: Chunk) -> Codes:
    """Deal rows out to the parts by what they say: wherever a row stands, its part is the same."""
    bits = np.zeros(len(chunk.az), np.uint64)
    # Offsets may differ in their last digits with the company that they are computed in.
    coarse = (np.rint(np.nan_to_num(one) * _COARSE) for one in (chunk.x, chunk.y))
    for values in (chunk.time, chunk.az, chunk.el, *coarse):
        bits = (bits ^ np.ascontiguousarray(values, float).view(np.uint64)) * _MIXED
        bits ^= bits >> np.uint64(29)
    return ((bits >> np.uint64(32)) % np.uint64(PARTS)).astype(np.int64)


def middle_of(first: Cells) -> Middle:
    """Return the middle of each cell, and the scatter about it of each antenna and axis."""
    width = 2 * PARTS + 1
    middles, scales = [], []
    who = _antennas(first)
    for axis in range(2):
        own = first.totals[:, 1 + axis * width : 1 + (axis + 1) * width]
        counts, sums, squares = own[:, :PARTS], own[:, PARTS:-1], own[:, -1]
        with np.errstate(invalid="ignore", divide="ignore"):
            middles.append(_nanmedian(sums / counts))
            n, total = counts.sum(axis=1), sums.sum(axis=1)
            variance = (squares - total**2 / n) / (n - 1)
        enough = n >= PARTS
        scale = np.full(who.max() + 1, np.inf)
        for antenna in np.unique(who[first.label[enough]]):
            rows = enough & (who[first.label] == antenna)
            scale[antenna] = np.sqrt(max(float(np.median(variance[rows])), 0.0))
        scales.append(np.where(scale > 0, scale, np.inf)[who])
    cells = replace(first, totals=np.stack(middles, axis=1))
    return Middle(cells, np.stack(scales, axis=1))


def _nanmedian(values: Array) -> Array:
    """Return the median of each row's numbers, NaN where there are none."""
    ordered = np.sort(values, axis=1)
    count = (~np.isnan(values)).sum(axis=1)
    row = np.arange(len(values))
    low, high = np.maximum(count - 1, 0) // 2, count // 2
    middle = (ordered[row, low] + ordered[row, np.minimum(high, values.shape[1] - 1)]) / 2
    return np.where(count > 0, middle, np.nan)


def _antennas(cells: Cells) -> Codes:
    """Return the number of the antenna of each set of labels, shape (labels,)."""
    if "antenna" not in cells.label_names:
        return np.zeros(len(cells.names), np.int64)
    at = cells.label_names.index("antenna")
    return np.unique([words[at] for words in cells.names], return_inverse=True)[1]


#: Readings beyond this many sigmas of their cell's middle lose weight as Tukey takes it from them.
REACH = 6.0
#: Angles whose mean is that of directions.
CIRCULAR = frozenset(one.name for one in COLUMNS if one.circular)


def second_totals(
    chunk: Chunk, label: Codes, key: Codes, cell: Codes, middle: Middle
) -> tuple[tuple[str, ...], Array]:
    """Return weighted sums on each axis, and sums of everything else, as `points` names them."""
    count = len(key)
    own_label = _labels_in(chunk, middle.cells)
    place = places_of(middle.cells, own_label[label], key)
    out = [np.bincount(cell, minlength=count)]
    for axis, values in enumerate((chunk.x, chunk.y)):
        off = values - middle.cells.totals[place, axis][cell]
        there = ~np.isnan(off)
        weight = there.astype(float)
        sigma = middle.scale[own_label, axis][chunk.label]
        far = np.flatnonzero(np.abs(off) > 3 * sigma)
        weight[far] = robust.flat_weight(off[far] / sigma[far], 1.0, REACH)
        known = np.where(there, values, 0.0)
        pulled = weight * known
        out += [
            np.bincount(cell, there, count),
            np.bincount(cell, weight, count),
            np.bincount(cell, pulled, count),
            np.bincount(cell, pulled * known, count),
            np.bincount(cell[far], weight[far] < OUTLIER_WEIGHT, count),
        ]
    out += [np.bincount(cell, one, count) for one in (chunk.az, chunk.el, chunk.time)]
    sums = list(SUMMED)
    for name, values in chunk.numbers.items():
        there = ~np.isnan(values)
        for what, one in _linear(name, np.where(there, values, 0.0)).items():
            sums.append(f"{name}:{what}")
            out.append(np.bincount(cell, one * there, count))
    return tuple(sums), np.stack(out, axis=1).astype(float)


def _linear(name: str, values: Array) -> dict[str, Array | float]:
    """Return what a column's mean is taken of: itself, or sine and cosine of a direction."""
    angle = angle_of(name)
    if angle is None or angle[0] not in CIRCULAR:
        return {"count": 1.0, "sum": values}
    radians = values * angle[1]
    return {"count": 1.0, "sine": np.sin(radians), "cosine": np.cos(radians)}


def _labels_in(chunk: Chunk, cells: Cells) -> Codes:
    """Return the number that each set of labels of a chunk has among a table's."""
    number = {words: n for n, words in enumerate(cells.names)}
    found = []
    for words in chunk.names:
        of = dict(zip(chunk.label_names, words, strict=True))
        found.append(number[tuple(of.get(name, "") for name in cells.label_names)])
    return np.array(found, np.int64)


def places_of(cells: Cells, label: Codes, key: Codes) -> Codes:
    """Return where cells stand in a sorted table that has them all."""
    low = np.searchsorted(cells.label, label, side="left")
    place = np.empty(len(key), np.int64)
    for one in np.unique(label):
        mine = label == one
        start = int(low[np.argmax(mine)])
        stop = int(np.searchsorted(cells.label, one, side="right"))
        place[mine] = start + np.searchsorted(cells.key[start:stop], key[mine])
    return place


#: What the second pass sums, before the further columns.
SUMMED = (
    "rows",
    *(f"{what}_x" for what in ("readings", "weight", "sum", "squares", "outliers")),
    *(f"{what}_y" for what in ("readings", "weight", "sum", "squares", "outliers")),
    "az",
    "el",
    "time",
)


def as_raw(points: Cells, root: Path, meta: dict[str, str], *, places_only: bool = False) -> Raw:
    """Return normal points in the contract's columns, as lines numbered from 1.

    `points`: sums of the second pass; further columns are summed as `NAME:count`, `NAME:sum`, or
      `NAME:sine` and `NAME:cosine`.
    `root`: the data set, for errors.
    `meta`: header keys.
    `places_only`: whether the offsets do not matter: they are zero then.
    """
    of = dict(zip(points.sums, points.totals.T, strict=True))
    columns: dict[str, NDArray[Any]] = {
        "az_deg": of["az"] / of["rows"] / DEG,
        "el_deg": of["el"] / of["rows"] / DEG,
    }
    for axis, name in (("x", "xel"), ("y", "el")):
        mean, sigma = _mean(*(of[f"{what}_{axis}"] for what in ("weight", "sum", "squares")))
        if places_only:
            mean = np.zeros(len(points))
        columns[f"d_{name}_deg"], columns[f"sigma_{name}_deg"] = mean / DEG, sigma / DEG
    if of["time"].any():
        micro = np.rint(of["time"] / of["rows"] * 1e6).astype(np.int64)
        columns["time_utc"] = micro.astype("datetime64[us]")
    direction = points.directions()
    if direction.any():
        columns["scan_direction"] = direction
    for name in (one.removesuffix(":count") for one in points.sums if one.endswith(":count")):
        columns[name] = _further(name, of)
    for n, label in enumerate(points.label_names):
        columns[label] = np.array([words[n] for words in points.names], np.str_)[points.label]
    return Raw(root, meta, 1, columns, np.arange(1, len(points) + 1))


def _mean(weight: Array, total: Array, squares: Array) -> tuple[Array, Array]:
    """Return weighted means and their errors; NaN where nothing has weight, or one alone."""
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(weight > 0, total / weight, np.nan)
        variance = np.maximum(squares / weight - mean**2, 0.0) / (weight - 1)
        sigma = np.sqrt(np.where((weight > 1) & (variance > 0), variance, np.nan))
    return mean, sigma


def _further(name: str, of: dict[str, Array]) -> Array:
    """Return the mean of a further column, in the unit that its name says; NaN where none is."""
    count = of[f"{name}:count"]
    with np.errstate(invalid="ignore", divide="ignore"):
        if f"{name}:sum" in of:
            return np.asarray(of[f"{name}:sum"] / count)
        angle = angle_of(name)
        unit = 1.0 if angle is None else angle[1]
        direction = np.arctan2(of[f"{name}:sine"], of[f"{name}:cosine"]) % (2 * np.pi)
        return np.where(count > 0, direction / unit, np.nan)
