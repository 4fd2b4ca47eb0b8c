"""The telescope as it was: a Kalman filter of everything that moves offsets and is no alarm.

Readings are predicted from all before them. What is left, over its standard deviation, is an
innovation; as long as nothing changes innovations are independent and of one distribution.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, exp, hypot, isnan, log, log1p, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.special import gammaln

from pyport.angles import Array
from pyport.noise.pointings import SAME_PLACE, SAME_S, SAME_TIMELESS
from pyport.watch.detection.baseline import Baseline
from pyport.watch.detection.prepare import Rows

#: A number or an array of them.
Number = Any
#: Readings that the scale of the scatter remembers: a wandering one is followed, a change that is
#: quicker is an alarm.
SCALE_MEMORY = 100.0
#: Deviations that a new night's scatter is known from, where fewer than three nights tell.
NIGHT_DOF = 30.0
#: The least and the largest number, where nights do tell.
NIGHT_DOF_LEAST, NIGHT_DOF_MOST = 2.0, 30.0
#: An innovation as rare as so many sigmas of a normal is an outlier; gross errors scatter by
#: `GROSS` sigmas.
OUTLIER, GROSS = 4.0, 10.0
#: Turns in which a scale and the weight of what it is learnt from settle.
TURNS = 3
#: Share of gross errors that is always reckoned with.
LEAST_GROSS = 0.005
#: Readings that the share of outliers is known from, at most.
SHARE_MEMORY = 1000.0


@dataclass
class Null:
    """The state of the filter of one antenna."""

    #: `mean`, `covariance`: of the states, (D,) and (D, D).
    mean: Array
    covariance: Array
    #: `scale`, `dof`: variance of the innovations of either axis, and from how many it is known,
    #: (2,).
    scale: Array = field(default_factory=lambda: np.ones(2))
    dof: Array = field(default_factory=lambda: np.full(2, 10.0))
    tail: float = 0.1  #: one over the degrees of freedom of the innovations' distribution
    #: `outliers`, `readings`: outliers and readings that the share of outliers is known from.
    outliers: float = 0.5
    readings: float = 50.0
    night_dof: float = NIGHT_DOF  #: from how many deviations a new night's scale is known
    #: Whether scale and share of outliers follow the readings: not while an alarm is being named,
    #: as what changed would pass for scatter.
    learning: bool = True
    #: `clock`, `labels`: of the last row.
    clock: float = np.nan
    labels: dict[str, str] = field(default_factory=dict)
    #: Time, azimuth and elevation of the first row of its pointing.
    pointing: tuple[float, float, float] = (np.nan, np.nan, np.nan)

    @property
    def share(self) -> float:
        """Return the share of gross errors."""
        return max(LEAST_GROSS, self.outliers / self.readings)

    def degrees(self, axis: int) -> float:
        """Return the degrees of freedom of an innovation's predictive distribution."""
        return float(1 / (self.tail + 1 / self.dof[axis]))


@dataclass(frozen=True)
class States:
    """What becomes of the states from row to row: which label resets each, and its memory."""

    of: NDArray[np.str_]
    mean: Array
    covariance: Array
    memory_s: Array
    reset: dict[str, NDArray[np.bool_]]
    drifts: NDArray[np.bool_]

    def __len__(self) -> int:
        """Return D."""
        return len(self.mean)

    def scaled(self, factor: float) -> Array:
        """Return by what covariances change where all that is not the model's is larger, (D, D)."""
        size = np.where(self.of == "model", 1.0, factor)
        return np.asarray(size[:, None] * size)


def states(baseline: Baseline) -> States:
    """Return the states of a baseline."""
    some = baseline.nuisances
    sizes = np.array([len(one.mean) for one in some], int)
    of = np.repeat(np.array([one.of for one in some], np.str_), sizes)
    memory = np.repeat(np.array([one.memory_s for one in some], float), sizes)
    reset = {label: of == label for label in ("session", "source", "pointing")}
    mean = np.concatenate([np.zeros(0), *(one.mean for one in some)])
    covariance = block_diag(np.zeros((0, 0)), *(one.covariance for one in some))
    return States(of, mean, covariance, memory, reset, np.isfinite(memory))


def begin(known: States) -> Null:
    """Return the filter before any reading."""
    return Null(known.mean.copy(), known.covariance.copy())


def advance(null: Null, known: States, rows: Rows, n: int) -> tuple[Array, bool]:
    """Let the states go on to a row.

    Return how much of what it was each state keeps, (D,), and whether the row begins another
    pointing. States added by alarms stand behind the others and stay.
    """
    new = begins(rows, n, null)
    kept = np.ones(len(null.mean))
    size = len(known)
    here = {label: rows.labels[label][n] for label in ("session", "source")}
    changed = {label: one != null.labels.get(label) for label, one in here.items()}
    changed["pointing"] = new
    if new:
        null.pointing = float(rows.clock[n]), float(rows.az[n]), float(rows.el[n])
    for label, moved in changed.items():
        if moved:
            kept[:size][known.reset[label]] = 0.0
    gap = rows.clock[n] - null.clock
    if known.drifts.any():
        decay = np.exp(-np.maximum(0.0 if isnan(gap) else gap, 0.0) / known.memory_s[known.drifts])
        kept[:size][known.drifts] = decay
    if changed["session"]:
        null.dof = np.minimum(null.dof, null.night_dof)
    moved_states = kept < 1
    if moved_states.any():
        null.covariance *= kept[:, None] * kept
        fresh = 1 - kept[:size] ** 2
        # a reset draws the block anew, correlations and all; a drift is a state of its own
        null.covariance[:size, :size] += np.sqrt(fresh[:, None] * fresh) * known.covariance
        null.mean[:size] = kept[:size] * null.mean[:size] + (1 - kept[:size]) * known.mean
    null.clock = float(rows.clock[n])
    null.labels = here
    return kept, new


def begins(rows: Rows, n: int, null: Null) -> bool:
    """Tell whether a row begins another pointing, or is one more reading of the last one."""
    if any(rows.labels[label][n] != null.labels.get(label) for label in rows.labels):
        return True
    clock, az, el = null.pointing
    reach = SAME_PLACE if rows.timed else SAME_TIMELESS
    turn = abs((rows.az[n] - az + pi) % (2 * pi) - pi) * cos(rows.el[n])
    late = rows.timed and abs(rows.clock[n] - clock) > SAME_S
    return bool(late or hypot(turn, rows.el[n] - el) > reach)


class Predictive(NamedTuple):
    """What an innovation is predicted with: its scale, degrees of freedom, gross errors, tail."""

    scale: float
    degrees: float
    share: float
    tail: float

    def log_density(self, square: float) -> float:
        """Return the log-density of an innovation of this squared distance."""
        wide = log_gross(square, self.scale, self.share)
        return float(log_density(square, self.scale, self.degrees, self.share, wide))


def predictive(null: Null, axis: int) -> Predictive:
    """Return what the next innovation of an axis is predicted with."""
    return Predictive(float(null.scale[axis]), null.degrees(axis), null.share, null.tail)


def log_usual(square: Number, scale: Number, degrees: Number) -> Number:
    """Return the log-density of Student's t at squared distances, `scale` its squared width."""
    half = (degrees + 1) / 2
    constant = gammaln(half) - gammaln(degrees / 2) - 0.5 * np.log(np.pi * degrees * scale)
    return constant - half * np.log1p(square / scale / degrees)


def log_gross(square: float, scale: float, share: float) -> float:
    """Return the log-density of a gross error, its share included."""
    variance = GROSS**2 * scale
    return log(share) - 0.5 * (log(2 * pi * variance) + square / variance)


def log_density(
    square: Number, scale: Number, degrees: Number, share: float, wide: float
) -> Number:
    """Return the log-density of innovations: Student's t and a share of gross errors.

    `wide` is that of the gross errors.
    """
    return np.logaddexp(log1p(-share) + log_usual(square, scale, degrees), wide)


def learnt(scale: Number, dof: Number, square: float, share: float, tail: float) -> Number:
    """Return the scale that was known from `dof` deviations after one more, of weight `share`.

    What is far out in a heavy tail says less of the scale; how far it is, the new scale says.
    """
    new = scale
    for _ in range(TURNS):
        weight = (1 + tail) / (1 + tail * square / new)
        new = (dof * scale + share * weight * square) / (dof + share)
    return new


def outlying(square: float, degrees: float) -> bool:
    """Tell whether an innovation's squared distance is an outlier's.

    Student's t is brought to a normal by Wallace 1959, Annals of Mathematical Statistics 30, 1124.
    """
    shrunk = (8 * degrees + 1) / (8 * degrees + 3)
    return bool(shrunk**2 * degrees * log1p(square / degrees) > OUTLIER**2)


def weight(square: float, scale: float, degrees: float, share: float) -> tuple[float, float]:
    """Return the weight of an innovation, and the probability that it is no gross error."""
    usual = log1p(-share) + float(log_usual(square, scale, degrees))
    odds = log_gross(square, scale, share) - usual
    sound = 1 / (1 + exp(min(odds, 700.0)))
    return sound * (degrees + 1) / (degrees + square / scale), sound


@dataclass(frozen=True)
class Innovation:
    """A reading against its prediction.

    `value` is over the `sigma` [rad] that was predicted; `gain` (D,) is what the states move by
    for an innovation of one radian.
    """

    axis: int
    value: float
    sigma: float
    gain: Array


def take(
    null: Null, axis: int, reading: float, column: Array, variance: float, held: float | None = None
) -> Innovation:
    """Take in a reading: predict it, compare, update states and scale.

    `held` is the robust weight of a reading whose weight is known.
    """
    spread = null.covariance @ column
    total = float(column @ spread) + variance
    sigma = sqrt(total)
    value = (reading - float(column @ null.mean)) / sigma
    scale, degrees = float(null.scale[axis]), null.degrees(axis)
    found, sound = weight(value * value, scale, degrees, null.share)
    if held is not None:
        found = sound = held
    noisy = variance / max(found, 1e-6) * scale
    gain = spread / (float(column @ spread) + noisy)
    null.mean = null.mean + gain * (value * sigma)
    left = null.covariance - np.outer(gain, spread)
    null.covariance = (left + left.T) / 2
    if null.learning:
        _learn(null, axis, value, sound, variance / total)
    return Innovation(axis, value, sigma, gain)


def _learn(null: Null, axis: int, value: float, sound: float, certain: float) -> None:
    """Let an innovation that is sound with a probability move scale and outliers.

    `certain` is the share of its variance that is scatter: what is mostly the states' doubt says
    little of it.
    """
    share, dof = sound * certain, float(null.dof[axis])
    outlier = outlying(value * value / float(null.scale[axis]), null.degrees(axis))
    null.scale[axis] = learnt(float(null.scale[axis]), dof, value * value, share, null.tail)
    null.dof[axis] = min(dof + share, SCALE_MEMORY)
    null.outliers += float(outlier) * certain
    null.readings += certain
    if null.readings > SHARE_MEMORY:
        null.outliers *= SHARE_MEMORY / null.readings
        null.readings = SHARE_MEMORY
