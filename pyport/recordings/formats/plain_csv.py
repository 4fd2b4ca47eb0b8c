"""The rows of a plain CSV, without quotes, by Arrow; the others are left to Python's own reader."""

from __future__ import annotations

import csv

import numpy as np
from numpy.typing import NDArray

from pyport.recordings.text_column import TextColumn

#: From so many bytes on Arrow is worth its import, a tenth of a second.
LEAST_BYTES = 2**20


def columns(
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
