"""Rows that stand in a file twice: the same measurement told again makes nobody surer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyport.recordings.raw import Raw
from pyport.recordings.schema import Recordings

#: Odd multipliers that spread the bits of a row's numbers over one word.
_SPREAD = (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0xD6E8FEB86659FD93, 1)


def repeated(raw: Raw, recordings: Recordings) -> dict[int, int]:
    """Return the rows that repeat an earlier one in every cell, and the line of that one.

    Only rows that tell their time: two measurements of one moment, place, antenna
    and value are one. Without a time equal rows may be two measurements.

    `raw`: the cells of a file, n rows.
    `recordings`: what they mean, none of the n excluded yet.
    """
    at = recordings.at
    if "time" not in at:
        return {}
    time = at.column("time")
    suspects = np.flatnonzero(_shared(time, at.az, at.el, recordings.x, recordings.y))
    suspects = suspects[np.isfinite(time[suspects])]
    first: dict[tuple[str, ...], int] = {}
    found: dict[int, int] = {}
    for row in suspects.tolist():
        cells = tuple(str(column[row]) for column in raw.columns.values())
        earlier = first.setdefault(cells, row)
        if earlier != row:
            found[row] = int(raw.line[earlier])
    return found


def _shared(*columns: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell the rows whose numbers may be those of another row, shape (n,)."""
    mixed = np.zeros(len(columns[0]), np.uint64)
    for column, factor in zip(columns, _SPREAD, strict=True):
        bits = (np.nan_to_num(column) + 0.0).view(np.uint64)
        mixed = (mixed ^ bits) * np.uint64(factor)
        mixed ^= mixed >> np.uint64(29)
    order = np.argsort(mixed)
    same = np.diff(mixed[order]) == 0
    shared = np.zeros(len(mixed), bool)
    shared[order[1:][same]] = True
    shared[order[:-1][same]] = True
    return shared
