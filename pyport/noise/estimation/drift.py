"""Drift: how strong and how long, as far as one antenna's recordings tell.

Every drift is a sum of Ornstein-Uhlenbeck processes: one of them, with a memory from minutes to
three times the whole span (a random walk), or equally strong ones of all memories (1/f noise).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array, Codes
from pyport.noise.estimation.likelihood import Departing, Likelihood, likelihood_of
from pyport.noise.series import Noise, Series
from pyport.thresholds import ENOUGH

#: Twice the log-likelihood that a noise may lack before it is out of the question: its chance is
#: below 1e-5.
BEYOND = 24.0
#: Strengths of a drift over the span of the recordings, in units of the scatter of pointings.
RATIOS = (0.15, 0.25, 0.4, 0.6, 0.9, 1.4, 2.5, 4.5, 8.0, 14.0)
#: The shortest memory is so many steps between pointings, the longest so many times their span:
#: from there on a drift is a random walk, and a longer memory the same.
SHORTEST_MEMORY, LONGEST_MEMORY = 2.0, 3.0
#: Memories differ by about this factor: one between two of them is drawn by both together.
MEMORY_STEP = 3.0
#: What has less of the variance than this is left out.
FAINT = 1e-4
#: Repeats scatter by no less than this, though they are equal to the last digit: no file has a
#: digit of 2e-7 arcsec, and a reading without scatter weighs infinitely much. [rad]
TINY = 1e-12


@dataclass(frozen=True)
class Grid:
    """Drifts that are weighed against each other; the first one is none.

    Attributes
    ----------
    ratio
        Amplitude of each over the white scatter, shape (G,).
    shape
        Which of the `shapes` each has, shape (G,).
    shapes
        Amplitudes and memories [s] of the processes that a drift consists of.
    """

    ratio: Array
    shape: Codes
    shapes: tuple[tuple[tuple[float, float], ...], ...]

    def __len__(self) -> int:
        """Return G."""
        return len(self.ratio)

    def drifts(self, cell: int) -> list[tuple[float, float]]:
        """Return amplitude and memory [s] of the processes of one drift, for unit scatter."""
        ratio = float(self.ratio[cell])
        if ratio == 0:
            return []
        return [(ratio * amplitude, memory) for amplitude, memory in self.shapes[self.shape[cell]]]


def grid_of(parts: Sequence[Series]) -> Grid:
    """Return the drifts that the series of one case could show."""
    times = [part.time for part in parts if part.time is not None and len(part.time) > 1]
    gaps = [gap[gap > 0] for gap in map(np.diff, times)]
    usual = min((float(np.median(gap)) for gap in gaps if len(gap)), default=1.0)
    span = max((float(np.ptp(time)) for time in times), default=1.0)
    shortest = SHORTEST_MEMORY * max(usual, 1e-3)
    longest = max(LONGEST_MEMORY * span, 2 * shortest)
    count = 1 + int(np.ceil(np.log(longest / shortest) / np.log(MEMORY_STEP)))
    memories = [float(one) for one in np.geomspace(shortest, longest, count)]
    # What outlasts the recordings shows by what it changes within them.
    strength = [max(1.0, float(np.sqrt(one / max(span, shortest)))) for one in memories]
    single = [((amplitude, memory),) for amplitude, memory in zip(strength, memories, strict=True)]
    flicker = tuple((float(1 / np.sqrt(count)), memory) for memory in memories)
    shapes = (*single, flicker)
    return Grid(
        np.array([0.0, *(ratio for _ in shapes for ratio in RATIOS)]),
        np.array([0, *(n for n in range(len(shapes)) for _ in RATIOS)]),
        shapes,
    )


@dataclass(frozen=True)
class Draft:
    """What the readings of one series say of its noise.

    Attributes
    ----------
    within, readings
        Scatter within pointings, as their readings have it, and how many each has on average.
    scale
        For every noise of the grid the scatter that it would have, shape (G,).
    chance
        How likely each is by this series alone, shape (G,).
    grid
        The drifts.
    """

    within: float
    readings: float
    scale: Array
    chance: Array
    grid: Grid
    dof: float
    how: str

    @property
    def best(self) -> int:
        """Return the likeliest drift that is one."""
        return 1 + int(np.argmax(self.chance[1:]))

    def noise(self, chance: Array, floor: float) -> Noise:
        """Return the noise averaged over the grid.

        Few memories of a slow drift fit into a campaign, so its strength is known badly, and a
        search that took the best fit for the truth would find steps in what it underrates. The
        covariance is averaged over strengths and memories instead, each as likely as the
        recordings make it.
        """
        power = chance * self.scale**2
        variance: dict[float, float] = {}
        for cell in np.flatnonzero(power > 0):
            for amplitude, memory in self.grid.drifts(int(cell)):
                variance[memory] = variance.get(memory, 0.0) + float(power[cell]) * amplitude**2
        least, variance_of_mean = max(0.05 * floor, 1e-14), float(power.sum())
        # The scatter of a pointing's mean holds what is left of the scatter within it, and three
        # repeats know that less well than all pointings know the whole.
        most = max(float(np.sqrt(variance_of_mean * self.readings)), floor / 2, TINY)
        within = min(self.within, most)
        between = float(np.sqrt(max(variance_of_mean - within**2 / self.readings, least**2)))
        drifts = tuple(
            (float(np.sqrt(one)), memory)
            for memory, one in sorted(variance.items())
            if one > FAINT * power.sum()
        )
        return Noise(within, between, drifts, self.dof, self.how)


def within_reach(grid: Grid) -> float:
    """Return what a noise may lack and be the likeliest, whatever the other axis says of it.

    The other axis raises the chance of a drift by a factor of no more than that: see `beside`.
    """
    prior = _prior(len(grid))
    return 2 * float(np.log1p((prior.sum() / prior).max()))


def likeliest(chance: Array) -> Array:
    """Return chances (G,) that are all with the likeliest noise, whatever the prior."""
    one = np.zeros(len(chance))
    one[np.argmax(chance / _prior(len(chance)))] = 1.0
    return one


def draft(
    value: Array,
    columns: Array,
    departing: Departing,
    weight: Array,
    precision: Array,
    residual: Array,
    part: Series,
    grid: Grid,
    floor: float,
    start: int | None = None,
    beyond: float = BEYOND,
) -> Draft:
    """Weigh every noise of a grid by its restricted likelihood.

    Parameters
    ----------
    value, columns
        The data of the series' readings (n,), and columns (n, p) that are taken out of them.
    departing
        What departures do to the series.
    weight, precision, residual
        Robust weights, relative precision and residuals of the readings, shape (n,).
    part, grid, floor
        The series, the drifts, and the scatter that rounding makes [rad].
    start
        The drift that the search starts from; None for one in the middle.
    beyond
        Twice the log-likelihood that a noise may lack before it is out of the question.
    """
    count = np.bincount(part.pointing)
    within = _within(residual, weight, part, count, floor)
    likelihood = likelihood_of(value, columns, departing, weight, precision, part)
    if part.time is None or likelihood.dof < ENOUGH:
        lack, scale = np.full(len(grid), np.inf), np.ones(len(grid))
        lack[0], scale[0] = likelihood.at([])
    else:
        lack, scale = _weighed(likelihood, grid, start, beyond)
    # No drift is as likely beforehand as all drifts together.
    chance = _prior(len(grid)) * np.exp(-(lack - lack.min()) / 2)
    return Draft(
        within,
        float(np.mean(count)),
        scale,
        chance / chance.sum(),
        grid,
        float(likelihood.dof),
        "replicates" if count.max() > 1 else "reml",
    )


def _prior(size: int) -> Array:
    prior = np.full(size, 1 / max(size - 1, 1))
    prior[0] = 1.0
    return prior


def _weighed(
    likelihood: Likelihood, grid: Grid, start: int | None, beyond: float
) -> tuple[Array, Array]:
    """Return the lack of likelihood of every noise of a grid and its scatter, shape (G,) each.

    Memories are gone through upward and downward from where the search starts, and for
    each the strengths from where the last one's likeliest was; what is out of
    the question and further off than the one before is not gone beyond: the
    lack of all that lies there is infinite.
    """
    lack, scale = np.full(len(grid), np.inf), np.ones(len(grid))
    lack[0], scale[0] = likelihood.at([])
    shapes = len(grid.shapes)
    cells = [1 + n * len(RATIOS) + np.arange(len(RATIOS)) for n in range(shapes)]

    def along(own: Codes, start: int) -> int:
        """Try the strengths of one shape from one of them on; return the likeliest."""
        lack[own[start]], scale[own[start]] = likelihood.at(grid.drifts(int(own[start])))
        for way in (own[start:], own[start::-1]):
            for last, one in itertools.pairwise(way):
                lack[one], scale[one] = likelihood.at(grid.drifts(int(one)))
                if lack[one] > max(lack[last], lack.min() + beyond):
                    break
        return int(np.argmin(lack[own]))

    middle, strength = (shapes - 1) // 2, len(RATIOS) // 2
    if start is not None:
        middle, strength = min((start - 1) // len(RATIOS), shapes - 2), (start - 1) % len(RATIOS)
    first = along(cells[middle], strength)
    for way in (range(middle, shapes - 1), range(middle, -1, -1)):
        start = first
        for last, one in itertools.pairwise(way):
            start = along(cells[one], start)
            if lack[cells[one]].min() > max(lack[cells[last]].min(), lack.min() + beyond):
                break
    along(cells[-1], first)
    return lack, scale


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
    prior = _prior(len(own))
    chance = own * (1 + others[0] / (prior / prior.sum()))
    return np.asarray(chance / chance.sum())


def _within(residual: Array, weight: Array, part: Series, count: Codes, floor: float) -> float:
    """Return the scatter of readings about their pointing's mean; zero where each stands alone.

    The rms of readings that are no outliers: some repeats that were rounded before a model was
    added are copies of one another, and a robust scatter would be that of the copies.
    """
    spare = (count - 1)[count > 1].sum()
    if spare < 3:
        return 0.0
    total = np.maximum(np.bincount(part.pointing, weight), 1e-12)
    mean = np.bincount(part.pointing, weight * residual) / total
    deviation = residual - mean[part.pointing]
    several = count[part.pointing] > 1
    usual = deviation[several & (weight > 0.5)]
    rms = float(np.sqrt(np.mean(usual**2))) if len(usual) else 0.0
    return max(float(np.sqrt(several.sum() / spare)) * rms, floor / 2, TINY)
