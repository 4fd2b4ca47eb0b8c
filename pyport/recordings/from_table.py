"""Recordings from tables in memory: data frames, astropy and Arrow tables, dictionaries."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pyport.angles import RADIANS_PER
from pyport.recordings.columns import ANGLES
from pyport.recordings.files import read
from pyport.recordings.given import Given
from pyport.recordings.interpret import interpret
from pyport.recordings.raw import Raw
from pyport.recordings.schema import Recordings

#: Whatever holds recordings: a name, recordings, or a table with named columns.
Table: TypeAlias = Any
#: Header keys that hold for all rows, such as `latitude_deg`.
Header: TypeAlias = Mapping[str, object]


def from_table(table: Table, header: Header | None = None) -> Recordings:
    """Return the recordings that a table holds; columns are named as in a file of recordings.

    Raises
    ------
    BadInput
        Columns are missing, unknown or hold what they should not; rows count from 1.
    """
    keys = {str(key): str(value) for key, value in (header or {}).items()}
    if isinstance(table, Recordings):
        return table
    if isinstance(table, str | Path):
        return read(table, Given(keys))
    return interpret(raw_table(table, keys))


def raw_table(table: Table, keys: Mapping[str, str] | None = None) -> Raw:
    """Return the cells of a table in memory; `keys` are header keys that it does not have."""
    columns = {_named(name, table[name]): _cells(table[name]) for name in _names(table)}
    rows = max((len(cells) for cells in columns.values()), default=0)
    meta = {str(k): str(v) for k, v in (getattr(table, "meta", None) or {}).items()}
    return Raw(Path("table"), meta | dict(keys or {}), 0, columns, np.arange(1, rows + 1))


def _names(table: Table) -> list[str]:
    """Return the names of a table's columns."""
    for attribute in ("column_names", "colnames", "columns"):
        if hasattr(table, attribute):
            return [str(name) for name in getattr(table, attribute)]
    return [str(name) for name in table]


def _named(name: str, column: Any) -> str:  # noqa: ANN401 - a column of any table
    """Return a column's name with the unit that an astropy column bears beside it."""
    unit = str(getattr(column, "unit", None) or "")
    unit = "h" if unit == "hourangle" else unit
    return f"{name}_{unit}" if name in ANGLES and unit in RADIANS_PER else name


def _cells(column: Any) -> NDArray[Any]:  # noqa: ANN401 - a column of any table
    """Return a column's cells: numbers or times with NaN or NaT, text with "", for blank."""
    if isinstance(column, np.ma.MaskedArray):
        if column.dtype.kind in "iuf":
            return np.asarray(np.ma.filled(column.astype(float), np.nan))
        blank = np.datetime64("NaT") if column.dtype.kind == "M" else ""
        return np.asarray(np.ma.filled(column, blank))
    cells = np.asarray(column)
    if cells.dtype.kind == "O":
        return np.array(["" if _blank(one) else str(one) for one in cells.tolist()], np.str_)
    return cells


def _blank(cell: object) -> bool:
    """Tell whether a cell is None, NaN, NaT or such."""
    return cell is None or cell != cell or str(cell) in {"<NA>", "NaT"}  # noqa: PLR0124
