"""Offsets that stand for nothing, of which files have one and the same pair in many rows."""

from __future__ import annotations

import numpy as np

from pyport.columns import angle_of
from pyport.recordings.mounted import OFFSETS
from pyport.recordings.raw import Raw
from pyport.recordings.schema import Recordings

#: By rounding some offsets stand in several rows, others in nearly as many: in three times as many
#: rows as any others stands what was not measured.
MANY = 3


def note(recordings: Recordings, raw: Raw) -> str:
    """Return which offsets of both axes stand in more rows than rounding explains, if any do."""
    names = [
        name
        for name in raw.columns
        if (angle := angle_of(name)) is not None and angle[0] in OFFSETS
    ]
    if len(names) != 2:
        return ""
    kept = np.isin(raw.line, recordings.line)
    one, other = (raw.numbers(name)[kept] for name in names)
    pairs = (one + 1j * other)[np.isfinite(one) & np.isfinite(other)]
    values, counts = np.unique(pairs, return_counts=True)
    different = np.unique(np.append(counts, 1))
    if not np.any(different[1:] >= MANY * different[:-1]):
        return ""
    most = values[np.argmax(counts)]
    pair = list(zip(names, (most.real, most.imag), strict=True))
    told = " and ".join(f"{name} {value:.15g}" for name, value in pair)
    others = " or ".join(f"{name} != {value:.15g}" for name, value in pair)
    return (
        f"{told} stand together in {counts.max()} of {len(pairs)} rows, which may mean that "
        f'nothing was measured there: --where "{others}" excludes them'
    )
