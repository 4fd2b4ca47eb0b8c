"""Tables whose columns have other names: any delimited text, by a map to the contract's columns.

A map has an entry for each column that is wanted: its name here, and where it comes from. That is
a column's name (a format behind it in brackets, as in `AZd(f0)`, may be left out) or number, from
1; `-NAME` for the opposite sign, and `NAME|date`, `|mjd`, `|jd`, `|unix`, `|dms` for a part of a
text, another count of time, or degrees with colons.
"""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import RADIANS_PER
from pyport.arguments import nearest
from pyport.columns import (
    COLUMNS,
    DAY,
    HOUR_OF_DAY,
    LABELS,
    NUMBERS,
    SCAN_RATE,
    TIME,
    angle_of,
    first_double,
)
from pyport.errors import BadInput
from pyport.files import write_file
from pyport.recordings.formats.cells import (
    GRAD,
    angle_unit,
    bracketed,
    in_brackets,
    name_and_unit,
    unit_missed,
)
from pyport.recordings.formats.sheet import Sheet, sheet
from pyport.recordings.formats.text import read_text
from pyport.recordings.raw import (
    COUNTED,
    EARLIEST_S,
    LATEST_S,
    SINCE,
    Raw,
    a_time,
    is_hours,
    seconds_of,
    sexagesimal,
)
from pyport.toml_text import toml_spelled

#: In a map: and all other columns as they are called.
REST = "..."
_FORMAT = re.compile(r"\([^()]*\)$")
_DATE = re.compile(r"\d{4}-\d{2}-\d{2}")


def read(path: Path, columns: Mapping[str, str]) -> Raw:
    """Read the cells of a delimited text by a map of its columns.

    Raises `BadInput`: it is no table, or has not what the map says.
    """
    table = sheet(path)
    cells = {str(n + 1): table.column(n) for n in range(len(table.rows[0]))}
    units = {str(n): one for n, one in enumerate(table.units, 1) if one}
    lines = np.array(table.lines, np.int64)
    return mapped(
        Raw(path, table.meta, table.header_line, cells, lines, units=units), columns, table.names
    )


def mapped(raw: Raw, columns: Mapping[str, str], names: Sequence[str] = ()) -> Raw:
    """Return the cells of a table under the contract's names, those that a map names.

    `names`: what the columns are called where `raw` has them under their numbers.

    Raises `BadInput`: the map names a column that the table has not or has twice, one that is none
      here, or another unit than the table.
    """
    found: dict[str, NDArray[Any]] = {}
    called = dict(zip(raw.columns, names or raw.columns, strict=False))
    left = dict(raw.columns)
    for ours, theirs in columns.items():
        if ours == REST:
            continue
        _check(ours)
        name, _, part = theirs.partition("|")
        negative = name.startswith("-")
        key = _found(raw, ours, name.lstrip("-").strip(), called)
        _refuse_other_unit(raw, ours, theirs, key, called.get(key, ""))
        cells = np.asarray(raw.columns[key])
        left.pop(key, None)
        if part:
            if part.strip() not in PARTS:
                raise BadInput(f"--columns {ours}={theirs}: expected one of {', '.join(PARTS)}")
            cells = _each(raw, ours, cells, PARTS[part.strip()], _EXPECTED[part.strip()])
        found[ours] = _each(raw, ours, cells, _negated, "a number") if negative else cells
    if REST in columns:
        twice = first_double(called[key] for key in left)
        if twice is not None:
            raise raw.error(f"--columns: two columns are called {twice!r}, expected one")
        found = {**{called[key]: np.asarray(cells) for key, cells in left.items()}, **found}
    return replace(raw, columns=found)


def _found(raw: Raw, ours: str, name: str, called: Mapping[str, str]) -> str:
    """Return which column has a name, without a format or a unit behind it too, or a number."""
    bare = {key: _FORMAT.sub("", one).strip() for key, one in called.items()}
    of_angles = {key: one.rpartition("_")[0] for key, one in bare.items() if angle_of(one)}
    for names in (called, bare, of_angles):
        alike = [key for key, one in names.items() if one == name]
        if len(alike) > 1:
            which = f"{', '.join(alike[:-1])} and {alike[-1]}"
            wanted = f"expected one of them, such as {ours}={alike[0]}"
            raise raw.error(f"--columns: columns {which} are called {name!r}, {wanted}")
        if alike:
            return alike[0]
    if name in raw.columns:
        return name
    near = nearest(name, bare.values())
    meant = f"did you mean {near!r}?" if near else f"it has {', '.join([*bare.values()][:20])}"
    if "1" in called and all(key == one for key, one in called.items()):
        meant = f"no line of names was found, expected a number from 1 to {len(called)}"
    raise raw.error(f"--columns: no column {name!r}: {meant}")


def _refuse_other_unit(raw: Raw, ours: str, theirs: str, key: str, name: str) -> None:
    """Refuse a column in another unit than the one that the file gives it."""
    quantity, _, unit = ours.rpartition("_")
    beside = raw.units.get(key, "")
    stated = _unit(name, beside, raw.meta)
    if unit not in RADIANS_PER:
        stated = beside or bracketed(name)
        expected = unit_missed(ours, stated)
    elif stated in {"", unit} or (stated, unit) == (GRAD, "deg"):
        return
    elif stated == GRAD:
        expected = f"{quantity}_deg={theirs} where that means degrees, not gon"
    else:
        others = f"numbers in {', '.join(_UNITS)}"
        expected = f"{quantity}_{stated}={theirs}" if stated in RADIANS_PER else others
    if expected:
        raise raw.error(
            f"--columns {ours}={theirs}: the file has it in {stated}, expected {expected}"
        )


def _unit(name: str, beside: str, meta: Mapping[str, str]) -> str:
    """Return the unit that a table gives a column: beside its name, in it, or in the header."""
    named = meta.get(_FORMAT.sub("", name).strip(), "")
    own = angle_unit(beside.strip("[]() ")) or name_and_unit(name)[1]
    return own or in_brackets(named)


def _check(ours: str) -> None:
    """Refuse a name that is nearly one of the contract's."""
    from pyport.recordings.naming import meant

    if angle_of(ours) is None and (right := meant(ours)) is not None:
        raise BadInput(f"--columns {ours}=...: did you mean {right!r}?")


def _each(
    raw: Raw, name: str, cells: NDArray[Any], change: Callable[[str], str], expected: str
) -> NDArray[Any]:
    out = []
    for row, cell in enumerate(cells.tolist()):
        text = str(cell).strip()
        try:
            out.append(change(text) if text else "")
        except (ValueError, OverflowError):
            raise raw.error(f"{name} is {text[:40]!r}, expected {expected}", row) from None
    return np.array(out, object)


def _date(text: str) -> str:
    match = _DATE.search(text)
    if match is None:
        raise ValueError(text)
    return match[0]


def _negated(text: str) -> str:
    return text[1:] if text.startswith("-") else f"-{text.lstrip('+')}" if float(text) else text


def _moment(of_1970: float, unit: float, text: str) -> str:
    seconds = unit * (float(text) - of_1970)
    if not EARLIEST_S <= seconds < LATEST_S:
        raise ValueError(seconds)
    return datetime.fromtimestamp(seconds, UTC).isoformat().replace("+00:00", "Z")


#: What can be taken of a column.
PARTS: dict[str, Callable[[str], str]] = {
    "date": _date,
    **{part: partial(_moment, *counted) for part, counted in COUNTED.items()},
    "dms": lambda text: repr(sexagesimal(text)),
}
#: What is expected of the column then.
_EXPECTED = {
    "date": "a date such as 2015-02-23 in it",
    "mjd": f"days since 1858-11-17 (MJD) {SINCE}: 33282 to 88069",
    "jd": f"days of a Julian date {SINCE}: 2433282.5 to 2488069.5",
    "unix": f"seconds since 1970 {SINCE}: -631152000 to 4102444800",
    "dms": "degrees:minutes:seconds, or hours",
}


def parse(text: str) -> dict[str, str]:
    """Return a map from `OURS=THEIRS, ...` or from the TOML file that `look` keeps.

    Raises `BadInput`: it is neither.
    """
    if text.endswith(".toml"):
        return load(Path(text))
    found = {}
    for one in text.split(","):
        if one.strip() == REST:
            found[REST] = REST
            continue
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
        mapping = tomllib.loads(read_text(path)).get("columns")
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"not a TOML file: {error}", path) from None
    if not isinstance(mapping, dict) or not mapping:
        raise BadInput("no [columns] table, expected one such as az_deg = 'AZd'", path)
    return {str(key): str(value) for key, value in mapping.items()}


def save(columns: Mapping[str, str], path: Path) -> None:
    """Keep a map in a small TOML file."""
    write_file(path, toml_spelled({"columns": dict(columns)}))


#: Columns that have one name and unit, ours.
_TIMES = {TIME, DAY, HOUR_OF_DAY}
_OURS = LABELS | NUMBERS | _TIMES | {SCAN_RATE, "wind_az_deg"}
#: What other people call a column: a pattern, and the contract's quantity.
_CALLED: tuple[tuple[str, str], ...] = (
    *(
        (one.called, one.spelled if one.spelled in _OURS else one.name)
        for one in COLUMNS
        if one.called
    ),
    (r"(time_?)?mjd(_?utc)?", f"{TIME}|mjd"),
    (r"(time_?)?jd(_?utc)?", f"{TIME}|jd"),
)
_UNITS = tuple(one for one in RADIANS_PER if one != "h")
#: What the header says of an offset that is counted the other way: the place less what was read.
_OPPOSITE = re.compile(
    r"(true|catalog\w*|command\w*|demand\w*)\s*(-|minus)\s*(obs|meas|read|enc)\w*"
)


def propose(table: Sheet, doubts: list[str] | None = None) -> dict[str, str]:
    """Return a map of columns by what their names say; angles without a unit are guessed.

    Unit and sign are the name's, or the header's of it; else directions are taken for degrees,
    offsets for arcseconds and as observed less true. A date with a time of day is the time, a label
    that begins with a date tells the session. Times that would not be read are added to `doubts`.
    """
    doubts = [] if doubts is None else doubts
    found = _by_names(table, doubts)
    if not found:
        return {}
    first = zip(table.names, _here(table), next(iter(table.rows), ()), strict=False)
    dated = {
        here: cell.strip()
        for name, here, cell in first
        if _FORMAT.sub("", name).strip() and _DATE.match(cell.strip())
    }
    moments = [here for here, cell in dated.items() if _kind_of_time(TIME, cell) == TIME]
    if moments and not {TIME, DAY} & set(found):
        found[TIME] = moments[0]
    if dated and not {"session", TIME} & set(found) and not {DAY, HOUR_OF_DAY} <= set(found):
        found["session"] = f"{next(iter(dated))}|date"
        if HOUR_OF_DAY in found:
            found[DAY] = found["session"]
    if HOUR_OF_DAY in found and DAY not in found:
        doubts.append(f"{found.pop(HOUR_OF_DAY)} has hours of a day, expected a column of days too")
    return found


def _here(table: Sheet) -> list[str]:
    """Return what a map calls each column: its name, its number where the name is there twice."""
    bare = [_FORMAT.sub("", name).strip() for name in table.names]
    times = Counter(bare)
    return [one if times[one] == 1 else str(n) for n, one in enumerate(bare, 1)]


#: Columns that are left out where the other one is there.
_INSTEAD = (("d_xel", "d_az"), ("sigma_xel", "sigma_az"), (TIME, DAY), (TIME, HOUR_OF_DAY))


def _by_names(table: Sheet, doubts: list[str]) -> dict[str, str]:
    """Return the columns that names say."""
    found: dict[str, str] = {}
    for n, here in enumerate(_here(table)):
        bare = _FORMAT.sub("", table.names[n]).strip()
        ours, _, part = _meant(table, n, bare, doubts).partition("|")
        if ours and (ours not in found or "true" in bare.lower()):
            said = table.meta.get(bare, "").lower()
            turned = ours.startswith("d_") and ours != bare and _OPPOSITE.search(said)
            found[ours] = ("-" if turned else "") + here + (f"|{part}" if part else "")
    for better, other in _INSTEAD:
        if any(one.startswith(better) for one in found):
            found = {key: value for key, value in found.items() if not key.startswith(other)}
    return found


def _meant(table: Sheet, n: int, bare: str, doubts: list[str]) -> str:
    """Return the contract's name of a column, with a part behind it, "" for none."""
    plain = re.sub(r"[.\s\-*]+", "_", name_and_unit(table.names[n])[0]).strip("_")
    called = (quantity for pattern, quantity in _CALLED if re.fullmatch(pattern, plain))
    known = angle_of(bare) is not None or bare in _OURS
    ours = bare if known else next(called, "")
    cell = next(filter(None, table.column(n)), "")
    if ours.partition("|")[0] in _TIMES:
        kind = _kind_of_time(ours, cell)
        if cell and not kind:
            expected = _EXPECTED.get(ours.partition("|")[2], a_time(cell))
            doubts.append(f"{bare} has {cell[:40]!r}, expected {expected}")
        return kind
    colons = "|dms" if ":" in cell else ""
    beside = "".join(table.units[n : n + 1])
    if wanted := unit_missed(ours, beside or bracketed(table.names[n])):
        doubts.append(f"{table.names[n]} is in another unit, expected numbers in {wanted}")
        return ""
    if known or not ours or ours in _OURS:
        return ours + (colons if angle_of(ours) else "")
    unit = _unit(table.names[n], beside, table.meta)
    if unit == GRAD:
        doubts.append(
            f"{bare} is in {unit}, expected {ours}_deg={table.names[n]} where that means degrees, "
            "not gon"
        )
        return ""
    ours = f"{ours}_{unit or ('arcsec' if ours.startswith(('d_', 'sigma_')) else 'deg')}"
    if angle_of(ours) is None:
        doubts.append(f"{bare} is in {unit}, expected numbers in {', '.join(_UNITS)}")
        return ""
    return ours + colons


def _kind_of_time(quantity: str, cell: str) -> str:
    """Return whether a cell is a time, a day or its hours, "" for nothing that is read."""
    ours, _, part = quantity.partition("|")
    try:
        if part:
            PARTS[part](cell)
            return quantity
        if ours != DAY and is_hours(cell):
            return HOUR_OF_DAY
        seconds_of(cell)
    except (ValueError, OverflowError):
        return ""
    return TIME if ":" in cell else DAY
