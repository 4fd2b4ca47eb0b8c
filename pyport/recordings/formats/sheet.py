"""Sheets: any delimited text, with a line of column names or without, however it is delimited."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.recordings.formats.csv import comment, read_text

#: Signs between columns, in the order in which they are tried; None for blanks.
DELIMITERS = (",", ";", "\t", "|", None)
#: So many rows tell how a table is delimited.
LOOKED_AT = 50


@dataclass(frozen=True)
class Sheet:
    """A delimited table: header keys, names ("" where it has none), cells, and lines."""

    path: Path
    meta: dict[str, str]
    names: tuple[str, ...]
    header_line: int
    rows: list[list[str]]
    lines: list[int]

    def column(self, n: int) -> NDArray[Any]:
        """Return a column's cells."""
        return np.array([row[n].strip() for row in self.rows], object)


def sheet(path: Path) -> Sheet:
    """Read any delimited text with a line of names, behind a # or not, or with none.

    Raises `BadInput`: it is no table: rows have different numbers of cells, however they are taken.
    """
    meta, remarks, body = _lines(path)
    widths = {one: _consistent(body, one) for one in DELIMITERS}
    # a decimal comma stands in the rows, and not between the names above them
    as_named = {one for one, n in widths.items() if len(_cells(body[0][1], one)) == n > 1}
    delimiter, width = max(widths.items(), key=lambda one: (one[0] in as_named, one[1]))
    if width < 2:
        wanted = "expected a table delimited by commas, semicolons, tabs, bars or blanks"
        raise BadInput(f"rows have different numbers of cells: {wanted}", path, body[0][0])
    rows = [_cells(text, delimiter) for _, text in body]
    lines = [number for number, _ in body]
    names, header = _names(rows, remarks, delimiter)
    if header == 0 and names:
        header, rows, lines = lines[0], rows[1:], lines[1:]
    if len(names) > width:
        raise BadInput(f"{len(names)} names above rows of {width} cells", path, max(header, 1))
    for row, line in zip(rows, lines, strict=True):
        if len(row) != width:
            raise BadInput(f"{len(row)} cells, expected {width} as in the others", path, line)
    if not rows:
        raise BadInput("no rows below the column names", path, header)
    return Sheet(path, meta, names, max(header, 1), rows, lines)


def _lines(path: Path) -> tuple[dict[str, str], list[tuple[int, str]], list[tuple[int, str]]]:
    """Return header keys, other comments above the rows, and all that is no comment."""
    meta: dict[str, str] = {}
    remarks: list[tuple[int, str]] = []
    body: list[tuple[int, str]] = []
    for number, line in enumerate(read_text(path).splitlines(), 1):
        text = line.strip()
        pair = comment(text) if text.startswith("#") else None
        if pair is not None:
            meta[pair[0]] = pair[1]
        elif text.startswith("#") and not body:
            remarks.append((number, text.lstrip("#").strip()))
        elif text and not text.startswith("#"):
            body.append((number, text))
    if not body:
        raise BadInput("no rows, expected a table", path)
    return meta, remarks, body


def _consistent(body: Sequence[tuple[int, str]], delimiter: str | None) -> int:
    """Return how many cells each row has, 0 where they differ."""
    counts = {len(_cells(text, delimiter)) for _, text in body[1:LOOKED_AT] or body}
    return counts.pop() if len(counts) == 1 else 0


def _cells(text: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return text.split()
    return next(csv.reader([text], delimiter=delimiter, skipinitialspace=True), [])


def _names(
    rows: Sequence[list[str]], remarks: Sequence[tuple[int, str]], delimiter: str | None
) -> tuple[tuple[str, ...], int]:
    """Return the names of columns and their line; line 0 where they are the first row."""
    width = len(rows[-1])
    for number, text in reversed(remarks):
        told = _cells(text, delimiter)
        if len(told) == width:
            return tuple(one.strip() for one in told), number
    first = [one.strip() for one in rows[0]]
    if len(rows) > 1 and not any(map(_is_number, first)) and any(map(_is_number, rows[1])):
        return tuple(first), 0
    return (), 1


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True
