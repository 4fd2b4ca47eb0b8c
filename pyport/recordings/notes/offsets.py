"""Offsets that stand for nothing, or only for a limit: one value in many rows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from pyport.angles import Array
from pyport.columns import angle_of
from pyport.recordings.mounted import OFFSETS
from pyport.recordings.raw import Raw
from pyport.recordings.schema import Recordings

#: What rounding repeats has neighbours in as many rows, and stands beside other offsets of the
#: other axis: none of 500 files with 40 rows of normal errors, rounded to their sigma or finer,
#: had a pair in three times as many rows as either.
MANY = 3
#: So many equal readings at the end of a range are no chance where the next one stands alone.
FEWEST_AT_LIMIT = 4


def note(recordings: Recordings, raw: Raw, *, by_row: bool = True) -> str:
    """Return which offsets stand in more rows than rounding explains, or at a limit, if any do.

    `by_row`: whether `--where` excludes them.
    """
    angles = {name: angle_of(name) for name in raw.columns}
    names = [name for name, angle in angles.items() if angle is not None and angle[0] in OFFSETS]
    kept = np.isin(raw.line, recordings.line)
    columns = {name: raw.numbers(name)[kept] for name in names}
    return _pair(columns, by_row=by_row) or _limits(columns)


def _pair(columns: Mapping[str, Array], *, by_row: bool) -> str:
    """Return which offsets of both axes stand together in more rows than rounding explains."""
    if len(columns) != 2:
        return ""
    one, other = columns.values()
    pairs = (one + 1j * other)[np.isfinite(one) & np.isfinite(other)]
    values, counts = np.unique(pairs, return_counts=True)
    if not len(counts):
        return ""
    most, rows = values[np.argmax(counts)], counts.max()
    apart = max(np.sum(pairs.real == most.real), np.sum(pairs.imag == most.imag)) - rows
    # the second most may stand for nothing as well
    third = np.sort(np.append(counts, [1, 1]))[-3]
    if rows < MANY * max(apart, third):
        return ""
    pair = list(zip(columns, (most.real, most.imag), strict=True))
    both = " and ".join(f"{name} {value:.15g}" for name, value in pair)
    others = " or ".join(f"{name} != {value:.15g}" for name, value in pair)
    return (
        f"{both} stand together in {rows} of {len(pairs)} rows, which may mean that "
        "nothing was measured there" + f': --where "{others}" excludes them' * by_row
    )


def _limits(columns: Mapping[str, Array]) -> str:
    """Return at which largest or smallest offsets readings pile up, if they do.

    What was cut off there is only known to be at least as large. Of what is rounded there are fewer
    readings at the end of the range than beside it.
    """
    found = []
    for name, column in columns.items():
        values = column[np.isfinite(column)]
        ends = [_piled_up(values, end) for end in (np.min, np.max)]
        if any(ends) and len(np.unique(values)) >= FEWEST_AT_LIMIT:
            found.append(f"{name} ends {' and '.join(filter(None, ends))}")
    cut = "what was cut off there is only known to be at least as large"
    return f"{', '.join(found)}: {cut}" if found else ""


def _piled_up(values: Array, end: Callable[[Array], Any]) -> str:
    """Return how many readings pile up at an end of their range; nothing where they do not."""
    if not len(values):
        return ""
    last = values == end(values)
    rows, inner = np.count_nonzero(last), values[~last]
    beside = np.count_nonzero(inner == end(inner)) if len(inner) else 0
    if rows < max(FEWEST_AT_LIMIT, MANY * beside):
        return ""
    return f"at {end(values):.15g} in {rows} rows"
