"""ECSV by astropy, Parquet by pyarrow: tables that carry types, and in ECSV units."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import RADIANS_PER
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.recordings.columns import ANGLES
from pyport.recordings.formats.csv import read_text
from pyport.recordings.raw import Raw
from pyport.recordings.tabulate import Table

#: Astropy's names of units -> the suffixes of the contract.
_SUFFIX = {"hourangle": "h"}


def read_ecsv(path: Path) -> Raw:
    """Read the cells of an ECSV file; a column's unit may stand in its name or beside it.

    Raises
    ------
    BadInput
        The file is no ECSV, or a column's name and its unit contradict each other.
    """
    from astropy.table import Table

    numbered = enumerate(read_text(path).splitlines(), 1)
    lines = [n for n, line in numbered if line.strip() and not line.startswith("#")]
    try:
        table = Table.read(path, format="ascii.ecsv")
    except Exception as error:  # noqa: BLE001 - astropy raises what its parsers raise
        reason = str(error).strip().splitlines()
        raise BadInput(f"no ECSV table: {reason[0] if reason else error!r}", path) from None
    header, rows = (lines[0], lines[1:]) if lines else (1, [])
    columns: dict[str, NDArray[Any]] = {}
    for column in table.itercols():
        name = _with_unit(column.name, None if column.unit is None else str(column.unit), path)
        if name in columns:
            raise BadInput(f"two columns are called {name!r}, expected one", path, header)
        columns[name] = _filled(column)
    if not len(table):
        raise BadInput("no rows below the column names", path, header)
    meta = {str(key): str(value) for key, value in table.meta.items()}
    return Raw(path, meta, header, columns, np.array(rows[: len(table)], np.int64))


def _with_unit(name: str, unit: str | None, path: Path) -> str:
    """Return a column's name with its unit as the contract writes it."""
    unit = _SUFFIX.get(unit or "", unit)
    if unit not in RADIANS_PER:
        return name
    if name in ANGLES:
        return f"{name}_{unit}"
    quantity, _, told = name.rpartition("_")
    if quantity in ANGLES and told in RADIANS_PER and told != unit:
        raise BadInput(f"column {name!r} says its unit is {unit!r}, expected {told!r}", path)
    return name


def _filled(column: Any) -> NDArray[Any]:  # noqa: ANN401 - astropy is not typed
    """Return a column with blanks where it is masked."""
    values = np.asarray(column)
    mask = np.asarray(getattr(column, "mask", np.zeros(len(values), bool)))
    if values.dtype.kind in "fiu":
        return np.where(mask, np.nan, values) if mask.any() else values
    return np.where(mask, "", values.astype(np.str_))


def read_parquet(path: Path) -> Raw:
    """Read the cells of a Parquet file; lines are its rows, counted from 1.

    Raises
    ------
    BadInput
        The file is no Parquet, or has no rows.
    """
    import pyarrow
    from pyarrow import parquet

    if not path.stat().st_size:
        raise BadInput("the file is empty, expected recordings", path)
    try:
        table = parquet.read_table(path)
    except (pyarrow.ArrowException, OSError) as error:
        raise BadInput(f"no Parquet table: {str(error).splitlines()[0]}", path) from None
    if not table.num_rows:
        raise BadInput("no rows in this table", path)
    names = table.column_names
    twice = _first_double(names)
    if twice is not None:
        raise BadInput(f"two columns are called {twice!r}, expected one", path)
    columns = {name: _arrow_cells(table[name]) for name in names}
    keys = {k.decode(): v.decode() for k, v in (table.schema.metadata or {}).items()}
    meta = {k: v for k, v in keys.items() if k not in {"pandas", "ARROW:schema"}}
    return Raw(path, meta, 1, columns, np.arange(1, table.num_rows + 1, dtype=np.int64))


def _first_double(names: Iterable[str]) -> str | None:
    """Return the first name that stands there a second time."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None


def _arrow_cells(column: Any) -> NDArray[Any]:  # noqa: ANN401 - pyarrow is not typed
    """Return an Arrow column as numbers, times or text, blank where it is null."""
    import pyarrow

    kind = column.type
    if pyarrow.types.is_timestamp(kind):
        return column.cast(pyarrow.timestamp("us")).to_numpy().astype("datetime64[us]")
    if pyarrow.types.is_integer(kind) or pyarrow.types.is_floating(kind):
        return column.to_numpy()
    return np.array(["" if cell is None else str(cell) for cell in column.to_pylist()], np.str_)


def write_ecsv(table: Table, path: Path) -> None:
    """Write a table as ECSV."""
    from astropy.table import Table as AstropyTable

    sheet = AstropyTable(table.columns, meta=table.meta)
    with write_whole(path) as file:
        sheet.write(file, format="ascii.ecsv", delimiter=",")


def write_parquet(table: Table, path: Path) -> None:
    """Write a table as Parquet."""
    import pyarrow
    from pyarrow import parquet

    sheet = pyarrow.table({name: pyarrow.array(cells) for name, cells in table.columns.items()})
    with write_whole(path, "wb") as file:
        parquet.write_table(sheet.replace_schema_metadata(table.meta), file)
