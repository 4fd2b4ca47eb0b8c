"""Offsets that stand for nothing, or only for a limit: one value in many rows."""

from __future__ import annotations

import numpy as np

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
    """Return which offsets of both axes stand in more rows than rounding explains, if any do.

    `by_row`: whether `--where` excludes them.
    """
    names = _columns(raw)
    if len(names) != 2:
        return ""
    kept = np.isin(raw.line, recordings.line)
    one, other = (raw.numbers(name)[kept] for name in names)
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
    pair = list(zip(names, (most.real, most.imag), strict=True))
    both = " and ".join(f"{name} {value:.15g}" for name, value in pair)
    others = " or ".join(f"{name} != {value:.15g}" for name, value in pair)
    return (
        f"{both} stand together in {rows} of {len(pairs)} rows, which may mean that "
        "nothing was measured there" + f': --where "{others}" excludes them' * by_row
    )


def limits(recordings: Recordings, raw: Raw) -> str:
    """Return at which largest or smallest offsets readings pile up, if they do.

    What was cut off there is only known to be at least as large. Of what is rounded there are fewer
    readings at the end of the range than beside it.
    """
    kept = np.isin(raw.line, recordings.line)
    found = []
    for name in _columns(raw):
        values = raw.numbers(name)[kept]
        levels, counts = np.unique(values[np.isfinite(values)], return_counts=True)
        if len(levels) < FEWEST_AT_LIMIT:
            continue
        ends = [
            f"at {levels[end]:.15g} in {counts[end]} rows"
            for end, beside in ((0, 1), (-1, -2))
            if counts[end] >= max(FEWEST_AT_LIMIT, MANY * counts[beside])
        ]
        if ends:
            found.append(f"{name} ends {' and '.join(ends)}")
    cut = "what was cut off there is only known to be at least as large"
    return f"{', '.join(found)}: {cut}" if found else ""


def _columns(raw: Raw) -> list[str]:
    """Return the columns of offsets."""
    angles = {name: angle_of(name) for name in raw.columns}
    return [name for name, angle in angles.items() if angle is not None and angle[0] in OFFSETS]
