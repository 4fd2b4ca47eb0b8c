"""Outliers that are no gross errors: they are most of a session, a receiver or a source."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Codes
from pyport.effects.empirical.fields import stepped
from pyport.noise.pointings import pointings
from pyport.recordings.schema import Recordings, Stack, group
from pyport.thresholds import CARRIERS, MOSTLY

#: Labels that outliers may share -> what that says.
_SAYS = {
    "session": "the telescope was in another state then",
    "receiver": "it has offsets that the model does not allow for",
    "source": "its place may be wrong",
}
_RESTLESS = "the telescope had not come to rest, or stands where it came from"


@dataclass(frozen=True)
class _Group:
    """Pointings that outliers may have in common: which, whose they are, and what that says."""

    which: str
    whose: str
    says: str


def shared(recordings: Recordings, stack: Stack, used: NDArray[np.bool_]) -> Iterator[str]:
    """Yield a sentence for each session, receiver and source most of whose pointings are outliers.

    And for the longest slews. Nothing is said of fewer than `CARRIERS` pointings, nor of those that
    an earlier sentence names.

    `used`: which of the m readings are no outliers, shape (m,).
    """
    if used.all():
        return
    out = ~used
    number = pointings(recordings)[stack.row]
    for of_row, some in _groups(recordings, number, out):
        of_reading = of_row[stack.row]
        every, bad = (
            np.bincount(
                np.unique(np.stack([of_reading[one], number[one]]), axis=1)[0], None, len(some)
            )
            for one in (np.ones(len(used), bool), out)
        )
        for code in np.flatnonzero((bad >= CARRIERS) & (bad > MOSTLY * every)):
            group_of, own = some[code], out & (of_reading == code)
            if group_of is not None:
                yield (
                    f"{own.sum()} of {np.count_nonzero(~used)} outliers are {group_of.which} "
                    f"({bad[code]} of {group_of.whose} {every[code]} pointings): {group_of.says}, "
                    "these are no gross errors, and the rms leaves them out"
                )
                out = out & ~own


def _groups(
    recordings: Recordings, number: Codes, out: NDArray[np.bool_]
) -> Iterator[tuple[Codes, list[_Group | None]]]:
    """Yield the group of each row (n,), and the groups; None for rows that are of none.

    `number`, `out`: of readings, the number of their pointing, and which are outliers.
    """
    for label, says in _SAYS.items():
        of_row, names = group(recordings, (label,))
        if len(names) > 1:
            yield (
                of_row,
                [_Group(f"in {label} {name}", "its", says) if name else None for (name,) in names],
            )
    many = len(np.unique(number[out]))
    if "time" in recordings.at and 2 * many < len(recordings):
        far = np.zeros(len(recordings), np.intp)
        far[np.argsort(-stepped(recordings.at), kind="stable")[:many]] = 1
        yield far, [None, _Group("the first after the longest slews", "those", _RESTLESS)]
