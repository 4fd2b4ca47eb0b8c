"""The pieces of a data set: groups of rows of Parquet files, in an order of their own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pyport.columns import LABELS, SCAN_RATE, TIME, angle_of
from pyport.errors import BadInput
from pyport.files import is_spelled
from pyport.recordings.formats.tables import is_text, keys_of, refuse_doubles, refused
from pyport.recordings.naming import refuse_columns

#: Rows of a piece, as far as the files' row groups allow: what one worker is given at a time.
PIECE_ROWS = 2_000_000
#: Rows of equal cells take next to nothing in a file; measurements do not come to so many.
MOST_ROWS_A_BYTE = 10
#: Rows that are in memory at a time.
CHUNK_ROWS = 1 << 18


@dataclass(frozen=True)
class Piece:
    """Some row groups of a file."""

    file: Path  #: the file
    groups: tuple[int, ...]  #: numbers of its row groups
    first_row: int  #: number of the first row in the file, counted from 1
    #: What the names of the folders say of all rows: `antenna=W01`, `session=march`.
    labels: tuple[tuple[str, str], ...]

    def batches(self, rows: int = 0) -> Iterator[Any]:
        """Yield record batches of at most so many rows, `CHUNK_ROWS` where nothing is said."""
        with opened(self.file) as file, refused(self.file):
            wanted = _wanted(file.schema_arrow, self.file)
            yield from file.iter_batches(
                rows or CHUNK_ROWS, row_groups=list(self.groups), columns=wanted
            )


def files_of(root: Path) -> list[Path]:
    """Return the Parquet files of a data set, in the order of their names."""
    found = sorted(one for one in root.rglob("*.parquet") if one.name[0] not in "_.")
    for path in found:
        if not is_spelled(path):
            raise BadInput(f"{str(path)!r} is no UTF-8 text, expected a name that is", root)
    return found


def pieces_of(root: Path) -> tuple[list[Piece], dict[str, str]]:
    """Return the pieces of a data set, and the header keys that its files have in common.

    Raises `BadInput`: a file is no Parquet, or two files disagree about a header key.
    """
    found: list[Piece] = []
    keys: dict[str, str] = {}
    for path in files_of(root):
        labels = labels_of(path.relative_to(root))
        with opened(path) as file:
            _agree(keys, file.schema_arrow.metadata, path)
            _check_names(file.schema_arrow.names, path)
            _check_promise(file.metadata.num_rows, path)
            sizes = [
                file.metadata.row_group(n).num_rows for n in range(file.metadata.num_row_groups)
            ]
        groups: list[int] = []
        first = row = 1
        for n, size in enumerate(sizes):
            if groups and row + size - first > PIECE_ROWS:
                found.append(Piece(path, tuple(groups), first, labels))
                groups, first = [], row
            groups.append(n)
            row += size
        if groups:
            found.append(Piece(path, tuple(groups), first, labels))
    return found, keys


def _check_names(names: list[str], path: Path) -> None:
    """Refuse a column that would be left out for its name, as in a single file."""
    try:
        refuse_columns(names)
    except BadInput as error:
        raise BadInput(error.message, path) from None


def _check_promise(rows: int, path: Path) -> None:
    """Refuse a file that stands for more equal rows than anybody measured."""
    size = path.stat().st_size
    if rows > PIECE_ROWS + MOST_ROWS_A_BYTE * size:
        raise BadInput(f"{rows} rows in {size} bytes, expected measurements", path)


def labels_of(path: Path) -> tuple[tuple[str, str], ...]:
    """Return the contract's labels that a path's folders spell, `NAME=VALUE` each.

    Folders by date or by number say nothing that the rows' times do not.
    """
    parts = (folder.partition("=") for folder in path.parts[:-1])
    return tuple((name, value) for name, equals, value in parts if equals and name in LABELS)


def opened(path: Path) -> Any:  # noqa: ANN401 - pyarrow is not typed
    """Open a Parquet file; text comes as places in a dictionary, a long one is there once."""
    from pyarrow import parquet

    with refused(path):
        schema = parquet.read_schema(path, memory_map=True)
        words = [one.name for one in schema if is_text(one.type)]
        return parquet.ParquetFile(path, memory_map=True, read_dictionary=words)


def _wanted(schema: Any, path: Path) -> list[str]:  # noqa: ANN401 - pyarrow is not typed
    """Return the columns that a data set is reduced by: numbers, times, and the labels known."""
    import pyarrow

    kinds = pyarrow.types
    refuse_doubles(schema.names, path)
    wanted = []
    for one in schema:
        known = one.name in {*LABELS, TIME, SCAN_RATE} or angle_of(one.name) is not None
        if known and kinds.is_nested(one.type):
            raise BadInput(f"column {one.name!r} is {one.type}, expected numbers or text", path)
        tests = kinds.is_integer, kinds.is_floating, kinds.is_timestamp
        if known or any(test(one.type) for test in tests):
            wanted.append(one.name)
    return wanted


def _agree(keys: dict[str, str], metadata: dict[bytes, bytes] | None, path: Path) -> None:
    """Take over a file's header keys; whoever contradicts an earlier file is refused."""
    with refused(path):
        header = keys_of(metadata)
    for name, value in header.items():
        if keys.setdefault(name, value) != value:
            raise BadInput(f"{name} is {value!r}, in files before it {keys[name]!r}", path)
