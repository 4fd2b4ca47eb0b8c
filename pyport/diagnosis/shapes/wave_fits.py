"""Fits of waves near a period: the likeliest one, its line, and predictions of unseen readings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.searching.confirming import beside_model
from pyport.diagnosis.shapes.periods import FINER, OVERSAMPLED, near_best
from pyport.diagnosis.shapes.scans import Scan, scan_of, stretches_of, view_of
from pyport.diagnosis.trial import of_equal_prior
from pyport.effects.base import Effect
from pyport.effects.empirical.fields import field
from pyport.effects.empirical.oscillations import OSCILLATION, Stretch, oscillation
from pyport.noise.covariance import Covariance
from pyport.recordings.sky import clock
from pyport.thresholds import FEWEST, MOSTLY, PERIODS_FREE

#: Periods at which the evidence is looked at to find its top, and how far off a wandering one is
#: looked for.
NEAR, WIDE = 11, 0.1
#: Quality factors of a phase that wanders, and the periods in which it is one when it is predicted.
QUALITIES, PERIODS_ONE = (7.0, 20.0), 2.0


def effect_of(
    problem: Problem,
    scan: Scan,
    period_s: float,
    direction_deg: float | None = None,
    periods: float | None = None,
    harmonics: int = 1,
) -> Effect:
    """Return the oscillation of a period, its sine counted from the middle of the recordings.

    Its phase wanders where it has a line: it is free in so many periods, or `PERIODS_FREE`. One of
    several harmonics is no oscillation but a field that repeats.
    """
    time = clock(problem.recordings.at)[problem.stack.row]
    since = float(np.round((time.min() + time.max()) / 2))
    if harmonics > 1:
        measured = np.unique(problem.stack.is_y).astype(int)
        return _repeating(period_s, since, harmonics, measured.tolist())
    reversing = bool((scan.sign < 0).any())
    if direction_deg is None:
        return oscillation(period_s, since, reversing=reversing)
    stretch, count = stretches_of(scan, period_s, periods or PERIODS_FREE)
    begin, end = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(begin, stretch, time)
    np.maximum.at(end, stretch, time)
    enough = np.bincount(stretch, minlength=count) >= (1 if periods else FEWEST)
    found: list[Stretch] = [
        (float(one), float(other)) for one, other in zip(begin[enough], end[enough], strict=True)
    ]
    return oscillation(period_s, since, found, direction_deg=direction_deg, reversing=reversing)


def _repeating(
    period_s: float, since_s: float, harmonics: int, axes: Sequence[int], spread: float = 1.0
) -> Effect:
    """Return what repeats in time in any form in some axes, its heights' spread [rad]."""
    count = 2 * harmonics
    where = "both axes" if len(axes) > 1 else ("xel", "el")[axes[0]]
    return field(
        {"kind": "repeat", "period_s": period_s, "since_s": since_s, "count": harmonics},
        np.repeat(axes, count).tolist(),
        np.tile(range(count), len(axes)).tolist(),
        np.eye(count * len(axes)).tolist(),
        "an error that repeats",
        f"{where}: every {period_s / 60:.4g} min",
        [spread] * (count * len(axes)),
    )


def repeats(effect: Effect) -> bool:
    """Tell whether an effect is what comes back in time in any form."""
    return bool(effect.member.get("bumps", {}).get("kind") == "repeat")


def is_wave(effect: Effect) -> bool:
    """Tell whether an effect is an oscillation, or repeats in any form."""
    return effect.id == OSCILLATION or repeats(effect)


def period_of(effect: Effect) -> float:
    """Return the period of an oscillation, or of what repeats [s]."""
    return float(effect.member.get("bumps", effect.member)["period_s"])


def _with_period(effect: Effect, period_s: float) -> Effect:
    """Return an oscillation, or what repeats, of another period."""
    if not repeats(effect):
        return oscillation(**{**effect.member, "period_s": period_s})
    bumps, axes = effect.member["bumps"], np.unique(effect.member["axes"]).tolist()
    return _repeating(period_s, bumps["since_s"], bumps["count"], axes)


def likeliest_repeat(
    problem: Problem, noise: Covariance, chosen: Sequence[Chosen], effect: Effect
) -> tuple[Effect, float]:
    """Return what repeats with its likeliest period near one, its spread, and its evidence.

    In one axis or in both: the likeliest.
    """
    period = likeliest_period(problem, noise, chosen, effect)[0]
    bumps, measured = effect.member["bumps"], np.unique(effect.member["axes"]).tolist()
    found = []
    for axes in [measured, *([one] for one in measured if len(measured) > 1)]:
        form = period, bumps["since_s"], bumps["count"], axes
        waves = _waves(problem, noise, chosen, _repeating(*form))
        evidence, _, variance = waves.fit(period)
        spread = float(np.sqrt(variance)) / waves.columns(period)[2]
        found.append((_repeating(*form, spread), evidence))
    return max(found, key=lambda one: one[1])


def likeliest_period(
    problem: Problem, noise: Covariance, chosen: Sequence[Chosen], effect: Effect
) -> tuple[float, float, float]:
    """Return the likeliest period [s] near that of an oscillation, its sigma, and its evidence.

    Where a phase holds, nights at equal intervals leave open how many periods went by between
    them: other periods that are as likely are part of the sigma.
    """
    waves = _waves(problem, noise, chosen, effect)
    width, periods = WIDE, [period_of(effect)]
    if not wanders(effect):
        width = periods[0] / (OVERSAMPLED * max(float(np.ptp(waves.scan.time)), 1.0))
    if repeats(effect):
        width /= FINER
    elif not wanders(effect):
        periods += near_best(waves.scan, view_of(problem, waves.scan, noise, chosen))
    grid = np.exp(width * np.linspace(-1, 1, NEAR))
    found = [top(lambda period: waves.fit(period)[0], one * grid) for one in periods]
    period, sigma, evidence = max(found, key=lambda one: one[2])
    chance = np.exp(np.array([one[2] - evidence for one in found]) / 2)
    apart = np.array([one[0] - period for one in found])
    open_ = float(np.average(apart**2, weights=chance))
    return period, float(np.hypot(sigma, np.sqrt(open_))), evidence


def likeliest_direction(
    problem: Problem, noise: Covariance, chosen: Sequence[Chosen], effect: Effect
) -> tuple[float, float, float]:
    """Return the likeliest line [deg] of a wandering oscillation, its sigma, and its evidence."""
    waves, period = _waves(problem, noise, chosen, effect), effect.member["period_s"]
    line, several = effect.member["direction_deg"], waves.scan.lines_deg
    if len(several) == 1:
        return line, 0.0, waves.fit(period)[0]
    near = line + np.ptp(several[:2]) * np.linspace(-1, 1, NEAR)
    direction, sigma, evidence = top(lambda one: waves.along(one).fit(period)[0], near)
    return direction % 180, sigma, evidence


def is_line(problem: Problem, noise: Covariance, others: Sequence[Chosen], effect: Effect) -> bool:
    """Tell whether an oscillation has a period: others explain less than most of it.

    What scatters in more ways than drifts do has power over a range of periods, and waves whose
    phase is free draw it at any of them: at half and at twice the period nearly as well. One
    whose phase holds has a period.
    """
    if not wanders(effect):
        return True
    waves, period = _waves(problem, noise, others, effect), effect.member["period_s"]
    half, own, double = (waves.fit(period * times)[0] for times in (0.5, 1.0, 2.0))
    return max(half, double) <= MOSTLY * own


def predicted(
    problem: Problem, noise: Covariance, others: Sequence[Chosen], effect: Effect
) -> Array:
    """Return what readings of weight predict of a wandering oscillation, drawn toward zero [rad].

    The best linear prediction, shape (m,), as that of departures.
    """
    waves = _waves(problem, noise, others, effect)
    period = effect.member["period_s"]
    _, covariance, variance = waves.fit(period)
    columns, rest, _ = waves.columns(period)
    prior = variance * covariance
    # With V = rest prior rest' + 1 the prediction is prior rest' V^-1 of the data.
    inner = np.eye(len(prior)) + rest.T @ rest @ prior
    return np.asarray(columns @ (prior @ np.linalg.solve(inner, rest.T @ waves.left)))


def scan_again(problem: Problem, effect: Effect) -> Scan:
    """Return the readings as the search met them that found an oscillation."""
    scan = scan_of(problem, reversing="reversing" in effect.member)
    assert scan is not None  # noqa: S101 - it was found in it
    return scan


def wanders(effect: Effect) -> bool:
    """Tell whether the phase of an oscillation is free in every few periods."""
    return "stretches_s" in effect.member


@dataclass(frozen=True)
class _Waves:
    """Waves beside a model and a noise, amplitudes of one size: whose phase holds or wanders.

    `left` are the whitened data without the model's directions `basis`; `mixes` roots of how
    amplitudes may hang together.
    """

    problem: Problem
    scan: Scan
    noise: Covariance
    basis: Array
    left: Array
    free: Effect
    mixes: Sequence[Array]

    def along(self, direction_deg: float) -> _Waves:
        """Return the same along another line."""
        return replace(
            self, free=oscillation(**{**self.free.member, "direction_deg": direction_deg})
        )

    def columns(self, period_s: float) -> tuple[Array, Array, float]:
        """Return waves of unit size (m, k), whitened and without the model (M, k), and their size.

        As one has it whose amplitude is 1 rad.
        """
        near = _with_period(self.free, period_s)
        columns = self.problem.stack.columns(near, self.problem.recordings.at)
        white = self.noise.whiten(columns)
        size = float(np.sqrt(np.sum(white**2) / np.count_nonzero(white.any(axis=0))))
        white = white - self.basis @ (self.basis.T @ white)
        return columns / size, white / size, size

    def fit(self, period_s: float) -> tuple[float, Array, float]:
        """Return the evidence of a period, the covariance of its amplitudes, and its variance."""
        rest = self.columns(period_s)[1]
        products, seen = rest.T @ rest, rest.T @ self.left
        tried = [(*of_equal_prior(one.T @ products @ one, one.T @ seen), one) for one in self.mixes]
        evidence, variance, mix = max(tried, key=lambda one: one[0])
        return evidence, mix @ mix.T, variance


def _waves(problem: Problem, noise: Covariance, chosen: Sequence[Chosen], effect: Effect) -> _Waves:
    scan = scan_again(problem, effect)
    model = noise.whiten(problem.expanded((*problem.base, *chosen)))
    white = noise.whiten(problem.residual[:, None])[:, 0]
    _, basis, left = beside_model(noise, model, white)
    plain = effect, [np.eye(len(effect.coefficients))]
    free, mixes = _wandered(problem, scan, effect) if wanders(effect) else plain
    return _Waves(problem, scan, noise, basis, left, free, mixes)


def _wandered(problem: Problem, scan: Scan, effect: Effect) -> tuple[Effect, list[Array]]:
    """Return an oscillation free in every few periods, and how its amplitudes hang together.

    For some quality factors Q a phase is forgotten, by e, in Q / pi periods: for each of them the
    root of the amplitudes' covariance, sine and cosine of each stretch in turn.
    """
    period = effect.member["period_s"]
    free = effect_of(problem, scan, period, effect.member["direction_deg"], PERIODS_ONE)
    middle = np.mean(free.member["stretches_s"], axis=1)
    apart = np.abs(middle[:, None] - middle) / period
    roots = [np.linalg.cholesky(np.exp(-np.pi * apart / quality)) for quality in QUALITIES]
    return free, [np.asarray(np.kron(one, np.eye(2)), float) for one in roots]


def top(evidence: Callable[[float], float], tried: Array) -> tuple[float, float, float]:
    """Return the top of a parabola through the best of what is tried, its sigma, its evidence."""
    worth = np.array([evidence(float(one)) for one in tried])
    best = int(np.argmax(worth))
    some = slice(max(best - 3, 0), best + 4)
    middle = float(tried[best])
    bend, slope, _ = np.polyfit(tried[some] - middle, worth[some], 2)
    if bend >= 0:
        return middle, float(np.ptp(tried)), float(worth[best])
    highest = np.clip(middle - slope / (2 * bend), tried[some].min(), tried[some].max())
    return float(highest), float(np.sqrt(-1 / bend)), float(worth[best])
