"""Outliers that are no gross errors: they are most of a session, a receiver or a source."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pyport.noise.pointings import pointings
from pyport.recordings.schema import Recordings, Stack, group
from pyport.thresholds import CARRIERS, MOSTLY

#: Labels that outliers may share -> what that says.
_SAYS = {
    "session": "the telescope was in another state then",
    "receiver": "it has offsets that the model does not allow for",
    "source": "its place may be wrong",
}


def shared(recordings: Recordings, stack: Stack, used: NDArray[np.bool_]) -> Iterator[str]:
    """Yield a sentence for each session, receiver and source most of whose pointings are outliers.

    Nothing is said of fewer than `CARRIERS` pointings, nor of those that an earlier sentence names.

    `used`: which of the m readings are no outliers, shape (m,).
    """
    if used.all():
        return
    out = ~used
    number = pointings(recordings)[stack.row]
    for label, says in _SAYS.items():
        of_row, names = group(recordings, (label,))
        of_reading = of_row[stack.row]
        every, bad = (
            np.bincount(
                np.unique(np.stack([of_reading[one], number[one]]), axis=1)[0], None, len(names)
            )
            for one in (np.ones(len(used), bool), out)
        )
        for code in np.flatnonzero((bad >= CARRIERS) & (bad > MOSTLY * every)):
            (name,), own = names[code], out & (of_reading == code)
            if name and len(names) > 1:
                yield (
                    f"{own.sum()} of {np.count_nonzero(~used)} outliers are in {label} {name} "
                    f"({bad[code]} of its {every[code]} pointings): {says}, these are no gross "
                    "errors, and the rms leaves them out"
                )
                out = out & ~own
