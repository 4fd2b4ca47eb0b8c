"""Periodic errors of drives: waves in an angle of the mount too short to be tried one by one.

Their period is looked for as that of an oscillation whose phase holds, with an angle for the time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import DEG, Array
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.searching.confirming import beside_model
from pyport.diagnosis.shapes.oscillations import of_period
from pyport.diagnosis.shapes.periods import OVERSAMPLED, highest
from pyport.diagnosis.shapes.scans import Peak, Scan, View, view_of
from pyport.diagnosis.shapes.wave_fits import NEAR, top
from pyport.diagnosis.trial import of_equal_prior
from pyport.effects import catalogue
from pyport.effects.base import Effect
from pyport.effects.telescope.encoders import HARMONICS, SHORTEST_DEG
from pyport.noise.covariance import Covariance
from pyport.runs.stages import stage
from pyport.thresholds import ALIKE, CONVINCING, ENOUGH_SQUARES, PERIODS_ALONE

#: Angles are counted in bins of this share of the shortest period: a wave loses 0.6 % there.
BINS = 16
#: Of each family whose waves are looked for: whether they follow the second angle, and whether
#: they act along it.
FAMILIES = {
    "azimuth_harmonics": (False, False),
    "elevation_harmonics": (False, True),
    "elevation_encoder_harmonics": (True, True),
}


def is_short(effect: Effect) -> bool:
    """Tell whether an effect is a wave that comes oftener than the harmonics tried one by one."""
    return effect.on_altaz in FAMILIES and effect.member["k"] > HARMONICS[-1]


@dataclass(frozen=True)
class Way:
    """A family, and the readings as a search for its periods [deg] meets them.

    `step` is that of the grid [deg] that the angles lie on, 0 where they lie on none.
    """

    effect: Effect
    scan: Scan
    step: float

    def member(self, turns: float) -> Effect:
        """Return the wave that comes so often in a turn."""
        assert self.effect.make is not None  # noqa: S101 - it is a family
        return self.effect.make(k=turns)


def angles_of(problem: Problem, effect: Effect) -> Array:
    """Return the angle that a wave follows, of each reading [deg], shape (m,)."""
    at = problem.recordings.at.axes
    second, _ = FAMILIES[effect.on_altaz]
    return (at.el if second else at.az)[problem.stack.row] / DEG


def ways_of(problem: Problem) -> Iterator[Way]:
    """Yield the families whose short waves could be seen."""
    if problem.blocks.antennas > 1:
        return
    families = {one.id for one in problem.named}
    at, row = problem.recordings.at, problem.stack.row
    for effect in catalogue(at.mount).values():
        if effect.id not in families or effect.on_altaz not in FAMILIES:
            continue
        _, along = FAMILIES[effect.on_altaz]
        side = np.broadcast_to(at.side, len(at))[row]
        sign = side * (
            problem.stack.is_y if along else ~problem.stack.is_y * np.cos(at.axes.el[row])
        )
        angle = angles_of(problem, effect)
        seen = abs(sign) > 0
        if np.count_nonzero(seen) < ENOUGH_SQUARES:
            continue
        begin, length = float(angle.min()), float(np.ptp(angle[seen]))
        step = step_of(angle[seen], sign[seen] ** 2)
        shortest = max(SHORTEST_DEG, 2 * step)
        longest = min(360 / (HARMONICS[-1] + 0.5), length / PERIODS_ALONE)
        if longest < 2 * shortest:
            continue
        whole = np.zeros(len(row), np.intp)
        scan = Scan(
            angle - begin,
            whole,
            problem.stack.is_y.astype(np.intp),
            sign,
            np.zeros(1),
            np.array([length]),
            shortest,
            longest,
        )
        yield Way(effect, scan, step)


def step_of(angle: Array, weight: Array) -> float:
    """Return the step [deg] of the grid that angles (n,) lie on; 0 where they lie on none.

    Waves whose frequencies differ by one over the step are alike on it.
    """
    frequency, squares = _waves(angle - angle.min(), weight, SHORTEST_DEG / 2)
    alike = squares > ALIKE * float(weight.sum()) ** 2
    beyond = int(np.argmin(alike))
    again = np.flatnonzero(alike[beyond:])
    if alike.all() or not len(again):
        return 0.0
    start = beyond + int(again[0])
    end = start + int(np.argmin([*alike[start:], False]))
    about = 1 / float(frequency[start + np.argmax(squares[start:end])])
    # Frequencies are known to an eighth of a turn over all angles: no step is miscounted.
    counted = np.round((angle - angle.min()) / about)
    return float(np.polyfit(counted, angle, 1)[0])


def in_rings(way: Way, turns: float) -> float:
    """Return the share of a wave's power that is the same at all its angles, as in rings."""
    weight = way.scan.sign**2
    wave = weight @ np.exp(1j * DEG * turns * way.scan.time)
    return float(abs(wave) ** 2 / weight.sum() ** 2)


def _waves(angle: Array, pull: Array, shortest: float) -> tuple[Array, Array]:
    """Return frequencies [1/deg] down to a shortest period, and squares of a pull times a wave."""
    width = shortest / BINS
    bins = np.round(angle / width).astype(np.intp)
    size = 1 << int(np.ceil(np.log2(OVERSAMPLED * (int(bins.max()) + 1))))
    sums = np.fft.rfft(np.bincount(bins, pull, size))
    frequency = np.fft.rfftfreq(size, width)
    there = frequency <= 1 / shortest
    return np.asarray(frequency[there], float), np.asarray(np.abs(sums[there]) ** 2, float)


def _peak(scan: Scan, view: View) -> Peak:
    """Return the best period [deg] of a wave, longer ones included."""
    frequency, squares = _waves(scan.time, view.pull, scan.shortest)
    frequency, squares = frequency[1:], squares[1:]
    information = view.at(1 / frequency).sum(axis=0)
    gain = squares / np.maximum(information, 1e-9 * information.max())
    return highest(scan, frequency, gain, 2)


@stage("looking for periods")
def proposed(problem: Problem, noise: Covariance, chosen: Sequence[Chosen]) -> Chosen | None:
    """Return the short wave of a drive that is worth a confirmation, if any.

    Its columns are for `Problem.with_member` to add.
    """
    ways = list(ways_of(problem))
    peaks = [_peak(way.scan, view_of(problem, way.scan, noise, chosen)) for way in ways]
    found = [
        (peak.worth, peak, way)
        for peak, way in zip(peaks, ways, strict=True)
        if peak.period <= way.scan.longest
    ]
    if not found:
        return None
    worth, peak, way = max(found, key=lambda one: one[0])
    if worth - 2 * float(np.log(len(ways))) <= CONVINCING:
        return None
    effect = _refined(problem, noise, chosen, way, peak)[0]
    return of_period(problem, effect, peak.choices * len(ways))


def again(problem: Problem, noise: Covariance, others: Sequence[Chosen], one: Effect) -> Effect:
    """Return a wave of the same family with the period that readings of weight prefer."""
    way = way_of(problem, one)
    peak = _peak(way.scan, view_of(problem, way.scan, noise, others))
    if peak.period > way.scan.longest:
        return one
    return _refined(problem, noise, others, way, peak)[0]


def sigma_of(problem: Problem, noise: Covariance, others: Sequence[Chosen], one: Effect) -> float:
    """Return the error of how often a wave comes in a turn."""
    near = Peak(360 / float(one.member["k"]), 0.0, 1.0)
    return _refined(problem, noise, others, way_of(problem, one), near)[1]


def way_of(problem: Problem, one: Effect) -> Way:
    """Return the family of a wave that was found, with the readings."""
    return next(each for each in ways_of(problem) if each.effect.id == one.id)


def _refined(
    problem: Problem, noise: Covariance, chosen: Sequence[Chosen], way: Way, peak: Peak
) -> tuple[Effect, float]:
    """Return the likeliest wave near a peak, and the error of how often it comes in a turn.

    What sits on the axis comes a whole number of times: such a number stands unless another is
    better by far.
    """
    fit, turns = _beside(problem, noise, chosen, way), 360 / peak.period
    width = 360 / (OVERSAMPLED * float(way.scan.length[0]))
    best, sigma, worth = top(lambda k: fit.fit(k)[0], turns + width * np.linspace(-1, 1, NEAR))
    whole = round(best)
    if fit.fit(whole)[0] > worth - CONVINCING:
        return way.member(whole), sigma
    return way.member(best), sigma


@dataclass(frozen=True)
class _WavesBeside:
    """Waves of a family beside a model and a noise: its directions, and the data without them."""

    problem: Problem
    noise: Covariance
    way: Way
    basis: Array
    left: Array

    def fit(self, turns: float) -> tuple[float, float]:
        """Return the evidence of a wave that comes so often in a turn, and its best variance."""
        columns = self.problem.stack.columns(self.way.member(turns), self.problem.recordings.at)
        white = self.noise.whiten(columns)
        rest = white - self.basis @ (self.basis.T @ white)
        return of_equal_prior(rest.T @ rest, rest.T @ self.left)


def _beside(
    problem: Problem, noise: Covariance, chosen: Sequence[Chosen], way: Way
) -> _WavesBeside:
    model = problem.expanded((*problem.base, *chosen))
    white = noise.whiten(np.concatenate([model, problem.residual[:, None]], axis=1))
    _, basis, left = beside_model(noise, white[:, :-1], white[:, -1])
    return _WavesBeside(problem, noise, way, basis, left)
