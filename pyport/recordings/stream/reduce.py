"""From a data set to normal points, in two passes: where each cell's middle is, what counts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import Array
from pyport.effects.base import SubPointings
from pyport.errors import BadInput
from pyport.recordings.interpret import interpret
from pyport.recordings.options import NOTHING, FileOptions
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
from pyport.recordings.stream.chunk import Aside, chunk_of
from pyport.recordings.stream.middles import Middle, first_totals, middle_of
from pyport.recordings.stream.passes import MOST_CELLS, passes
from pyport.recordings.stream.pieces import Piece, files_of, pieces_of
from pyport.recordings.stream.points import SUMMED, as_raw
from pyport.recordings.stream.votes import places_of, second_totals
from pyport.workers import Spread

#: Places that effects are computed at: a point's share of an effect is the mean over its places.
MOST_PLACES = 40_000
#: Measured numbers that a diagnosis is given at most.
MOST_NUMBERS = 12_000


@dataclass(frozen=True)
class _First:
    """The first pass over a piece; to be called in any process."""

    def __call__(self, piece: Piece) -> tuple[Cells, Aside, int]:
        return _gone_through(piece, 0, first_totals)


@dataclass(frozen=True)
class _Second:
    """The second pass over a piece."""

    middle: Middle

    def __call__(self, piece: Piece) -> tuple[Cells, Aside, int]:
        return _gone_through(
            piece, self.middle.cells.level, partial(second_totals, middle=self.middle)
        )


def is_data_set(path: Path) -> bool:
    """Tell whether a path is a folder of Parquet files."""
    return path.is_dir() and bool(files_of(path))


def read_data_set(
    root: Path,
    given: FileOptions = NOTHING,
    spread: Spread[Any, Any] = map,
    beside: Path | None = None,
) -> Recordings:
    """Return the normal points of a data set as recordings.

    `root`: a folder of Parquet files, in folders `antenna=NAME` and the like or not.
    `given`: header keys that the files do not tell.
    `spread`: how the pieces are gone through: `map`, or another that keeps their order.
    `beside`: folder in which is kept how far it has come, so that it goes on when it was killed;
      None where that is not wanted. Whoever names it removes what is in there: `pass_files`.
    Returns one for each normal point; `reduction` tells how the rows became points.
    Raises `BadInput`: with file and row: what is wrong and what was expected.
    """
    pieces, keys = pieces_of(root)
    keys |= dict(given.keys)
    one, two = passes(pieces, beside)
    first = one.through(_First(), pieces, spread)
    if first.cells is None:
        raise BadInput("no usable row in this data set", root)
    middle = middle_of(first.cells)
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


def _fine(
    points: Cells, fine: Cells, used: Codes, root: Path, keys: dict[str, str]
) -> SubPointings:
    """Return the places that the used points, by their number among the cells, are means of."""
    of = places_of(points, fine.label, grown(fine.key, fine.level, points.level))
    order = np.argsort(of, kind="stable")
    rows = fine.totals[:, SUMMED.index("rows")]
    share = rows / np.bincount(of, rows)[of]
    at = interpret(as_raw(fine, root, keys, places_only=True)).at
    return SubPointings(at.take(order), of[order], share[order]).take(used)


def _gone_through(
    piece: Piece, level: int, totals_of: Callable[..., tuple[tuple[str, ...], Array]]
) -> tuple[Cells, Aside, int]:
    """Return the cells of a piece, what it excluded, and how many rows it has."""
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
