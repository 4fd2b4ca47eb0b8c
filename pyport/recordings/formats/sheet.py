"""Sheets: any delimited text, with a line of column names or without, however it is delimited."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.recordings.formats.cells import are_units, joined
from pyport.recordings.formats.text import is_separator, read_text
from pyport.recordings.naming import comment

#: Signs between columns, in the order in which they are tried; None for blanks.
DELIMITERS = (",", ";", "\t", "|", None)
#: So many rows tell how a table is delimited.
LOOKED_AT = 50


@dataclass(frozen=True)
class Sheet:
    """A delimited table: header keys, names ("" where it has none), cells, and lines.

    `units` are those of a line below the names, "" where it tells none, empty without such a line.
    """

    path: Path
    meta: dict[str, str]
    names: tuple[str, ...]
    header_line: int
    rows: list[list[str]]
    lines: list[int]
    units: tuple[str, ...] = ()

    def column(self, n: int) -> NDArray[Any]:
        """Return a column's cells."""
        return np.array([row[n].strip() for row in self.rows], object)


def sheet(path: Path) -> Sheet:
    """Read any delimited text with a line of names, behind a # or not, or with none.

    Raises `BadInput`: it is no table: rows have different numbers of cells, however they are taken.
    """
    meta, remarks, body = _lines(path)
    delimiter, width = _delimited(path, body)
    rows = [_cells(text, delimiter) for _, text in body]
    lines = [number for number, _ in body]
    names, header = _names(rows, remarks, delimiter, width)
    if header == 0 and names:
        header, rows, lines = lines[0], rows[1:], lines[1:]
    units: tuple[str, ...] = ()
    if names and len(rows) > 1 and len(rows[0]) == width and are_units(rows[0]):
        units, rows, lines = tuple(rows[0]), rows[1:], lines[1:]
    if len(names) > width:
        raise BadInput(f"{len(names)} names above rows of {width} cells", path, max(header, 1))
    for row, line in zip(rows, lines, strict=True):
        if len(row) != width:
            count = f"{len(row)} cell{'s' * (len(row) != 1)}"
            raise BadInput(f"{count}, expected {width} as in the others", path, line)
    if not rows:
        raise BadInput("no rows below the column names", path, header)
    return Sheet(path, meta, names, max(header, 1), rows, lines, units)


def _lines(path: Path) -> tuple[dict[str, str], list[tuple[int, str]], list[tuple[int, str]]]:
    """Return header keys, other comments above the rows, and all that is no comment."""
    meta: dict[str, str] = {}
    remarks: list[tuple[int, str]] = []
    body: list[tuple[int, str]] = []
    for number, line in enumerate(read_text(path).splitlines(), 1):
        text = line.strip()
        if text.startswith(("#", "!")):
            pair = comment(text.lstrip("#!"))
            if pair is not None:
                meta[pair[0]] = pair[1]
            elif not body:
                remarks.append((number, text.lstrip("#!").strip()))
        elif text and (body or not is_separator(text)):
            body.append((number, line.strip(" ")))
    if not body:
        raise BadInput("no rows, expected a table", path)
    return meta, remarks, body


def _delimited(path: Path, body: Sequence[tuple[int, str]]) -> tuple[str | None, int]:
    """Return the sign between columns and how many there are, of most rows if not of all."""
    found = []
    for one in DELIMITERS:
        counts = [len(_cells(text, one)) for _, text in body[1:LOOKED_AT] or body]
        width, rows = Counter(counts).most_common(1)[0]
        # a decimal comma stands in the rows, and not between the names above them
        as_named = len(_cells(body[0][1], one)) == width > 1
        found.append((rows == len(counts), as_named, width, rows > len(counts) / 2, one))
    same = [one for one in found if one[0] and one[2] > 1]
    usual = [one for one in found if one[1] and one[3]]
    if not same and not usual:
        raise _uneven(path, body)
    _, _, width, _, delimiter = max(same or usual, key=lambda one: (one[1], one[2]))
    return delimiter, width


def _uneven(path: Path, body: Sequence[tuple[int, str]]) -> BadInput:
    """Return what is wrong with the first row that has another number of cells than the first."""
    counts = {one: [len(_cells(text, one)) for _, text in body] for one in DELIMITERS}
    likely = max(counts.values(), key=lambda those: (those[0] > 1) * those.count(those[0]))
    odd = next((n for n, count in enumerate(likely) if count != likely[0]), 0)
    cells = f"{likely[odd]} cell{'s' * (likely[odd] != 1)}"
    usual = f"{likely[0]} as in line {body[0][0]} of " if odd else ""
    wanted = f"expected {usual}a table delimited by commas, semicolons, tabs, bars or blanks"
    return BadInput(f"{cells}, {wanted}", path, body[odd][0])


def _cells(text: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return joined(text).split()
    return next(csv.reader([text], delimiter=delimiter, skipinitialspace=True), [])


def _names(
    rows: Sequence[list[str]],
    remarks: Sequence[tuple[int, str]],
    delimiter: str | None,
    width: int,
) -> tuple[tuple[str, ...], int]:
    """Return the names of columns and their line; line 0 where they are the first row."""
    for number, text in reversed(remarks):
        cells = _cells(text, delimiter)
        if len(cells) == width and not are_units(cells):
            return tuple(one.strip() for one in cells), number
    first = [one.strip() for one in rows[0]]
    below = rows[2:3] if len(rows) > 1 and are_units(rows[1]) else rows[1:2]
    if below and not any(map(_is_number, first)) and any(map(_is_number, below[0])):
        return tuple(first), 0
    return (), 1


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True
