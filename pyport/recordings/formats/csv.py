"""CSV: `# key: value`, names, a line a recording."""

from __future__ import annotations

import csv
import io
import operator
import re
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.recordings.formats.text import MOST_COLUMNS, Line, is_separator, read_text
from pyport.recordings.naming import comment, is_key
from pyport.recordings.raw import Raw, TextColumn
from pyport.recordings.schema import Table

_LINE = re.compile(r"[^\r\n]*(?:\r\n?|\n)|[^\r\n]+")

#: From so many bytes on Arrow is worth its import: a tenth of a second, and four where there is
#: pandas, which it imports too.
LEAST_BYTES = 2**22


def plain_columns(
    body: bytes, names: list[str], above: int
) -> tuple[dict[str, TextColumn], NDArray[np.int64]] | None:
    """Return the columns of the rows below the names and the line of each row.

    None where a cell is quoted, a line ends in something else or a row has not as many
    cells as there are names: Python's reader then reads the rows, or says what is wrong.

    `body`: what stands below the line of names, in UTF-8.
    `names`: the columns' names.
    `above`: how many lines stand above the rows.
    """
    if len(body) < LEAST_BYTES or b'"' in body or body.count(b"\r") != body.count(b"\r\n"):
        return None
    text = np.frombuffer(body, np.uint8)
    ends = np.flatnonzero(text == ord("\n"))
    starts = np.concatenate([[0], ends + 1])
    starts = starts[starts < len(body)]
    if np.diff(starts, append=len(body)).max() > csv.field_size_limit():
        return None
    first = text[starts]
    rows = (first != ord("\n")) & (first != ord("\r")) & (first != ord("#"))
    if not rows.all():
        lines = body.splitlines(keepends=True)
        body = b"".join(line for line, kept in zip(lines, rows.tolist(), strict=True) if kept)
    if not body:
        return None
    found = _parsed(body, names)
    return None if found is None else (found, above + 1 + np.flatnonzero(rows))


def _parsed(body: bytes, names: list[str]) -> dict[str, TextColumn] | None:
    """Return the cells of lines that are all rows."""
    import pyarrow
    from pyarrow import csv as arrow_csv

    try:
        table = arrow_csv.read_csv(
            pyarrow.py_buffer(body),
            arrow_csv.ReadOptions(use_threads=False, column_names=names),
            arrow_csv.ParseOptions(quote_char=False),
            arrow_csv.ConvertOptions(
                check_utf8=False,  # the text was decoded before
                column_types=dict.fromkeys(names, pyarrow.string()),
                strings_can_be_null=False,
            ),
        )
    except pyarrow.ArrowInvalid:
        return None
    return {name: TextColumn(table[name].combine_chunks()) for name in names}


def read(path: Path, names: tuple[str, ...] = ()) -> Raw:
    """Read the cells of a CSV file; `names` are those of its columns where it has no header.

    A first column without a name that counts the rows from 0, the index of pandas, is passed over.

    Raises `BadInput`: no header, no rows, a row with too few or too many cells, no text.
    """
    text = read_text(path)
    meta: dict[str, str] = {}
    key_line: dict[str, int] = {}
    skipped = size = 0
    header = ""
    for header in map(operator.itemgetter(0), _LINE.finditer(text)):
        if header.startswith("#"):
            pair = comment(header)
            if pair is not None:
                _add(meta, key_line, *pair, Line(path, skipped + 1, header))
        elif header.strip() and not is_separator(header):
            break
        skipped += 1
        size += len(header)
    else:
        raise BadInput("no line of column names, expected one such as az_deg,el_deg,...", path)
    above = skipped if names else skipped + 1
    columns = _names(",".join(names) or header, path, above)
    body = text[size if names else size + len(header) :]
    _add_below(meta, key_line, body, path, above)
    plain = plain_columns(body.encode(), columns, above)
    if plain is not None:
        return _without_index(Raw(path, meta, max(above, 1), *plain, key_line))
    rows, lines = _rows(text, above, path)
    expected = "as named" if names else "as in the header"
    for row, line in zip(rows, lines, strict=True):
        if len(row) != len(columns):
            count = f"{len(row)} cell{'s' * (len(row) != 1)}"
            raise BadInput(f"{count}, expected {len(columns)} {expected}", path, line)
    if not rows:
        raise BadInput("no rows below the column names", path, above)
    cells = [np.array(column, object) for column in zip(*rows, strict=True)]
    named = dict(zip(columns, cells, strict=True))
    return _without_index(
        Raw(path, meta, max(above, 1), named, np.array(lines, np.int64), key_line)
    )


def _without_index(raw: Raw) -> Raw:
    """Return the cells without a first column that counts the rows and has no name.

    Raises `BadInput`: there is one that does not count them.
    """
    if "" not in raw.columns:
        return raw
    for row, cell in enumerate(raw.words("").tolist()):
        if cell != str(row):
            wanted = "expected one, or 0, 1, 2, ... below it, the index of pandas"
            raise raw.error(f"column 1 of the header has no name, {wanted}; it has {cell!r}", row)
    named = {name: cells for name, cells in raw.columns.items() if name}
    note = "the first column, which has no name and counts the rows from 0, is passed over"
    return replace(raw, columns=named, note=note)


def _add(meta: dict[str, str], key_line: dict[str, int], key: str, value: str, line: Line) -> None:
    """Add a header key; of keys that decide nothing the last value is kept.

    Raises `BadInput`: the contract's key has another value in a line before.
    """
    before = meta.get(key, value)
    if before != value and is_key(key, value) and key != "telescope":
        wrong = f"{key} is {value!r}, expected {before!r} as in line {key_line[key]}"
        raise line.error(f"{wrong}, or one of the two alone")
    meta[key], key_line[key] = value, line.number


def _add_below(
    meta: dict[str, str], key_line: dict[str, int], body: str, path: Path, above: int
) -> None:
    """Add the contract's keys that stand below the column names; refuse as `_add` does."""
    if not body.startswith("#") and "\n#" not in body:
        return
    for number, line in enumerate(body.splitlines(), above + 1):
        pair = comment(line) if line.startswith("#") else None
        if pair is None or not is_key(*pair):
            continue
        _add(meta, key_line, *pair, Line(path, number, line))


def _names(header: str, path: Path, line: int) -> list[str]:
    try:
        names = [name.strip() for name in next(csv.reader([header]))]
    except csv.Error as error:
        raise BadInput(f"{error}, expected column names", path, line) from None
    if len(names) > MOST_COLUMNS:
        raise BadInput(f"{len(names)} columns, expected at most {MOST_COLUMNS}", path, line)
    if len(names) == 1:
        wanted = "expected column names separated by commas, such as az_deg,el_deg,d_el_deg"
        wrong = f"the header is {header.strip()[:60]!r}, {wanted}; --columns reads any other table"
        raise BadInput(wrong, path, line)
    seen: set[str] = set()
    for position, name in enumerate(names):
        if not name and position:
            wrong = f"column {position + 1} of the header has no name, expected one"
            raise BadInput(wrong, path, line)
        if name in seen:
            raise BadInput(f"two columns are called {name!r}, expected one", path, line)
        seen.add(name)
    return names


def _rows(text: str, skipped: int, path: Path) -> tuple[list[list[str]], list[int]]:
    """Return the rows below the header, and the line that each ends on."""
    reader = _reader(text, skipped)
    try:
        rows = list(reader)
    except csv.Error as error:
        raise _not_csv(error, text, skipped, path) from None
    lines: Iterable[int] = range(skipped + 1, skipped + 1 + len(rows))
    if reader.line_num != len(rows):  # some cell holds a line break
        reader = _reader(text, skipped)
        lines = [skipped + reader.line_num for _ in reader]
    kept = [
        (row, line)
        for row, line in zip(rows, lines, strict=True)
        if row and not row[0].startswith("#")
    ]
    return [row for row, _ in kept], [line for _, line in kept]


def _not_csv(error: csv.Error, text: str, skipped: int, path: Path) -> BadInput:
    """Return what is wrong, at the line in which the row begins that cannot be read.

    A quote that is not closed takes in the lines below it, often to the end of the file.
    """
    reader, first = _reader(text, skipped), skipped + 1
    with suppress(csv.Error):
        for _ in reader:
            first = skipped + reader.line_num + 1
    last = skipped + reader.line_num
    wrong = f"{error}" if last == first else f"a quote is not closed ({error} in line {last})"
    return BadInput(f"{wrong}, expected CSV", path, first)


def _reader(text: str, skipped: int) -> Any:  # noqa: ANN401 - csv keeps its reader's type to itself
    """Return a reader of the lines below the first ones."""
    return csv.reader(islice(io.StringIO(text, newline=""), skipped, None), strict=True)


def write(table: Table, path: Path) -> None:
    """Write a table as CSV, numbers so that they come back as they were."""
    cells = [
        column.tolist()
        if column.dtype.kind == "U"
        else ["" if value != value else repr(value) for value in column.tolist()]  # noqa: PLR0124
        for column in table.columns.values()
    ]
    with write_whole(path) as file:
        file.writelines(f"# {key}: {value}\n" for key, value in table.meta.items())
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(table.columns)
        writer.writerows(zip(*cells, strict=True))
