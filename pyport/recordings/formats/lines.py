"""Lines of text files with their numbers, and the numbers in them, with errors that name both."""

from __future__ import annotations

from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pyport.errors import BadInput
from pyport.recordings.formats.csv import read_text
from pyport.recordings.raw import Raw

#: Digits are kept as they stand, so no line may make them endless.
LONGEST_NUMBER = 40


class Line(NamedTuple):
    """A line of a file, where it stands, and what it says."""

    file: Path
    number: int
    text: str

    @property
    def words(self) -> list[str]:
        """Return what stands between blanks."""
        return self.text.split()

    def error(self, message: str) -> BadInput:
        """Return an error that names this line."""
        return BadInput(message, self.file, self.number)

    def decimal(self, word: str, what: str) -> Decimal:
        """Return a number as it stands, digit for digit.

        Raises `BadInput`: it is no finite number, or longer than any measurement is.
        """
        try:
            value = Decimal(word)
        except InvalidOperation:
            value = Decimal("nan")
        if not value.is_finite() or len(word) > LONGEST_NUMBER or abs(value.adjusted()) > 99:
            raise self.error(f"{what} is {word[:60]!r}, expected a number")
        return value


def lines_of(path: Path) -> list[Line]:
    """Return all lines of a text file.

    Raises `BadInput`: the file is empty or is no text.
    """
    return [Line(path, n, text) for n, text in enumerate(read_text(path).splitlines(), 1)]


def spelled(value: Decimal) -> str:
    """Return a decimal number without an exponent, digit for digit."""
    text = str(value)  # four times as fast, and without an exponent for nearly all numbers
    return text if "E" not in text else format(value, "f")


def padded(value: Decimal, width: int, decimals: int, sign: str = "") -> str:
    """Return a number of some width with at least so many decimals, and all that it has."""
    exponent = value.as_tuple().exponent
    own = -exponent if isinstance(exponent, int) else 0
    return f"{value:{sign}{width}.{max(decimals, own)}f}"


def raw_of(
    path: Path, meta: dict[str, str], columns: dict[str, list[str]], lines: list[int], header: int
) -> Raw:
    """Return cells of text, as they stand, for the interpretation that all formats share."""
    cells = {name: np.array(column, object) for name, column in columns.items()}
    return Raw(path, meta, header, cells, np.array(lines, np.int64))
