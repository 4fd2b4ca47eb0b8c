"""Recordings from tables in memory: data frames, astropy and Arrow tables, dictionaries."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from pyport.arguments import mapping, place, refusal
from pyport.errors import BadInput
from pyport.recordings import naming
from pyport.recordings.files import nothing_left, read
from pyport.recordings.formats.cells import in_its_unit
from pyport.recordings.interpret import interpret
from pyport.recordings.notes import noted
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
    raw = raw_table(table, keys)
    found = interpret(raw)
    if not len(found):
        raise BadInput(nothing_left(found), "table")
    return noted(found, raw)


def raw_table(table: Table, keys: Mapping[str, str] | None = None) -> Raw:
    """Return the cells of a table in memory; `keys` are header keys that it does not have."""
    columns = dict(in_its_unit(name, table[name]) for name in _names(table))
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
    naming.refuse_slips(found, "header ")
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
