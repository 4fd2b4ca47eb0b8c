"""A pass over all pieces of a data set, which can be killed and goes on where it was."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pyport.checkpoint import Checkpoint, State
from pyport.recordings.stream.cells import Cells, Gathered
from pyport.recordings.stream.chunk import Aside
from pyport.recordings.stream.pieces import CHUNK_ROWS, Piece
from pyport.workers import Spread

#: Cells that are kept while the data set is gone through: what bounds the memory.
MOST_CELLS = 300_000
#: The end of a Parquet file, which tells where everything in it stands and its extremes.
_END_BYTES = 1 << 16


class Pass:
    """What the pieces gone through so far add up to.

    Attributes
    ----------
    cells
        The sum of all pieces, None where none has a usable row.
    aside, rows
        What was excluded, and how many rows were read.
    """

    def __init__(self, kept: Checkpoint):
        self._kept = kept
        self._done = 0
        self._gathered = Gathered(MOST_CELLS)
        self.cells: Cells | None = None
        self.aside, self.rows = Aside(), 0
        if (state := kept.load()) is not None:
            told, arrays = state
            self._done, self.rows = told["done"], told["rows"]
            self._gathered = Gathered.of_state(MOST_CELLS, told["tables"], arrays)
            listed = [(str(file), int(row), str(why)) for file, row, why in told["listed"]]
            self.aside = Aside(dict(told["counts"]), listed)

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
        told = {"done": self._done, "rows": self.rows, "tables": tables}
        return told | {"counts": self.aside.counts, "listed": self.aside.listed}, arrays


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
