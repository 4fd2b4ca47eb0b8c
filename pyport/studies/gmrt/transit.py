"""A jump when the source crosses the meridian, which section 5 (a) says is gone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import HOUR
from pyport.studies.gmrt.tracks import Track, line

#: Scans this near to transit are looked at [rad].
REACH = 2.5 * HOUR

#: So many are needed on either side.
EACH_SIDE = 3


@dataclass(frozen=True)
class Jump:
    """The step of one antenna's offsets at transit, with its sigma [rad]."""

    antenna: str
    session: str
    step: float
    sigma: float


@dataclass(frozen=True)
class Jumps:
    """All steps of a day.

    Attributes
    ----------
    session
        The day.
    jumps
        Of each antenna.
    mean, sigma
        Of all steps, each weighted by its error [rad].
    p_value
        Chance of steps so large without any jump (chi-square).
    """

    session: str
    jumps: tuple[Jump, ...]
    mean: float
    sigma: float
    p_value: float


def jumps_at_transit(found: Sequence[Track]) -> list[Jumps]:
    """Return each day's steps at transit beyond a parabola and forward minus reverse."""
    from scipy.stats import chi2

    days = []
    for session in sorted({track.session for track in found}):
        each = [jump for track in found if track.session == session and (jump := _jump(track))]
        if not each:
            continue
        step, sigma = (np.array([getattr(one, name) for one in each]) for name in ("step", "sigma"))
        weight = 1 / sigma**2
        p_value = float(chi2.sf(((step / sigma) ** 2).sum(), len(each)))
        mean = float((weight * step).sum() / weight.sum())
        days.append(Jumps(session, tuple(each), mean, float(weight.sum() ** -0.5), p_value))
    return days


def _jump(track: Track) -> Jump | None:
    """Return the step of a track, None where it has too few scans on either side."""
    near = np.abs(track.hour_angle) <= REACH
    after = track.hour_angle[near] > 0
    if min(after.sum(), (~after).sum()) < EACH_SIDE:
        return None
    powers = np.vander(track.hour_angle[near], 3)
    side = after.astype(float)
    fit = line(
        np.concatenate([side[:, None], track.direction[near, None], powers], axis=1),
        track.offset[near],
    )
    return Jump(track.antenna, track.session, float(fit.value[0]), float(fit.sigma[0]))
