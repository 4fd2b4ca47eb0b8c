"""What the antennas of an array have in common: a scatter known from little is drawn toward it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.noise.series import Noise, Series
from pyport.thresholds import ENOUGH_ANTENNAS, PRIOR_DOF


def moderated(noises: Sequence[Noise], parts: Sequence[Series]) -> list[Noise]:
    """Draw the noise of antennas with few recordings toward what is usual in the array.

    A scale from few deviations is a rough one, and one that comes out small by
    chance makes its antenna outvote all others. The variances are averaged
    with the array's median, which counts as `PRIOR_DOF` deviations (Smyth 2004).
    """
    found = list(noises)
    for is_y in (False, True):
        own = [n for n, part in enumerate(parts) if part.is_y == is_y]
        if len(own) < ENOUGH_ANTENNAS:
            continue
        found = _repeating(found, parts, own)
        usual = float(np.median([found[n].floor for n in own]))
        for n in own:
            noise = found[n]
            if noise.floor > usual or noise.floor == 0:
                continue
            more = _shrunk(noise.floor, noise.dof, usual) / noise.floor
            found[n] = replace(
                noise,
                within=noise.within * more,
                between=noise.between * more,
                drifts=tuple((amplitude * more, time) for amplitude, time in noise.drifts),
                dof=noise.dof + PRIOR_DOF,
            )
    return found


def _repeating(noises: Sequence[Noise], parts: Sequence[Series], own: Sequence[int]) -> list[Noise]:
    """Shrink the scatter of an antenna's repeated readings toward the array's median, likewise.

    Repeated readings that are copies of one another do not determine it.
    """
    found = list(noises)
    repeated = [n for n in own if noises[n].within > 0]
    if len(repeated) < ENOUGH_ANTENNAS:
        return found
    usual = float(np.median([noises[n].within for n in repeated]))
    for n in repeated:
        within = noises[n].within
        if within < usual:
            spare = len(parts[n].rows) - len(parts[n].readings)
            found[n] = replace(noises[n], within=_shrunk(within, spare, usual))
    return found


def _shrunk(scatter: float, dof: float, usual: float) -> float:
    """Return a scatter from so many deviations, shrunk toward the array's median."""
    return float(np.sqrt((dof * scatter**2 + PRIOR_DOF * usual**2) / (dof + PRIOR_DOF)))
