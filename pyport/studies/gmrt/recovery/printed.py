"""The tables as printed: rows of cells, nothing interpreted but who stands where."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parent / "printed"

#: An offset as the tables print it: a sign and three digits.
OFFSET = re.compile(r"[+-]\d{3}")

#: An antenna's name.
LABEL = re.compile(r"[CESW]\d\d")

#: Numbers that stand for "no peak found".
NO_PEAK = (999, 99)


@dataclass(frozen=True)
class Row:
    """A printed row: its number below the titles (from 1), its first cells and its offsets."""

    number: int
    head: tuple[str, ...]
    offsets: tuple[str, ...]

    def column(self, position: int) -> int:
        """Return the printed column (from 1) of an offset, counted with the head's cells."""
        return len(self.head) + position + 1


def lines(table: int) -> list[list[str]]:
    """Return the cells of each line of a table, as printed."""
    text = (FOLDER / f"table_{table}.tsv").read_text("utf-8")
    return [line.split("\t") for line in text.splitlines()]


def day(table: int) -> tuple[Row, ...]:
    """Return the rows of one of the tables 14 to 17: hour angle, elevation, then offsets."""
    body = lines(table)[1:]
    return tuple(Row(n, tuple(row[:2]), tuple(row[2:])) for n, row in enumerate(body, 1))


def antennas_down(table: int = 13) -> tuple[Row, ...]:
    """Return the rows of Table 13: one antenna (or two labels run together), then offsets."""
    rows = []
    for number, cells in enumerate(lines(table)[2:], 1):
        labels = next((n for n, cell in enumerate(cells) if not LABEL.fullmatch(cell)), len(cells))
        rows.append(Row(number, tuple(cells[:labels]), tuple(cells[labels:])))
    return tuple(rows)


def scans_across(table: int = 13) -> list[tuple[int, int]]:
    """Return direction (p is +1, m is -1) and elevation [deg] of each scan of Table 13."""
    titles = " ".join(lines(table)[1])
    signs = {"p": 1, "m": -1}
    return [(signs[sign], int(el)) for sign, el in re.findall(r"([pm])(\d+)", titles)]


def number(cell: str) -> float:
    """Return a printed number [arcmin], NaN where the cell is no sign and three digits."""
    return float(cell) if OFFSET.fullmatch(cell) else math.nan


def minutes(cell: str) -> int | None:
    """Return a printed offset [arcmin], None where the cell is no offset or no peak."""
    if not OFFSET.fullmatch(cell) or abs(int(cell)) == NO_PEAK[0]:
        return None
    return int(cell)
