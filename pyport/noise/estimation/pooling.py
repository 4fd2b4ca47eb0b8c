"""Scatter that is known from little or nothing: it is drawn toward what others have.

An axis of few readings to spare has what the model leaves of both, if that is more: its columns
may go right through it, and it would outvote the other. An antenna of few readings has nearly
the scatter of its array.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.angles import Array
from pyport.least_squares.gram import spanned
from pyport.noise.series import Noise, Series
from pyport.thresholds import ENOUGH_ANTENNAS, FEWEST, PRIOR_DOF


def pooled(
    noises: Sequence[Noise],
    parts: Sequence[Series],
    value: Array,
    design: Array,
    weight: Array,
) -> list[Noise]:
    """Return noises that are known from some deviations each: see the module.

    `value`, `design`, `weight`: the data of all readings [rad], shape (m,), the model's columns,
    (m, P), and robust weights, (m,).
    """
    found = list(noises)
    axes = Counter(part.antenna for part in parts)
    few = [n for n, part in enumerate(parts) if noises[n].dof < FEWEST and axes[part.antenna] > 1]
    for antenna in dict.fromkeys(parts[n].antenna for n in few):
        rows = np.concatenate([part.rows for part in parts if part.antenna == antenna])
        root = np.sqrt(weight[rows])
        basis = spanned(root[:, None] * design[rows][:, design[rows].any(axis=0)])[0]
        left = root * value[rows]
        left = left - basis @ (basis.T @ left)
        spare = max(1.0, float(weight[rows].sum()) - basis.shape[1])
        variance = float(left @ left) / spare
        for n in few:
            if parts[n].antenna == antenna:
                between = max(variance - found[n].within ** 2, found[n].between ** 2)
                found[n] = replace(found[n], between=float(np.sqrt(between)), dof=spare)
    return moderated(found, parts)


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
