"""Formats of recordings: read by suffix, name or content, written by suffix or name."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.columns import LABELS
from pyport.errors import BadInput
from pyport.recordings.formats import csv, exact, katpoint_csv, mapped, xtr
from pyport.recordings.formats import tables as typed
from pyport.recordings.formats.text import refuse_packed
from pyport.recordings.formats.tpoint import dat
from pyport.recordings.raw import Raw
from pyport.recordings.schema import Table


@dataclass(frozen=True)
class TableFormat:
    """A format of recordings: its name, suffix, and how it is read and written.

    Writing returns what the format has no place for.
    """

    name: str
    suffix: str
    read: Callable[[Path], Raw]
    write: Callable[[Table, Path], exact.Written] | None


def _as_text(write: Callable[[Table, Path], None]) -> Callable[[Table, Path], exact.Written]:
    """Return the writer of a format that holds every cell as it stands."""

    def written(table: Table, path: Path) -> exact.Written:
        write(table, path)
        return exact.Written()

    return written


def _with_types(write: Callable[[Table, Path], None]) -> Callable[[Table, Path], exact.Written]:
    """Return the writer of a format whose columns have types: numbers become numbers."""

    def written(table: Table, path: Path) -> exact.Written:
        columns = {name: typed_column(name, cells) for name, cells in table.columns.items()}
        write(Table(table.meta, columns), path)
        return exact.Written()

    return written


def typed_column(name: str, cells: NDArray[Any]) -> NDArray[Any]:
    """Return a column of text as floats if it holds nothing but numbers that floats can hold."""
    if cells.dtype.kind != "U" or name in LABELS:
        return cells
    numbers = [exact.number(cell) for cell in cells.tolist()]
    if any(one is None and cell.strip() for one, cell in zip(numbers, cells, strict=True)):
        return cells
    if any(one is not None and Decimal(repr(float(one))) != one for one in numbers):
        return cells
    return np.array([np.nan if one is None else float(one) for one in numbers])


FORMATS = {
    one.name: one
    for one in (
        TableFormat("csv", ".csv", csv.read, _as_text(csv.write)),
        TableFormat("ecsv", ".ecsv", typed.read_ecsv, _with_types(typed.write_ecsv)),
        TableFormat("parquet", ".parquet", typed.read_parquet, _with_types(typed.write_parquet)),
        TableFormat("tpoint-dat", ".dat", dat.read, dat.write),
        TableFormat("fs-xtr", ".xtr", xtr.read_xtr, xtr.write),
        TableFormat("fs-err", ".err", xtr.read_err, None),
        TableFormat("katpoint-csv", "", katpoint_csv.read, katpoint_csv.write),
    )
}
#: Under any other suffix a map of columns is that of a delimited text.
_WITH_TYPES = (".ecsv", ".parquet")
BY_SUFFIX = {one.suffix: one for one in FORMATS.values() if one.suffix}


def read(
    path: Path,
    name: str = "",
    columns: tuple[str, ...] = (),
    mapping: Mapping[str, str] | None = None,
) -> Raw:
    """Read the cells of a file, of a named format or of the one that it looks like.

    With a `mapping` of its columns any delimited text is read.

    Raises `BadInput`: there is no such format, the file is not of it, or names its columns itself.
    """
    with _collector_paused():
        return _read(path, name, columns, mapping)


@contextmanager
def _collector_paused() -> Iterator[None]:
    """Keep the collector from going through all rows again and again: they make no cycles."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _read(
    path: Path, name: str, columns: tuple[str, ...], mapping: Mapping[str, str] | None
) -> Raw:
    if mapping and not name and path.suffix.lower() not in _WITH_TYPES:
        return mapped.read(path, mapping)
    one = format_of(path, name)
    if mapping:
        if one.name == "csv":
            return mapped.read(path, mapping)
        return mapped.mapped(one.read(path), mapping)
    if columns:
        if one.name != "csv":
            raise BadInput("the format of this file names its columns itself: leave them out", path)
        return csv.read(path, columns)
    if one.name == "csv" and not name and katpoint_csv.looks_like(path):
        one = FORMATS["katpoint-csv"]
    return one.read(path)


def write(table: Table, path: Path, name: str = "") -> exact.Written:
    """Write a table in a named format or its suffix's; return what the file does not hold.

    Raises `BadInput`: there is no such format, or it cannot hold this.
    """
    one = format_of(path, name, to_write=True)
    if one.write is None:
        raise BadInput(f"{one.name} is what a fit gives: name its model with --model", path)
    return one.write(table, path)


def format_of(path: Path, name: str = "", *, to_write: bool = False) -> TableFormat:
    """Return a format by its name, or by the suffix of a path that is read or `to_write`.

    Raises `BadInput`: there is none.
    """
    if name:
        if name not in FORMATS:
            raise BadInput(f"no format is called {name!r}, known: {', '.join(FORMATS)}", path)
        return FORMATS[name]
    try:
        return BY_SUFFIX[path.suffix.lower()]
    except KeyError:
        if not to_write:
            refuse_packed(path)
        known = [suffix for suffix, one in BY_SUFFIX.items() if one.write or not to_write]
        wrong = f"suffix {path.suffix!r} names no format, expected {', '.join(known)}"
        way = "" if to_write else "; --columns reads any other table"
        raise BadInput(wrong + way, path) from None
