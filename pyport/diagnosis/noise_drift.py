"""Drift: how strong and how long, as far as one antenna's recordings tell."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.noise import (
    APART,
    ENOUGH_FOR_DRIFT,
    FAR,
    Noise,
    Series,
    by_pointing,
    factor,
)
from pyport.fitting import robust
from pyport.fitting.stacking import Codes

#: Twice the log-likelihood that a noise may lack before it is out of the question: its chance is
#: below 1e-13.
BEYOND = 60.0
#: Strengths of a drift, over the scatter of pointings, that are weighed against each other.
RATIOS = (0.15, 0.25, 0.4, 0.6, 0.9, 1.4, 2.5)
#: So many memories are, from this many steps between pointings on.
MEMORIES, SHORTEST_MEMORY = 7, 2.0
#: What has less of the variance than this is left out.
FAINT = 1e-4
#: A drift that remembers longer than this is no noise: it is an effect of time. [s]
LONGEST_MEMORY = 86400.0


@dataclass(frozen=True)
class Draft:
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


def draft(
    value: Array,
    columns: Array,
    weight: Array,
    residual: Array,
    part: Series,
    grid: Array,
    floor: float,
) -> Draft:
    """Weigh every noise of a grid by its restricted likelihood; columns are taken out of it."""
    count = np.bincount(part.pointing)
    within = _within(residual, weight, part, count, floor)
    data = np.concatenate([columns, value[:, None]], axis=1)
    means, variance, _ = by_pointing(data, weight, part, Noise(0.0, 1.0))
    likelihood = _Likelihood.of(means, np.where(variance >= FAR, np.inf, variance), part.time)
    if part.time is None or likelihood.dof < ENOUGH_FOR_DRIFT:
        grid = grid[:1]
    lack, scale = _weighed(likelihood, grid)
    # No drift is as likely beforehand as all drifts together.
    prior = np.full(len(grid), 1 / max(len(grid) - 1, 1))
    prior[0] = 1.0
    chance = prior * np.exp(-(lack - lack.min()) / 2)
    return Draft(
        within,
        # The scatter of a pointing's mean holds what is left of the scatter within it.
        within**2 / float(np.mean(count)),
        scale,
        chance / chance.sum(),
        grid,
        float(likelihood.dof),
        "replicates" if count.max() > 1 else "reml",
    )


def _weighed(likelihood: _Likelihood, grid: Array) -> tuple[Array, Array]:
    """Return the lack of likelihood of every noise of a grid and its scatter, shape (G,) each.

    Memories are gone through upward and downward from the middle one, and for
    each the strengths from where the last one's likeliest was; what is out of
    the question and further off than the one before is not gone beyond: the
    lack of all that lies there is infinite.
    """
    lack, scale = np.full(len(grid), np.inf), np.ones(len(grid))
    lack[0], scale[0] = likelihood.at(*grid[0])
    memories = np.unique(grid[1:, 1])
    own = [1 + np.flatnonzero(grid[1:, 1] == memory) for memory in memories]

    def along(cells: Codes, start: int) -> int:
        """Try the strengths of one memory from one of them on; return the likeliest."""
        lack[cells[start]], scale[cells[start]] = likelihood.at(*grid[cells[start]])
        for way in (cells[start:], cells[start::-1]):
            for last, one in itertools.pairwise(way):
                lack[one], scale[one] = likelihood.at(*grid[one])
                if lack[one] > max(lack[last], lack.min() + BEYOND):
                    break
        return int(np.argmin(lack[cells]))

    if len(own) == 0:
        return lack, scale
    middle = len(own) // 2
    first = along(own[middle], len(RATIOS) // 2)
    for way in (range(middle, len(own)), range(middle, -1, -1)):
        start = first
        for last, one in itertools.pairwise(way):
            start = along(own[one], start)
            if lack[own[one]].min() > max(lack[own[last]].min(), lack.min() + BEYOND):
                break
    return lack, scale


def grid_of(parts: Sequence[Series]) -> Array:
    """Return strengths and memories of drifts that are weighed against each other, (G, 2)."""
    gaps = [np.diff(part.time) for part in parts if part.time is not None]
    near = [gap[(gap > 0) & (gap < APART / 2)] for gap in gaps]
    usual = min((float(np.median(gap)) for gap in near if len(gap)), default=1.0)
    shortest = min(SHORTEST_MEMORY * max(usual, 1e-3), LONGEST_MEMORY / 2)
    drifts = [(r, t) for t in np.geomspace(shortest, LONGEST_MEMORY, MEMORIES) for r in RATIOS]
    return np.array([(0.0, shortest), *drifts])


def beside(drafts: Sequence[Draft], parts: Sequence[Series], one: int) -> Array:
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
    is relative.
    """

    means: Array
    variance: Array
    time: Array | None

    @classmethod
    def of(cls, means: Array, variance: Array, time: Array | None) -> _Likelihood:
        """Return the likelihood of pointings' means; those of infinite variance are outliers."""
        kept = np.isfinite(variance)
        return cls(
            np.ascontiguousarray(means[kept]), variance[kept], None if time is None else time[kept]
        )

    @property
    def dof(self) -> int:
        """Return the deviations that tell of the noise."""
        return max(1, len(self.variance) - self.means.shape[1] + 1)

    def at(self, ratio: float, time_s: float) -> tuple[float, float]:
        """Return minus twice the log-likelihood and the scale, for a drift `ratio` times it."""
        drifts = [(ratio, time_s)] if ratio > 0 else []
        d, white = factor(self.means, self.variance, self.time, drifts)
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
