"""Rows of a data set as they stand: what they say against themselves, means do not say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from pyport.errors import BadInput
from pyport.recordings.interpret import interpret
from pyport.recordings.notes import sentences
from pyport.recordings.raw import BLANK, Raw
from pyport.recordings.stream.chunk import cells
from pyport.recordings.stream.pieces import Piece

#: So many rows, of so many files, evenly chosen, show what holds for most of them.
ROWS, FILES = 4000, 8


def notes(root: Path, pieces: Sequence[Piece], keys: dict[str, str]) -> Iterator[str]:
    """Yield what a sample of a data set, of these header keys, says against itself."""
    raw = _sample(root, pieces, keys)
    with suppress(BadInput):  # whatever is wrong with a row is said where all are read
        recordings = interpret(raw)
        if len(recordings):
            yield from sentences(recordings, raw, by_row=False).values()
        if BLANK in recordings.meta:
            yield f"taken for blank, of {len(raw.line)} rows looked at: {recordings.meta[BLANK]}"


def _sample(root: Path, pieces: Sequence[Piece], keys: dict[str, str]) -> Raw:
    """Return the first rows of some pieces, the columns that all of them have."""
    some = pieces[:: -(-len(pieces) // FILES)]
    parts = []
    for piece in some:
        batch = next(iter(piece.batches(ROWS // len(some))), None)
        if batch is not None and batch.num_rows:
            parts.append(cells(batch, piece, piece.first_row)[0].columns)
    shared = [name for name in parts[0] if all(name in one for one in parts)] if parts else []
    columns = {name: np.concatenate([np.asarray(one[name]) for one in parts]) for name in shared}
    rows = max((len(one) for one in columns.values()), default=0)
    return Raw(root, keys, 1, columns, np.arange(1, rows + 1))
