"""A file's cells before anything is made of them, and how a cell becomes a number or a word."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.errors import BadInput
from pyport.recordings.text_column import TextColumn

#: Numpy pads text to its longest cell: one runaway cell would cost its length in every row.
LONGEST_CELL, LARGEST_COLUMN = 1000, 2**28


@dataclass(frozen=True)
class Raw:
    """Columns of n cells as they stand in a file."""

    file: Path  #: the file as the user named it
    meta: dict[str, str]  #: its `key: value` lines, as text
    header_line: int  #: the line of the column names, for errors that concern a whole column
    #: Name -> cells, shape (n,): text ("" for blank), of a large file held by Arrow, or numbers
    #: (NaN for blank).
    columns: Mapping[str, NDArray[Any] | TextColumn]
    line: NDArray[np.int64]  #: the line (or row) of each cell, shape (n,)

    def error(self, message: str, row: int | None = None) -> BadInput:
        """Return an error that names the file and the row's line, or the header's."""
        return BadInput(message, self.file, self.header_line if row is None else self.line[row])

    def words(self, name: str) -> NDArray[np.str_]:
        """Return a column as text without surrounding blanks.

        Raises `BadInput`: a cell is so long that it is none.
        """
        cells = self.columns[name]
        if cells.dtype.kind in "fiub":
            # 130.0 names the same channel as 130
            return np.array(["" if v != v else f"{v:.15g}" for v in cells.tolist()], np.str_)  # noqa: PLR0124
        different, which = (
            cells.distinct() if isinstance(cells, TextColumn) else (cells.tolist(), slice(None))
        )
        text = [str(cell).strip() for cell in different]
        longest = max(map(len, text), default=0)
        if longest > LONGEST_CELL or longest * len(cells) > LARGEST_COLUMN:
            long = np.array([len(cell) == longest for cell in text])[which]
            most = min(LONGEST_CELL, LARGEST_COLUMN // len(cells))
            raise self.error(f"{name} has more than {most} characters", int(np.argmax(long)))
        return np.array(text, np.str_)[which]

    def numbers(self, name: str) -> Array:
        """Return a column as numbers, NaN where it is blank.

        Raises `BadInput`: a cell is neither blank nor a finite number.
        """
        cells = self.columns[name]
        if isinstance(cells, TextColumn):
            if (values := cells.numbers()) is not None:
                return values
            cells = np.asarray(cells)
        if cells.dtype.kind in "fiub":
            values = cells.astype(float)
        else:
            try:
                values = np.array([float(cell or "nan") for cell in cells.tolist()])
            except (TypeError, ValueError):
                values = self._numbers_one_by_one(name)
        self.refuse(np.isinf(values), f"{name} is infinite, expected a number or blank")
        return values

    def _numbers_one_by_one(self, name: str) -> Array:
        """Return a column as numbers where some cells are spaces, or say which is no number."""
        values = np.full(len(self.line), np.nan)
        for row, cell in enumerate(self.words(name).tolist()):
            try:
                values[row] = float(cell or "nan")
            except ValueError:
                wrong = f"{name} is {cell!r}, expected a number or blank"
                raise self.error(wrong, row) from None
        return values

    def numbers_or_words(self, name: str) -> NDArray[Any]:
        """Return a column as numbers if all its cells are, else as text."""
        try:
            return self.numbers(name)
        except BadInput:
            return self.words(name)

    def seconds(self, name: str) -> Array:
        """Return ISO 8601 times as seconds (UTC) since 1970, NaN where blank.

        Raises `BadInput`: a cell is neither blank nor an ISO 8601 time.
        """
        cells = self.columns[name]
        if isinstance(cells, TextColumn):
            if (values := cells.seconds()) is not None:
                return values
            cells = np.asarray(cells)
        if cells.dtype.kind == "M":
            since = cells.astype("datetime64[us]").astype(float) / 1e6
            return np.where(np.isnat(cells), np.nan, since)
        text = self.words(name)
        seconds = np.full(len(text), np.nan)
        for row, cell in enumerate(text.tolist()):
            if not cell:
                continue
            try:
                instant = datetime.fromisoformat(cell)
            except ValueError:
                wanted = "expected ISO 8601 such as 2003-06-01T18:37:12Z"
                raise self.error(f"{name} is {cell!r}, {wanted}", row) from None
            if instant.tzinfo is None:
                instant = instant.replace(tzinfo=UTC)
            seconds[row] = instant.timestamp()
        return seconds

    def refuse(self, wrong: NDArray[np.bool_], message: str) -> None:
        """Raise `BadInput` at the first row where `wrong` holds."""
        if wrong.any():
            raise self.error(message, int(np.argmax(wrong)))
