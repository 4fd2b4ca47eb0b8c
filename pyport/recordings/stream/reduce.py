"""From a data set to normal points, in two passes: where each cell's middle is, what counts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import Array
from pyport.effects.base import Fine
from pyport.errors import BadInput
from pyport.fitting import robust
from pyport.recordings.columns import angle_of
from pyport.recordings.given import NOTHING, Given
from pyport.recordings.interpret import interpret
from pyport.recordings.schema import Recordings, Reduction, SetAside
from pyport.recordings.stream.cells import (
    ALWAYS,
    LEVELS,
    PATCH_DEG,
    STRETCH_S,
    Cells,
    Codes,
    Gathered,
    grouped,
    grown,
    key_of,
    shrunk,
)
from pyport.recordings.stream.chunk import Aside, Chunk, chunk_of
from pyport.recordings.stream.passes import MOST_CELLS, passes
from pyport.recordings.stream.pieces import Piece, files_of, pieces_of
from pyport.recordings.stream.points import SUMMED, as_raw
from pyport.workers import Spread

#: Places that effects are computed at: a point's share of an effect is the mean over its places.
MOST_PLACES = 40_000
#: Measured numbers that a diagnosis is given at most.
MOST_NUMBERS = 12_000
#: A cell's middle is the median of the means of so many parts, which no few outliers can move.
PARTS = 5
#: Offsets are told apart by this much, which no recorded digits are multiples of [1/rad].
_COARSE = 7.38905609893e8
#: Steele & Vigna 2022, Software: Practice and Experience 52, 443: a multiplier that mixes bits.
_MIXED = np.uint64(0xD1342543DE82EF95)
#: Readings beyond this many sigmas of their cell's middle lose weight as Tukey takes it from them.
REACH = 6.0
#: A reading of less weight than this is an outlier.
OUTLIER = 0.05
#: Angles whose mean is that of directions.
CIRCULAR = frozenset({"hour_angle", "ra", "wind_az", "sun_az"})


@dataclass(frozen=True)
class Middle:
    """What the first pass found.

    Attributes
    ----------
    cells
        The cells; their totals are the middles on both axes [rad], (c, 2), NaN where none.
    scale
        Scatter of a reading about its cell's middle on both axes [rad], for each set of
        labels of `cells`, shape (labels, 2); infinite where nothing tells it.
    """

    cells: Cells
    scale: Array


@dataclass(frozen=True)
class _First:
    """The first pass over a piece; to be called in any process."""

    def __call__(self, piece: Piece) -> tuple[Cells, Aside, int]:
        return _gone_through(piece, 0, _first_totals)


@dataclass(frozen=True)
class _Second:
    """The second pass over a piece."""

    middle: Middle

    def __call__(self, piece: Piece) -> tuple[Cells, Aside, int]:
        return _gone_through(
            piece, self.middle.cells.level, partial(_second_totals, middle=self.middle)
        )


def is_data_set(path: Path) -> bool:
    """Tell whether a path is a folder of Parquet files."""
    return path.is_dir() and bool(files_of(path))


def read_data_set(
    root: Path,
    given: Given = NOTHING,
    spread: Spread[Any, Any] = map,
    beside: Path | None = None,
) -> Recordings:
    """Return the normal points of a data set as recordings.

    Parameters
    ----------
    root
        A folder of Parquet files, in folders `antenna=NAME` and the like or not.
    given
        Header keys that the files do not tell.
    spread
        How the pieces are gone through: `map`, or another that keeps their order.
    beside
        Folder in which is kept how far it has come, so that it goes on when it was killed; None
        where that is not wanted. Whoever names it removes what is in there: `pass_files`.

    Returns
    -------
    Recordings
        One for each normal point; `reduction` tells how the rows became points.

    Raises
    ------
    BadInput
        With file and row: what is wrong and what was expected.
    """
    pieces, keys = pieces_of(root)
    keys |= dict(given.keys)
    one, two = passes(pieces, beside)
    first = one.through(_First(), pieces, spread)
    if first.cells is None:
        raise BadInput("no usable row in this data set", root)
    middle = _middle(first.cells)
    second = two.through(_Second(middle), pieces, spread).cells
    assert second is not None  # noqa: S101 - the rows of the first pass are still there
    fine = shrunk(second, MOST_PLACES)
    points = shrunk(fine, MOST_NUMBERS, _numbers)
    recordings = interpret(as_raw(points, root, keys))
    recordings = recordings.take(np.argsort(_times(points)[recordings.line - 1], kind="stable"))
    at = replace(recordings.at, fine=_fine(points, fine, recordings.line - 1, root, keys))
    listed = tuple(SetAside(line, f"{file}: {why}") for file, line, why in first.aside.listed)
    told = _reduction(points, fine, first.aside, first.rows)
    return replace(recordings, at=at, set_aside=listed, reduction=told)


def _times(points: Cells) -> Array:
    """Return the mean time of each cell [s]."""
    time, rows = (points.totals[:, SUMMED.index(name)] for name in ("time", "rows"))
    return np.asarray(time / rows)


def _fine(points: Cells, fine: Cells, used: Codes, root: Path, keys: dict[str, str]) -> Fine:
    """Return the places that the used points, by their number among the cells, are means of."""
    of = _places(points, fine.label, grown(fine.key, fine.level, points.level))
    order = np.argsort(of, kind="stable")
    rows = fine.totals[:, SUMMED.index("rows")]
    share = rows / np.bincount(of, rows)[of]
    at = interpret(as_raw(fine, root, keys, places_only=True)).at
    return Fine(at.take(order), of[order], share[order]).take(used)


def _gone_through(
    piece: Piece, level: int, totals_of: Callable[..., tuple[tuple[str, ...], Array]]
) -> tuple[Cells, Aside, int]:
    """Return the cells of a piece, what it set aside, and how many rows it has."""
    gathered, aside, rows = Gathered(MOST_CELLS), Aside(), 0
    nothing = np.zeros(0, np.int64)
    empty = Cells(level, (), [], nothing, nothing, (), np.zeros((0, 0)))
    for batch in piece.batches():
        chunk = chunk_of(batch, piece, piece.first_row + rows, aside)
        rows += batch.num_rows
        if len(chunk.az) == 0:
            continue
        key = key_of(chunk, level)
        first, cell = grouped(chunk.label, key)
        where = chunk.label[first], key[first]
        sums, totals = totals_of(chunk, where[0], where[1], cell)
        gathered.add(Cells(level, chunk.label_names, chunk.names, where[0], where[1], sums, totals))
    return gathered.total() if gathered.anything else empty, aside, rows


def _first_totals(
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


def _middle(first: Cells) -> Middle:
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


def _second_totals(
    chunk: Chunk, label: Codes, key: Codes, cell: Codes, middle: Middle
) -> tuple[tuple[str, ...], Array]:
    """Return weighted sums on each axis, and sums of everything else, as `points` names them."""
    count = len(key)
    own_label = _labels_in(chunk, middle.cells)
    place = _places(middle.cells, own_label[label], key)
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
            np.bincount(cell[far], weight[far] < OUTLIER, count),
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


def _places(cells: Cells, label: Codes, key: Codes) -> Codes:
    """Return where cells stand in a sorted table that has them all."""
    low = np.searchsorted(cells.label, label, side="left")
    place = np.empty(len(key), np.int64)
    for one in np.unique(label):
        mine = label == one
        start = int(low[np.argmax(mine)])
        stop = int(np.searchsorted(cells.label, one, side="right"))
        place[mine] = start + np.searchsorted(cells.key[start:stop], key[mine])
    return place


def _numbers(cells: Cells) -> int:
    """Return how many numbers the points of a second pass hold."""
    at = [SUMMED.index(name) for name in ("readings_x", "readings_y")]
    return int((cells.totals[:, at] > 0).sum())


def _reduction(points: Cells, fine: Cells, aside: Aside, rows: int) -> Reduction:
    """Return how rows became points."""
    patch, stretch = LEVELS[points.level]
    outliers = points.totals[:, [SUMMED.index(f"outliers_{a}") for a in "xy"]].sum()
    return Reduction(
        rows,
        len(points),
        len(fine),
        PATCH_DEG * 2**patch,
        None if stretch >= ALWAYS else STRETCH_S * 2**stretch,
        int(outliers),
        aside.counts,
    )
