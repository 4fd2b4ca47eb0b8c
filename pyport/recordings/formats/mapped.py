"""Tables whose columns have other names: any delimited text, by a map to the contract's columns.

A map has an entry for each column that is wanted: its name here, and where it comes from. That is
a column's name (a format behind it in brackets, as in `AZd(f0)`, may be left out) or number, from
1; `-NAME` for the opposite sign, and `NAME|date`, `|mjd`, `|jd`, `|unix` for a part of a text or
another count of time.
"""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
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
from pyport.files import write_file
from pyport.recordings.formats.csv import read_text
from pyport.recordings.formats.sheet import Sheet, sheet
from pyport.recordings.raw import Raw
from pyport.toml_text import toml_spelled

_FORMAT = re.compile(r"\([^()]*\)$")
_DATE = re.compile(r"\d{4}-\d{2}-\d{2}")
_ISO = re.compile(_DATE.pattern + r"[T ]\d{2}:\d{2}.*")
_MJD_OF_1970, _JD_OF_1970 = 40587.0, 2440587.5


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
    write_file(path, toml_spelled({"columns": dict(columns)}))


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
#: A unit as a header or a name tells it of a column: `offset_az: observed - true [deg]`.
_TOLD = re.compile(rf"\s*[\[(]({'|'.join(_UNITS)})[\])]")
#: What the header says of an offset that is counted the other way: the place less what was read.
_OPPOSITE = re.compile(
    r"(true|catalog\w*|command\w*|demand\w*)\s*(-|minus)\s*(obs|meas|read|enc)\w*"
)


#: Columns that have one name and unit, ours.
_OURS = LABELS | NUMBERS | {TIME, DAY, HOUR_OF_DAY, SCAN_RATE, "wind_az_deg"}


def propose(table: Sheet) -> dict[str, str]:
    """Return a map of columns by what their names say; angles without a unit are guessed.

    Unit and sign are the name's, or the header's of it; else directions are taken for degrees,
    offsets for arcseconds and as observed less true. A date with a time of day is the time, a label
    that begins with a date tells the session.
    """
    found = _by_names(table.names, table.meta)
    if not found:
        return {}
    first = zip(table.names, next(iter(table.rows), ()), strict=False)
    dated = {
        bare: cell.strip()
        for name, cell in first
        if (bare := _FORMAT.sub("", name).strip()) and _DATE.match(cell.strip())
    }
    moments = [name for name, cell in dated.items() if _ISO.fullmatch(cell)]
    if moments and not {TIME, DAY} & set(found):
        found[TIME] = moments[0]
    if dated and not {"session", TIME} & set(found):
        day = f"{next(iter(dated))}|date"
        found["session"] = day
        if HOUR_OF_DAY in found:
            found.setdefault(DAY, day)
    return found


def _by_names(names: Sequence[str], told: Mapping[str, str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for name in names:
        bare = _FORMAT.sub("", name).strip()
        said = told.get(bare, "").lower()
        if angle_of(bare) is not None or bare in _OURS:
            found[bare] = bare
            continue
        spoken = _TOLD.sub("", bare.lower())
        unit = next((one for one in _UNITS if spoken.endswith(one)), "")
        plain = re.sub(r"[.\s\-]+", "_", spoken.removesuffix(unit)).strip("_")
        if not unit and (there := _TOLD.search(name.lower()) or _TOLD.search(said)):
            unit = there[1]
        for pattern, quantity in _CALLED:
            if re.fullmatch(pattern, plain) is None:
                continue
            ours, _, part = quantity.partition("|")
            if ours not in _OURS:
                offset = ours.startswith(("d_", "sigma_"))
                ours = f"{ours}_{unit or ('arcsec' if offset else 'deg')}"
            if ours not in found or "true" in plain:
                sign = "-" if ours.startswith("d_") and _OPPOSITE.search(said) else ""
                found[ours] = sign + bare + (f"|{part}" if part else "")
            break
    if any(one.startswith("d_xel") for one in found):
        found = {key: value for key, value in found.items() if not key.startswith("d_az")}
    return found
