"""Rows whose tail was taken over from an earlier row: the same cells, a chance number among them.

An antenna that finds no peak reports a chance number. Where a row has the same
one as a row of another scan, and its neighbours besides, it was not measured
there. The earlier row is taken to be the original.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pyport.studies.gmrt.recovery.printed import NO_PEAK, Row, minutes

#: No antenna that sees the source is off by more; such a number is chance [arcmin].
LARGEST_ARCMIN = 40

#: The run of equal cells that convinces, a chance number among them.
SHORTEST_RUN = 4

#: How far cells of the two rows may be displaced by those that were lost.
FARTHEST_SHIFT = 3


@dataclass(frozen=True)
class Repeat:
    """Cells `first` to `last` (exclusive, from 0) of a row that repeat another printed row."""

    row: int
    first: int
    last: int
    of: int


def repeats(rows: Sequence[Row], scans: Sequence[int]) -> list[Repeat]:
    """Return the runs of cells that repeat an earlier row of another scan."""
    found = []
    for later, row in enumerate(rows):
        for original, scan in zip(rows[:later], scans, strict=False):
            if scan != scans[later]:
                found += _common(row, original)
    return found


def _common(row: Row, original: Row) -> list[Repeat]:
    """Return the convincing runs that two rows share."""
    found = []
    for shift in range(-FARTHEST_SHIFT, FARTHEST_SHIFT + 1):
        first = 0
        while first < len(row.offsets):
            last = first
            while (
                last < len(row.offsets)
                and 0 <= last + shift < len(original.offsets)
                and row.offsets[last] == original.offsets[last + shift]
            ):
                last += 1
            run = row.offsets[first:last]
            if len(run) >= SHORTEST_RUN and any(map(_by_chance, run)):
                found.append(Repeat(row.number, first, last, original.number))
            first = max(last, first + 1)
    return found


def _by_chance(text: str) -> bool:
    """Tell whether a cell is a number that two scans do not share but by copying."""
    offset = minutes(text)
    return offset is not None and abs(offset) > LARGEST_ARCMIN and abs(offset) not in NO_PEAK
