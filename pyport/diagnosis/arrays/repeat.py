"""Do own parts repeat? Those of some sessions predict the others, shape by shape."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.arrays.blocks import Block
from pyport.diagnosis.arrays.lasting import Lasting, lasting, told_well
from pyport.diagnosis.joint import rms
from pyport.thresholds import ENOUGH_ANTENNAS


@dataclass(frozen=True)
class Repeat:
    """One shape's own parts in one session beside those of all other sessions.

    Attributes
    ----------
    session, antennas
        The session held out, and the n antennas told well both there and elsewhere.
    own, others
        Their own parts there and elsewhere, about the mean, shape (n,).
    common, common_sigma
        The session's common part when the antennas' own parts come from the others.
    correlation
        Of `own` and `others`.
    size, left, noise
        Rms of `own`, of what `others` leave of it, and what their errors alone would leave.
    p_value
        Chance of so much left by the errors alone.
    """

    session: str
    antennas: tuple[str, ...]
    own: Array
    others: Array
    common: float
    common_sigma: float
    correlation: float
    size: float
    left: float
    noise: float
    p_value: float


def repeats(blocks: Sequence[Block], shared: Collection[int], shape: int) -> list[Repeat]:
    """Hold each session out in turn, and compare one shape's own parts with the others'."""
    found = []
    for session in sorted({one.session for one in blocks}):
        inside = [one for one in blocks if one.session == session]
        outside = [one for one in blocks if one.session != session]
        both = {one.antenna for one in inside} & {one.antenna for one in outside}
        if len(both) >= ENOUGH_ANTENNAS:
            one = _compared(session, lasting(inside, shared), lasting(outside, shared), shape)
            if one is not None:
                found.append(one)
    return found


def _compared(session: str, inside: Lasting, outside: Lasting, shape: int) -> Repeat | None:
    """Compare one session's own parts with the others'."""
    from scipy.stats import chi2

    values, covariances, levels = [], [], []
    known = _well(inside, shape) & _well(outside, shape)
    names = tuple(sorted(known))
    if len(names) < ENOUGH_ANTENNAS:
        return None
    for parts in (inside, outside):
        at = [parts.antennas.index(name) for name in names]
        values.append(parts.own[at, shape])
        covariances.append(parts.own_covariance(shape)[np.ix_(at, at)])
        levels.append(float(values[-1].mean()))
    about = np.eye(len(names)) - 1 / len(names)
    covariance = about @ (covariances[0] + covariances[1]) @ about
    own, others = (about @ value for value in values)
    difference = own - others
    common, variance = levels[0] - levels[1], np.mean(np.diag(covariance)) / len(names)
    if shape in inside.shared:
        common += float(inside.common[0, shape])
    squares = float(difference @ np.linalg.pinv(covariance, rcond=1e-9) @ difference)
    return Repeat(
        session,
        names,
        own,
        others,
        common,
        float(np.sqrt(variance)),
        float(np.corrcoef(own, others)[0, 1]) if own.any() and others.any() else 0.0,
        rms(own),
        rms(difference),
        float(np.sqrt(np.mean(np.diag(covariance)))),
        float(chi2.sf(squares, len(names) - 1)),
    )


def _well(parts: Lasting, shape: int) -> set[str]:
    """Return the antennas whose own part is told well."""
    well = told_well(parts.own_covariance(shape))
    return {name for name, good in zip(parts.antennas, well, strict=True) if good}
