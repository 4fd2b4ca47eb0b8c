"""The first pass: where the middle of each cell is, and how far readings scatter about it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import Array
from pyport.recordings.stream.cells import Cells, Codes
from pyport.recordings.stream.chunk import Chunk

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
