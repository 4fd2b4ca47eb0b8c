"""ECSV by astropy, Parquet by pyarrow: tables that carry types, and in ECSV units."""

from __future__ import annotations

import contextlib
import reprlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import RADIANS_PER
from pyport.columns import ANGLES, first_double
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.recordings.formats.cells import in_its_unit
from pyport.recordings.formats.text import LARGEST_TEXT, MOST_COLUMNS, read_text
from pyport.recordings.raw import LONGEST_CELL, Raw, TextColumn
from pyport.recordings.schema import Table

#: No table of recordings has more; a Parquet file of a few kB may promise any number.
MOST_CELLS = 2 * 10**8

#: Astropy's names of units -> the suffixes of the contract.
_SUFFIX = {"hourangle": "h"}


def read_ecsv(path: Path) -> Raw:
    """Read the cells of an ECSV file; a column's unit may stand in its name or beside it.

    Raises `BadInput`: the file is no ECSV, or a column's unit contradicts its name, or is none that
    the name could have.
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
    units: dict[str, str] = {}
    for column in table.itercols():
        name, cells = _with_unit(column, path)
        if name == column.info.name and column.info.unit is not None:
            units[name] = str(column.info.unit)
        if name in columns:
            raise BadInput(f"two columns are called {name!r}, expected one", path, header)
        columns[name] = cells
    if not len(table):
        raise BadInput("no rows below the column names", path, header)
    meta = {str(key): _text(value) for key, value in table.meta.items()}
    lines_of_rows = np.array(rows[: len(table)], np.int64)
    return Raw(path, meta, header, columns, lines_of_rows, units=units)


def _text(value: object) -> str:
    """Return what a header key holds as text; what is nested in YAML may be endless."""
    if not isinstance(value, dict | list | tuple | set):
        return str(value)
    short = reprlib.Repr()
    short.maxlevel, short.maxlist, short.maxdict, short.maxstring = 2, 50, 50, 100
    return short.repr(value)


def _with_unit(column: Any, path: Path) -> tuple[str, NDArray[Any]]:  # noqa: ANN401 - astropy
    """Return a column under the contract's name, in the unit that the name tells."""
    name, unit = column.info.name, column.info.unit
    if not hasattr(column, "name"):  # a time, a direction: in_its_unit knows or refuses it
        unit = ""
    elif unit is None or not str(unit):
        return name, _filled(column)
    unit = _SUFFIX.get(str(unit), str(unit))
    quantity, _, suffix = name.rpartition("_")
    if quantity in ANGLES and suffix in RADIANS_PER and unit in RADIANS_PER and suffix != unit:
        raise BadInput(f"column {name!r} says its unit is {unit!r}, expected {suffix!r}", path)
    try:
        return in_its_unit(name, column)
    except BadInput as error:
        raise BadInput(error.message.removeprefix("table: "), path) from None


def _filled(column: Any) -> NDArray[Any]:  # noqa: ANN401 - astropy is not typed
    values = np.asarray(column)
    if values.ndim > 1 or values.dtype.kind == "O":  # lists are kept as text, as in CSV
        cells = column.tolist()
        return np.array(["" if one is None else str(one) for one in cells], np.str_)
    mask = np.asarray(getattr(column, "mask", np.zeros(len(values), bool)))
    if values.dtype.kind in "fiu":
        return np.where(mask, np.nan, values) if mask.any() else values
    return np.where(mask, "", values.astype(np.str_))


def read_parquet(path: Path) -> Raw:
    """Read the cells of a Parquet file; lines are its rows, counted from 1.

    Raises `BadInput`: the file is no Parquet, or has no rows.
    """
    if not path.stat().st_size:
        raise BadInput("the file is empty, expected recordings", path)
    with refused(path):
        return _parquet_cells(path)


@contextlib.contextmanager
def refused(path: Path) -> Iterator[None]:
    """Say in one line what Parquet's own reader does not like of a file."""
    import pyarrow

    try:
        yield
    except (pyarrow.ArrowException, OSError, UnicodeDecodeError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise BadInput(f"no Parquet table: {reason}", path) from None


def _parquet_cells(path: Path) -> Raw:
    """Return the cells of a Parquet file that can be held."""
    table = _arrow_table(path)
    if not table.num_rows:
        raise BadInput("no rows in this table", path)
    names = table.column_names
    refuse_doubles(names, path)
    columns = {name: _arrow_cells(table[name]) for name in names}
    return Raw(
        path,
        keys_of(table.schema.metadata),
        1,
        columns,
        np.arange(1, table.num_rows + 1, dtype=np.int64),
    )


def _arrow_table(path: Path) -> Any:  # noqa: ANN401 - pyarrow is not typed
    """Return the table of a Parquet file once its metadata promise one that can be held.

    A file of a few kilobytes may stand for any number of equal cells: text is
    read as places in a dictionary, so that a long text is there once.

    Raises `BadInput`: the table is larger than any of recordings, or a text is longer than a cell
      may be.
    """
    import pyarrow
    from pyarrow import parquet

    # the types first: only the schema is read
    schema = parquet.read_schema(path)
    words = [one.name for one in schema if is_text(one.type)]
    with parquet.ParquetFile(path, read_dictionary=words) as file:
        held = file.metadata
        size = sum(held.row_group(n).total_byte_size for n in range(held.num_row_groups))
        if held.num_columns > MOST_COLUMNS:
            wrong = f"{held.num_columns} columns, expected at most {MOST_COLUMNS}"
            raise BadInput(wrong, path)
        if held.num_rows * max(held.num_columns, 1) > MOST_CELLS or size > LARGEST_TEXT:
            wrong = f"{held.num_rows} rows of {held.num_columns} columns"
            raise BadInput(f"{wrong}, expected at most {MOST_CELLS} cells in 1 GB", path)
        table = file.read()
    for name, column in zip(table.column_names, table.columns, strict=True):
        if not (pyarrow.types.is_dictionary(column.type) and is_text(column.type.value_type)):
            continue
        for chunk in column.chunks:
            refuse_long(chunk.dictionary, name, path)
    return table


def refuse_doubles(names: Sequence[str], path: Path) -> None:
    """Refuse two columns of one name."""
    twice = first_double(names)
    if twice is not None:
        raise BadInput(f"two columns are called {twice!r}, expected one", path)


def refuse_long(texts: Any, name: str, path: Path) -> None:  # noqa: ANN401 - pyarrow is not typed
    """Refuse a column that holds a text longer than a cell may be."""
    from pyarrow import compute

    if (compute.max(compute.binary_length(texts)).as_py() or 0) > LONGEST_CELL:
        raise BadInput(f"{name} has more than {LONGEST_CELL} characters", path)


def keys_of(metadata: Mapping[bytes, bytes] | None) -> dict[str, str]:
    """Return the header keys of a Parquet file, without what its libraries keep there."""
    keys = {key.decode(): value.decode() for key, value in (metadata or {}).items()}
    return {key: value for key, value in keys.items() if key not in {"pandas", "ARROW:schema"}}


def is_text(kind: Any) -> bool:  # noqa: ANN401 - pyarrow is not typed
    """Tell whether a column's cells are text or bytes of any length."""
    import pyarrow

    return any(
        test(kind)
        for test in (
            pyarrow.types.is_string,
            pyarrow.types.is_large_string,
            pyarrow.types.is_binary,
            pyarrow.types.is_large_binary,
        )
    )


def _arrow_cells(column: Any) -> NDArray[Any] | TextColumn:  # noqa: ANN401 - pyarrow is not typed
    """Return an Arrow column as numbers, times or text, blank where it is null."""
    import pyarrow

    kind = column.type
    if pyarrow.types.is_timestamp(kind):
        return column.cast(pyarrow.timestamp("us")).to_numpy().astype("datetime64[us]")
    if pyarrow.types.is_integer(kind) or pyarrow.types.is_floating(kind):
        return column.to_numpy()
    if pyarrow.types.is_dictionary(kind) and pyarrow.types.is_string(kind.value_type):
        text = column.cast(pyarrow.string()).fill_null("").combine_chunks()
        # Its cells are read later, where nobody knows the file: what is no UTF-8 is refused here.
        text.validate(full=True)
        return TextColumn(text)
    return np.array(["" if cell is None else str(cell) for cell in column.to_pylist()], object)


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
