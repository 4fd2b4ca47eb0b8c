"""The pieces of a data set: groups of rows of Parquet files, in an order of their own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.recordings.columns import LABELS

#: Rows of a piece, as far as the files' row groups allow: what one worker is given at a time.
PIECE_ROWS = 2_000_000
#: Rows that are in memory at a time.
CHUNK_ROWS = 1 << 18


@dataclass(frozen=True)
class Piece:
    """Some row groups of a file.

    Attributes
    ----------
    file
        The file.
    groups
        Numbers of its row groups.
    first_row
        Number of the first row in the file, counted from 1.
    labels
        What the names of the folders say of all rows: `antenna=W01`, `session=march`.
    """

    file: Path
    groups: tuple[int, ...]
    first_row: int
    labels: tuple[tuple[str, str], ...]

    def batches(self) -> Iterator[Any]:
        """Yield record batches of at most `CHUNK_ROWS` rows."""
        with opened(self.file) as file:
            yield from file.iter_batches(CHUNK_ROWS, row_groups=list(self.groups))


def files_of(root: Path) -> list[Path]:
    """Return the Parquet files of a data set, in the order of their names."""
    found = root.rglob("*.parquet")
    return sorted(one for one in found if not one.name.startswith(("_", ".")))


def pieces_of(root: Path) -> tuple[list[Piece], dict[str, str]]:
    """Return the pieces of a data set, and the header keys that its files have in common.

    Raises
    ------
    BadInput
        A file is no Parquet, or two files disagree about a header key.
    """
    found: list[Piece] = []
    keys: dict[str, str] = {}
    for path in files_of(root):
        labels = labels_of(path.relative_to(root))
        with opened(path) as file:
            _agree(keys, file.schema_arrow.metadata, path)
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


def labels_of(path: Path) -> tuple[tuple[str, str], ...]:
    """Return the contract's labels that a path's folders spell, `NAME=VALUE` each.

    Folders by date or by number say nothing that the rows' times do not.
    """
    parts = (folder.partition("=") for folder in path.parts[:-1])
    return tuple((name, value) for name, equals, value in parts if equals and name in LABELS)


def opened(path: Path) -> Any:  # noqa: ANN401 - pyarrow is not typed
    """Open a Parquet file."""
    import pyarrow
    from pyarrow import parquet

    try:
        return parquet.ParquetFile(path, memory_map=True)
    except (pyarrow.ArrowException, OSError) as error:
        raise BadInput(f"no Parquet table: {str(error).splitlines()[0]}", path) from None


def _agree(keys: dict[str, str], metadata: dict[bytes, bytes] | None, path: Path) -> None:
    """Take over a file's header keys; whoever contradicts an earlier file is refused."""
    for name, value in ((k.decode(), v.decode()) for k, v in (metadata or {}).items()):
        if name in {"pandas", "ARROW:schema"}:
            continue
        if keys.setdefault(name, value) != value:
            raise BadInput(f"{name} is {value!r}, in files before it {keys[name]!r}", path)
