"""Tables whose columns have other names: any delimited text, by a map to the contract's columns.

A map has an entry for each column that is wanted: its name here, and where it comes from. That is
a column's name (a format behind it in brackets, as in `AZd(f0)`, may be left out) or number, from
1; `-NAME` for the opposite sign, and `NAME|date`, `|mjd`, `|jd`, `|unix` for a part of a text or
another count of time.
"""

from __future__ import annotations

import csv
import difflib
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.columns import (
    ANGLE,
    COLUMNS,
    DAY,
    HOUR_OF_DAY,
    LABELS,
    NUMBERS,
    SCAN_RATE,
    TIME,
    angle_of,
)
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.recordings.formats.csv import comment, read_text
from pyport.recordings.raw import Raw
from pyport.toml_text import toml_spelled

#: Signs between columns, in the order in which they are tried; None for blanks.
DELIMITERS = (",", ";", "\t", "|", None)
#: So many rows tell how a table is delimited.
LOOKED_AT = 50
_FORMAT = re.compile(r"\([^()]*\)$")
_DATE = re.compile(r"\d{4}-\d{2}-\d{2}")
_MJD_OF_1970, _JD_OF_1970 = 40587.0, 2440587.5


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


def read(path: Path, columns: Mapping[str, str]) -> Raw:
    """Read the cells of a delimited text by a map of its columns.

    Raises `BadInput`: it is no table, or has not what the map says.
    """
    table = sheet(path)
    return mapped(
        Raw(
            path,
            table.meta,
            table.header_line,
            {
                name: table.column(n)
                for n, name in enumerate(table.names or map(str, range(1, len(table.rows[0]) + 1)))
            },
            np.array(table.lines, np.int64),
        ),
        columns,
        numbered=True,
    )


def mapped(raw: Raw, columns: Mapping[str, str], *, numbered: bool = False) -> Raw:
    """Return the cells of a table under the contract's names, those that a map names.

    Raises `BadInput`: the map names a column that the table has not, or one that is none here.
    """
    found: dict[str, NDArray[Any]] = {}
    for ours, theirs in columns.items():
        _check(ours)
        name, _, part = theirs.partition("|")
        negative = name.startswith("-")
        cells = _found(raw, name.lstrip("-").strip(), numbered=numbered)
        if part:
            if part.strip() not in PARTS:
                raise BadInput(f"--columns {ours}={theirs}: expected one of {', '.join(PARTS)}")
            cells = _each(raw, ours, cells, PARTS[part.strip()])
        found[ours] = _each(raw, ours, cells, _negated) if negative else cells
    return replace(raw, columns=found)


def _found(raw: Raw, name: str, *, numbered: bool) -> NDArray[Any]:
    """Return a column by its name, with or without a format behind it, or by its number."""
    if name in raw.columns:
        return np.asarray(raw.columns[name])
    bare = {_FORMAT.sub("", one).strip(): one for one in raw.columns}
    if name in bare:
        return np.asarray(raw.columns[bare[name]])
    if numbered and name.isdigit() and 1 <= int(name) <= len(raw.columns):
        return np.asarray(list(raw.columns.values())[int(name) - 1])
    near = difflib.get_close_matches(name, bare, 1)
    meant = f"did you mean {near[0]!r}?" if near else f"it has {', '.join(list(bare)[:20])}"
    raise raw.error(f"--columns: no column {name!r}: {meant}")


def _check(ours: str) -> None:
    """Refuse a name that is nearly one of the contract's."""
    from pyport.recordings.naming import meant

    if angle_of(ours) is None and (right := meant(ours)) is not None:
        raise BadInput(f"--columns {ours}=...: did you mean {right!r}?")


def _each(raw: Raw, name: str, cells: NDArray[Any], change: Callable[[str], str]) -> NDArray[Any]:
    out = []
    for row, cell in enumerate(cells.tolist()):
        text = str(cell).strip()
        try:
            out.append(change(text) if text else "")
        except (ValueError, OverflowError):
            raise raw.error(f"{name} is {text[:40]!r}, expected what the map says", row) from None
    return np.array(out, object)


def _date(text: str) -> str:
    match = _DATE.search(text)
    if match is None:
        raise ValueError(text)
    return match[0]


def _negated(text: str) -> str:
    return text[1:] if text.startswith("-") else f"-{text.lstrip('+')}" if float(text) else text


def _moment(seconds: float) -> str:
    return datetime.fromtimestamp(seconds, UTC).isoformat().replace("+00:00", "Z")


#: What can be taken of a column.
PARTS: dict[str, Callable[[str], str]] = {
    "date": _date,
    "mjd": lambda text: _moment((float(text) - _MJD_OF_1970) * 86400),
    "jd": lambda text: _moment((float(text) - _JD_OF_1970) * 86400),
    "unix": lambda text: _moment(float(text)),
}


def parse(text: str) -> dict[str, str]:
    """Return a map from `OURS=THEIRS, ...` or from the TOML file that `look` keeps.

    Raises `BadInput`: it is neither.
    """
    if text.endswith(".toml"):
        return load(Path(text))
    found = {}
    for one in text.split(","):
        ours, equals, theirs = one.partition("=")
        if not equals or not ours.strip() or not theirs.strip():
            raise BadInput(f"--columns {one.strip()[:40]!r}, expected NAME=NAME HERE")
        found[ours.strip()] = theirs.strip()
    return found


def load(path: Path) -> dict[str, str]:
    """Return the map that a TOML file keeps.

    Raises `BadInput`: there is no such file, or it keeps none.
    """
    if not path.is_file():
        raise BadInput("no such file, expected a map of columns", path)
    try:
        told = tomllib.loads(read_text(path)).get("columns")
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"not a TOML file: {error}", path) from None
    if not isinstance(told, dict) or not told:
        raise BadInput("no [columns] table, expected one such as az_deg = 'AZd'", path)
    return {str(key): str(value) for key, value in told.items()}


def save(columns: Mapping[str, str], path: Path) -> None:
    """Keep a map in a small TOML file."""
    with write_whole(path) as file:
        file.write(toml_spelled({"columns": dict(columns)}))


#: What other people call a column: a pattern, and the contract's quantity.
_CALLED: tuple[tuple[str, str], ...] = (
    *(
        (one.called, one.name if one.kind == ANGLE and not one.spoken else one.spelled)
        for one in COLUMNS
        if one.called
    ),
    (r"(time_?)?mjd(_?utc)?", f"{TIME}|mjd"),
    (r"(time_?)?jd(_?utc)?", f"{TIME}|jd"),
)
_UNITS = ("arcsec", "arcmin", "mdeg", "deg", "rad")


def propose(table: Sheet) -> dict[str, str]:
    """Return a map of columns by what their names say; angles without a unit are guessed.

    Directions are taken for degrees, offsets for arcseconds. A label that begins with a date
    tells the session.
    """
    found = _by_names(table.names)
    if found and not {"session", TIME} & set(found):
        cells = zip(table.names, next(iter(table.rows), ()), strict=False)
        dated = [name for name, cell in cells if _DATE.match(cell)]
        for name in (_FORMAT.sub("", one).strip() for one in dated[:1]):
            found["session"] = f"{name}|date"
            if HOUR_OF_DAY in found:
                found.setdefault(DAY, f"{name}|date")
    return found


def _by_names(names: Sequence[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for name in names:
        bare = _FORMAT.sub("", name).strip()
        unit = next((one for one in _UNITS if bare.lower().endswith(one)), "")
        plain = re.sub(r"[.\s\-]+", "_", bare.lower().removesuffix(unit)).strip("_")
        for pattern, quantity in _CALLED:
            if re.fullmatch(pattern, plain) is None:
                continue
            ours, _, part = quantity.partition("|")
            if ours not in LABELS | NUMBERS | {TIME, DAY, HOUR_OF_DAY, SCAN_RATE, "wind_az_deg"}:
                offset = ours.startswith(("d_", "sigma_"))
                ours = f"{ours}_{unit or ('arcsec' if offset else 'deg')}"
            if ours not in found:
                found[ours] = bare + (f"|{part}" if part else "")
            break
    if any(one.startswith("d_xel") for one in found):
        found = {key: value for key, value in found.items() if not key.startswith("d_az")}
    return found
