"""Recordings from tables in memory: data frames, astropy and Arrow tables, dictionaries."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pyport.angles import RADIANS_PER
from pyport.arguments import mapping, place, refusal
from pyport.columns import ANGLES, NUMBER, QUANTITIES, TIME, angle_of
from pyport.errors import BadInput
from pyport.recordings import naming
from pyport.recordings.files import nothing_left, read
from pyport.recordings.interpret import interpret
from pyport.recordings.raw import FileOptions, Raw
from pyport.recordings.schema import Recordings

#: Whatever holds recordings: a name, recordings, or a table with named columns.
Table: TypeAlias = Any
#: Header keys that hold for all rows, such as `latitude_deg`.
Header: TypeAlias = Mapping[str, object]


def from_table(table: Table, header: Header | None = None) -> Recordings:
    """Return the recordings that a table holds; columns are named as in a file of recordings.

    Raises `BadInput`: columns are missing, unknown or hold what they should not; rows count from 1.
    """
    keys = _keys({} if header is None else header)
    if isinstance(table, Recordings):
        return table
    if isinstance(table, str | Path):
        return read(place("table", table), FileOptions(keys))
    found = interpret(raw_table(table, keys))
    if not len(found):
        raise BadInput(nothing_left(found), "table")
    return found


def raw_table(table: Table, keys: Mapping[str, str] | None = None) -> Raw:
    """Return the cells of a table in memory; `keys` are header keys that it does not have."""
    columns = dict(_column(name, table[name]) for name in _names(table))
    naming.refuse_columns(columns)
    sizes = {len(cells) for cells in columns.values()}
    if len(sizes) > 1:
        lengths = ", ".join(f"{name} {len(cells)}" for name, cells in columns.items())
        raise BadInput(f"table: columns of different lengths: {lengths}")
    rows = max(sizes, default=0)
    meta = {str(k): str(v) for k, v in (getattr(table, "meta", None) or {}).items()}
    return Raw(Path("table"), meta | dict(keys or {}), 0, columns, np.arange(1, rows + 1))


def _keys(header: Header) -> dict[str, str]:
    """Return header keys as text; `location` may be astropy's EarthLocation."""
    found: dict[str, str] = {}
    for key, value in mapping("header", header).items():
        try:
            found |= _key(key, value)
        except (TypeError, ValueError):
            raise refusal(f"header {key}", value, "one number, angle, place or text") from None
    naming.refuse_keys(found, "header ")
    return found


def _key(key: str, value: Any) -> dict[str, str]:  # noqa: ANN401 - whatever is given
    if key == "location" and hasattr(value, "to_geodetic"):
        place = value.to_geodetic()
        return {
            "latitude_deg": repr(float(place.lat.to_value("deg"))),
            "longitude_deg": repr(float(place.lon.to_value("deg"))),
            "height_m": repr(float(place.height.to_value("m"))),
        }
    if getattr(value, "unit", None) is not None and key.endswith("_deg"):
        return {key: repr(float(value.to_value("deg")))}
    return {key: str(value)}


def _names(table: Table) -> list[str]:
    named = (getattr(table, one, None) for one in ("column_names", "colnames", "columns"))
    names = next((one for one in named if isinstance(one, Iterable)), None)
    if names is None and isinstance(table, Mapping):
        names = table
    if names is None:
        raise refusal("table", table, "a file, a data frame, or columns by name")
    for name in names:
        if not isinstance(name, str):
            raise refusal("table: the name of a column", name, "a text")
    return list(names)


def _column(name: str, column: Any) -> tuple[str, NDArray[Any]]:  # noqa: ANN401 - of any table
    """Return a column under the contract's name, in the unit that the name tells.

    Raises `BadInput`: Astropy's unit of the column is none that its name could have.
    """
    if hasattr(column, "utc") and hasattr(column, "unix"):
        when = np.asarray(column.utc.datetime64)
        return (TIME if name == "time" else name), when
    unit = getattr(column, "unit", None)
    if unit is None or not str(unit):
        return name, _cells(name, column)
    told = angle_of(name)
    if name in ANGLES:
        own = "h" if str(unit) == "hourangle" else str(unit)
        own = own if own in RADIANS_PER else "deg"
        wanted, name = _ASTROPY[own], f"{name}_{own}"
    elif told is not None:
        wanted = _ASTROPY[name.rpartition("_")[2]]
    elif name in _QUANTITIES:
        name, wanted = _QUANTITIES[name]
    else:
        wanted = dict(_QUANTITIES.values()).get(name, "")
    return name, _cells(name, column) if not wanted else _converted(name, column, unit, wanted)


#: The contract's units of angle as astropy spells them.
_ASTROPY = {"mdeg": "mdeg", "h": "hourangle"} | {
    one: one for one in RADIANS_PER if one not in {"mdeg", "h"}
}
#: Quantities whose unit is a fixed part of their name: without it -> the name, and the unit.
_QUANTITIES = {
    spoken: (one.spelled, one.quantity) for spoken, one in QUANTITIES.items() if one.kind == NUMBER
}


def _converted(
    name: str,
    column: Any,  # noqa: ANN401 - a column of any table
    unit: object,
    wanted: str,
) -> NDArray[Any]:
    """Return the numbers of a column of astropy's in another unit."""
    from astropy import units

    numbers = np.asarray(_cells(name, column), float)
    if str(unit) == wanted:
        return numbers
    try:
        there = units.Unit(str(unit)).to(units.Unit(wanted), numbers, units.temperature())
    except (units.UnitConversionError, ValueError):
        raise BadInput(f"table: column {name!r} is in {unit}, expected {wanted}") from None
    return np.asarray(there, float)


def _cells(name: str, column: Any) -> NDArray[Any]:  # noqa: ANN401 - a column of any table
    """Return a column's cells: numbers or times with NaN or NaT, text with "", for blank.

    Raises `BadInput`: they are none of these, or not one a row.
    """
    if isinstance(column, np.ma.MaskedArray):
        if column.dtype.kind in "iuf":
            return np.asarray(np.ma.filled(column.astype(float), np.nan))
        blank = np.datetime64("NaT") if column.dtype.kind == "M" else ""
        return np.asarray(np.ma.filled(column, blank))
    try:
        cells = np.asarray(column)
        cells = cells.astype(np.str_) if cells.dtype.kind == "S" else cells
    except (TypeError, ValueError):  # cells of different shapes, bytes that are no ASCII
        cells = np.empty((0, 0))
    if cells.ndim != 1 or cells.dtype.kind not in "OUMiufb":
        raise refusal(f"table: column {name!r}", column, "numbers, times or texts, one a row")
    if cells.dtype.kind == "O":
        if any(_many(one) for one in cells.tolist()):
            raise refusal(f"table: column {name!r}", column, "one number, time or text a row")
        return np.array(["" if _blank(one) else str(one) for one in cells.tolist()], np.str_)
    return cells


def _many(cell: object) -> bool:
    """Tell whether a cell holds several things."""
    several = hasattr(cell, "__len__") and not isinstance(cell, str | bytes)
    return several and getattr(cell, "ndim", 1) > 0


def _blank(cell: object) -> bool:
    """Tell whether a cell is None, NaN, NaT or such."""
    return cell is None or cell != cell or str(cell) in {"<NA>", "NaT"}  # noqa: PLR0124
