"""From a data set to normal points, in two passes: where each cell's middle is, what counts."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import Array
from pyport.effects.base import SubPointings
from pyport.errors import BadInput
from pyport.recordings import naming
from pyport.recordings.interpret import interpret
from pyport.recordings.raw import FileOptions
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
from pyport.recordings.stream.pieces import CHUNK_ROWS, Piece, files_of, pieces_of
from pyport.recordings.stream.points import (
    SUMMED,
    Middle,
    as_raw,
    first_totals,
    middle_of,
    places_of,
    second_totals,
)
from pyport.recordings.stream.sample import notes
from pyport.runs.checkpoint import Checkpoint, State
from pyport.runs.workers import Spread

#: Cells that are kept while the data set is gone through: what bounds the memory.
MOST_CELLS = 300_000
#: The end of a Parquet file, which tells where everything in it stands and its extremes.
_END_BYTES = 1 << 16


class Pass:
    """What the pieces gone through so far add up to.

    `cells`: the sum of all pieces, None where none has a usable row.
    `aside`, `rows`: what was excluded, and how many rows were read.
    """

    def __init__(self, kept: Checkpoint):
        self._kept = kept
        self._done = 0
        self._gathered = Gathered(MOST_CELLS)
        self.cells: Cells | None = None
        self.aside, self.rows = Aside(), 0
        if (state := kept.load()) is not None:
            state_of, arrays = state
            self._done, self.rows = state_of["done"], state_of["rows"]
            self._gathered = Gathered.of_state(MOST_CELLS, state_of["tables"], arrays)
            listed = [(str(file), int(row), str(why)) for file, row, why in state_of["listed"]]
            self.aside = Aside(dict(state_of["counts"]), listed)

    def through(
        self,
        reading: Callable[[Piece], tuple[Cells, Aside, int]],
        pieces: Sequence[Piece],
        spread: Spread[Any, Any],
    ) -> Pass:
        """Go through the pieces that are left and add up what they say, in their order."""
        left = pieces[self._done :]
        for cells, set_aside, count in spread(reading, left):
            if len(cells):
                self._gathered.add(cells)
            self.aside.add(set_aside)
            self.rows += count
            self._done += 1
            self._kept.offer(self._state)
        if self._gathered.anything:
            self.cells = self._gathered.total()
        if left:
            self._kept.close(self._state)
        return self

    def _state(self) -> State:
        tables, arrays = self._gathered.as_state()
        kept = {"done": self._done, "rows": self.rows, "tables": tables}
        return kept | {"counts": self.aside.counts, "listed": self.aside.listed}, arrays


def passes(pieces: Sequence[Piece], beside: Path | None) -> tuple[Pass, Pass]:
    """Return both passes over a data set, as far as they came when its output was last begun."""
    what = [] if beside is None else [CHUNK_ROWS, _described(pieces)]
    first, second = [None, None] if beside is None else pass_files(beside)
    return Pass(Checkpoint(first, "first", *what)), Pass(Checkpoint(second, "second", *what))


def pass_files(beside: Path) -> tuple[Path, Path]:
    """Return the files in a folder in which is kept how far the passes have come."""
    return beside / "unfinished-pass-1.npz", beside / "unfinished-pass-2.npz"


def _described(pieces: Sequence[Piece]) -> list[Any]:
    """Return what tells one data set from another without reading it: the ends of its files."""
    ends: dict[Path, tuple[int, int, str]] = {}
    for file in dict.fromkeys(piece.file for piece in pieces):
        about = file.stat()
        with file.open("rb") as opened:
            opened.seek(max(0, about.st_size - _END_BYTES))
            end = hashlib.sha256(opened.read()).hexdigest()
        ends[file] = about.st_size, about.st_mtime_ns, end
    return [(str(piece.file), piece.groups, piece.first_row, *ends[piece.file]) for piece in pieces]


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
    root: Path, given: FileOptions, spread: Spread[Any, Any], beside: Path | None
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
    keys = _keys(root, keys, given)
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
    time, rows = (points.totals[:, SUMMED.index(name)] for name in ("time", "rows"))
    order = np.argsort((time / rows)[recordings.line - 1], kind="stable")
    recordings = recordings.take(order)
    at = replace(recordings.at, fine=_fine(points, fine, recordings.line - 1, root, keys))
    listed = tuple(SetAside(line, f"{file}: {why}") for file, line, why in first.aside.listed)
    reduction = _reduction(points, fine, first.aside, first.rows)
    said = tuple(notes(root, pieces, keys))
    return replace(recordings, at=at, set_aside=listed, reduction=reduction, notes=said)


def _keys(root: Path, keys: dict[str, str], given: FileOptions) -> dict[str, str]:
    """Return the header keys of the files and those that were given, as of a single file.

    Raises `BadInput`: one is nearly the contract's.
    """
    naming.refuse_slips(given.keys, "--set ")
    try:
        naming.refuse_keys(given.keys, "--set ")
        naming.refuse_keys(keys, "header key ")
    except BadInput as error:
        raise BadInput(error.message, root) from None
    return naming.as_keys(keys) | dict(given.keys)


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
