"""Fitting the noise: robust, with every shape that physics could give taken out first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.noise import (
    APART,
    ENOUGH_FOR_DRIFT,
    FAR,
    TUKEY,
    Noise,
    Series,
    by_pointing,
    factor,
)
from pyport.fitting import robust
from pyport.fitting.pivoting import most_different
from pyport.fitting.stacking import Codes

#: Pointings for each shape that may be taken out before the noise is read off.
POINTINGS_PER_SHAPE = 4
#: No more shapes than this: the most different ones draw what the others can.
MOST_SHAPES = 80
#: A shape that keeps less of its length beside those taken out is none of its own.
DIFFERENT = 0.05
#: A column whose neighbours in time are this much alike is slow: a drift could pass for it.
SLOW = 0.9
#: So many of the slow ones are taken out: more would leave nothing to tell a drift by.
MOST_SLOW = 8
#: Strengths of a drift, over the scatter of pointings, that are weighed against each other.
RATIOS = (0.15, 0.25, 0.4, 0.6, 0.9, 1.4, 2.5)
#: So many memories are, from this many steps between pointings on.
MEMORIES, SHORTEST_MEMORY = 7, 2.0
#: What has less of the variance than this is left out.
FAINT = 1e-4
#: A drift that remembers longer than this is no noise: it is an effect of time. [s]
LONGEST_MEMORY = 86400.0
#: Sessions of so many pointings on average have their own constants taken out first.
POINTINGS_PER_SESSION = 12
#: The array's usual noise counts as this many deviations where an antenna has few of its own.
PRIOR_DOF = 6.0
#: Antennas from which on there is a usual noise.
ENOUGH_ANTENNAS = 5


def fit(
    value: Array, base: Array, shapes: Array, parts: Sequence[Series]
) -> tuple[list[Noise], Array]:
    """Fit the noise of each series.

    Parameters
    ----------
    value
        The data [rad], shape (m,).
    base
        Columns of the model that is always fitted, shape (m, p); columns of
        other antennas may be zero in a series.
    shapes
        Columns of every candidate, shape (m, K): the noise must not contain what they explain.
    parts
        The series.

    Returns
    -------
    noises
        One for each series.
    weights
        Robust weights of the readings, shape (m,).
    """
    weights = np.ones(len(value))
    of_axis = np.zeros(len(value), bool)
    for part in parts:
        of_axis[part.rows] = part.is_y
    floors = {is_y: robust.rounding(value[of_axis == is_y]) for is_y in (False, True)}
    grid = _grid(parts)
    drafts = []
    for part in parts:
        known = np.concatenate([base[part.rows], _of_sessions(part)], axis=1)
        columns = _rich(known, shapes[part.rows], int(part.pointing.max()) + 1)
        floor = floors[part.is_y]
        weights[part.rows], residual = robust.weights(columns, value[part.rows], TUKEY, floor)
        given = value[part.rows], columns, weights[part.rows], residual
        drafts.append(_draft(*given, part, grid, floor))
    noises = [
        draft.noise(_beside(drafts, parts, n), floors[parts[n].is_y])
        for n, draft in enumerate(drafts)
    ]
    return _moderated(noises, parts), weights


def _moderated(noises: list[Noise], parts: Sequence[Series]) -> list[Noise]:
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
        usual = float(np.median([noises[n].floor for n in own]))
        for n in own:
            noise = noises[n]
            shrunk = (noise.dof * noise.floor**2 + PRIOR_DOF * usual**2) / (noise.dof + PRIOR_DOF)
            if noise.floor > usual or noise.floor == 0:
                continue
            more = float(np.sqrt(shrunk)) / noise.floor
            found[n] = replace(
                noise,
                within=noise.within * more,
                between=noise.between * more,
                drifts=tuple((amplitude * more, time) for amplitude, time in noise.drifts),
                dof=noise.dof + PRIOR_DOF,
            )
    return found


def _of_sessions(part: Series) -> Array:
    """Return a column for each session but the first.

    A drift must show within the sessions: from one to the next it could pass
    for anything that was moved in between.
    """
    if part.time is None:
        return np.zeros((len(part.rows), 0))
    session = np.concatenate([[0], np.cumsum(np.diff(part.time) > APART / 2)])[part.pointing]
    count = int(session.max())
    if (count + 1) * POINTINGS_PER_SESSION > len(part.time):
        return np.zeros((len(part.rows), 0))
    return (session[:, None] == np.arange(1, count + 1)).astype(float)


def _rich(base: Array, shapes: Array, pointings: int) -> Array:
    """Return the base and the main directions of what the candidates could add to it.

    The directions come from the geometry alone, never from the data, so that
    the noise is not whittled down by the search. The result is orthonormal.
    """
    base = base[:, np.any(base != 0, axis=0)]
    orthonormal = _orthonormal(base)
    room = max(0, min(pointings // POINTINGS_PER_SHAPE, pointings // 2 - orthonormal.shape[1]))
    length = np.linalg.norm(shapes, axis=0)
    new = shapes - orthonormal @ (orthonormal.T @ shapes)
    left = np.linalg.norm(new, axis=0)
    new = new[:, left > 1e-3 * np.maximum(length, 1e-300)]
    if room == 0 or new.shape[1] == 0:
        return orthonormal
    new /= np.linalg.norm(new, axis=0)
    room = min(room, MOST_SHAPES)
    slow = (new[1:] * new[:-1]).sum(axis=0) > SLOW
    first = most_different(new[:, slow], min(room // 2, MOST_SLOW), DIFFERENT)
    rest = new[:, ~slow] - first @ (first.T @ new[:, ~slow])
    second = most_different(rest, room - first.shape[1], DIFFERENT)
    return np.concatenate([orthonormal, first, second], axis=1)


def _orthonormal(columns: Array) -> Array:
    """Return orthonormal directions that span the columns."""
    if columns.shape[1] == 0:
        return columns
    length = np.linalg.norm(columns, axis=0)
    directions, strength, _ = np.linalg.svd(columns / length, full_matrices=False)
    return np.asarray(directions[:, strength > 1e-9 * strength[0]])


@dataclass(frozen=True)
class _Draft:
    """What the readings of one series say of its noise.

    Attributes
    ----------
    within, of_mean
        Scatter within pointings, and the variance that it leaves to their means.
    scale
        For every noise of the grid the scatter that it would have, shape (G,).
    chance
        How likely each is by this series alone, shape (G,).
    grid
        Strength over the scatter, and memory, of each drift; shape (G, 2).
    """

    within: float
    of_mean: float
    scale: Array
    chance: Array
    grid: Array
    dof: float
    how: str

    def noise(self, chance: Array, floor: float) -> Noise:
        """Return the noise averaged over the grid.

        Few memories of a slow drift fit into a campaign, so its strength is
        known badly, and a search that took the best fit for the truth would
        find steps in what it underrates. The covariance is averaged over
        strengths and memories instead, each as likely as the recordings make it.
        """
        power = chance * self.scale**2
        drifts = []
        for memory in np.unique(self.grid[:, 1]):
            variance = float((power * self.grid[:, 0] ** 2)[self.grid[:, 1] == memory].sum())
            if variance > FAINT * power.sum():
                drifts.append((float(np.sqrt(variance)), float(memory)))
        least = max(0.05 * floor, 1e-14)
        between = float(np.sqrt(max(float(power.sum()) - self.of_mean, least**2)))
        return Noise(self.within, between, tuple(drifts), self.dof, self.how)


def _draft(
    value: Array,
    columns: Array,
    weight: Array,
    residual: Array,
    part: Series,
    grid: Array,
    floor: float,
) -> _Draft:
    """Weigh every noise of a grid by its restricted likelihood; columns are taken out of it."""
    count = np.bincount(part.pointing)
    within = _within(residual, weight, part, count, floor)
    data = np.concatenate([columns, value[:, None]], axis=1)
    means, variance, _ = by_pointing(data, weight, part, Noise(0.0, 1.0))
    likelihood = _Likelihood(means, np.where(variance >= FAR, np.inf, variance), part.time)
    if part.time is None or likelihood.dof < ENOUGH_FOR_DRIFT:
        grid = grid[:1]
    lack, scale = np.array([likelihood.at(*one) for one in grid]).T
    # No drift is as likely beforehand as all drifts together.
    prior = np.full(len(grid), 1 / max(len(grid) - 1, 1))
    prior[0] = 1.0
    chance = prior * np.exp(-(lack - lack.min()) / 2)
    return _Draft(
        within,
        # The scatter of a pointing's mean holds what is left of the scatter within it.
        within**2 / float(np.mean(count)),
        scale,
        chance / chance.sum(),
        grid,
        float(likelihood.dof),
        "replicates" if count.max() > 1 else "reml",
    )


def _grid(parts: Sequence[Series]) -> Array:
    """Return strengths and memories of drifts that are weighed against each other, (G, 2)."""
    gaps = [np.diff(part.time) for part in parts if part.time is not None]
    near = [gap[(gap > 0) & (gap < APART / 2)] for gap in gaps]
    usual = min((float(np.median(gap)) for gap in near if len(gap)), default=1.0)
    shortest = min(SHORTEST_MEMORY * max(usual, 1e-3), LONGEST_MEMORY / 2)
    drifts = [(r, t) for t in np.geomspace(shortest, LONGEST_MEMORY, MEMORIES) for r in RATIOS]
    return np.array([(0.0, shortest), *drifts])


def _beside(drafts: Sequence[_Draft], parts: Sequence[Series], one: int) -> Array:
    """Return how likely each noise of a series is, its antenna's other axis heard too.

    What shakes one axis often shakes the other alike: as likely as not the
    other axis has the same strength and memory.
    """
    own = drafts[one].chance
    others = [
        draft.chance
        for draft, part in zip(drafts, parts, strict=True)
        if part.antenna == parts[one].antenna
        and part.is_y != parts[one].is_y
        and len(draft.chance) == len(own)
    ]
    if not others or len(own) == 1:
        return own
    prior = np.full(len(own), 1 / (len(own) - 1))
    prior[0] = 1.0
    chance = own * (1 + others[0] / (prior / prior.sum()))
    return np.asarray(chance / chance.sum())


@dataclass(frozen=True)
class _Likelihood:
    """The restricted likelihood of a white part and a drift, the scale profiled out.

    `means` holds the design and, last, the data, shape (n, q + 1); `variance`
    is relative, infinite for outliers.
    """

    means: Array
    variance: Array
    time: Array | None

    @property
    def dof(self) -> int:
        """Return the deviations that tell of the noise."""
        return max(1, int(np.isfinite(self.variance).sum()) - self.means.shape[1] + 1)

    def at(self, ratio: float, time_s: float) -> tuple[float, float]:
        """Return minus twice the log-likelihood and the scale, for a drift `ratio` times it."""
        kept = np.isfinite(self.variance)
        d, white = factor(
            self.means[kept],
            self.variance[kept],
            None if self.time is None else self.time[kept],
            [(ratio, time_s)] if ratio > 0 else [],
        )
        gram = white.T @ white
        triangle = np.linalg.cholesky(gram[:-1, :-1] + 1e-12 * np.eye(len(gram) - 1))
        projected = np.linalg.solve(triangle, gram[:-1, -1])
        misfit = max(float(gram[-1, -1] - projected @ projected), 1e-300)
        logs = float(np.log(d).sum() + 2 * np.log(np.diag(triangle)).sum())
        return logs + self.dof * np.log(misfit), float(np.sqrt(misfit / self.dof))


def _within(residual: Array, weight: Array, part: Series, count: Codes, floor: float) -> float:
    """Return the scatter of readings about their pointing's mean; zero where each stands alone."""
    spare = (count - 1)[count > 1].sum()
    if spare < 3:
        return 0.0
    total = np.maximum(np.bincount(part.pointing, weight), 1e-12)
    mean = np.bincount(part.pointing, weight * residual) / total
    deviation = residual - mean[part.pointing]
    several = count[part.pointing] > 1
    share = np.sqrt(several.sum() / spare)
    scatter = robust.scale(deviation[several & (weight > 0.5)]) * float(share)
    return max(scatter, floor / 2, 1e-12)
