"""The axis of time: gaps between campaigns are cut out, so that what was observed fills it."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array

#: Gaps longer than this may be cut out [s].
SHORTEST_GAP = 6 * 3600.0
MOST_STRETCHES = 40


def stretches(time: Array) -> list[tuple[float, float]]:
    """Return the stretches (from, to) [s] in which observations lie close together.

    There are at most `MOST_STRETCHES`: where more campaigns were observed, only
    the longest gaps are cut out.
    """
    known = np.unique(time[np.isfinite(time)])
    if len(known) == 0:
        return []
    gaps = np.diff(known)
    shortest = SHORTEST_GAP
    if (gaps > shortest).sum() >= MOST_STRETCHES:
        shortest = float(np.sort(gaps)[-MOST_STRETCHES])
    cuts = np.flatnonzero(gaps > shortest)
    first = known[np.concatenate([[0], cuts + 1])]
    last = known[np.concatenate([cuts, [len(known) - 1]])]
    return [(float(a), float(b)) for a, b in zip(first, last, strict=True)]
