"""The choice for prediction: a model and waves, shrunk as far as the evidence says.

Nothing is picked. All waves are there, the model's own terms are free, and how high and
how long the waves are in each axis, and how large the noise is, maximises the likelihood
of the data with all coefficients integrated out. Where recordings have nothing
but the model in them the waves' heights come out next to zero.

A misfit that has no name can still be predicted if it is smooth. It is drawn as a sum
of waves whose heights are shrunk the more the quicker they are: a normal prior whose
variance falls with frequency as a bell curve's transform does makes the sum a smooth
random curve of a certain length (Solin & Sarkka 2020, Statistics and Computing 30, 419).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array
from pyport.effects.base import Circumstances
from pyport.least_squares import robust
from pyport.runs.workers import one_thread
from pyport.thresholds import FIRST_REACH

#: Waves in elevation stand between these: a little beyond what a telescope can see. [rad]
LOW, HIGH = -10 * DEG, 100 * DEG
#: So many waves: in elevation alone, in azimuth alone, and of each in products over the sky.
UP, AROUND, SKY_UP, SKY_AROUND = 16, 8, 8, 5


@dataclass(frozen=True)
class Family:
    """Waves that share a height and a length."""

    name: str  #: what they follow
    place: slice  #: where their columns stand among all waves
    frequency: Array  #: how quick each is in each direction, shape (K, L) [1/rad]
    #: The usual length of what is left of pointing in each direction, shape (L,) [rad].
    length: tuple[float, ...]

    def spectrum(self, log_length: Array) -> tuple[Array, Array]:
        """Return log-variances (K,) that add up to one, and their slopes by log-length (K, L)."""
        steep = (np.exp(log_length) * self.frequency) ** 2
        log = -steep.sum(axis=1) / 2
        log = log - np.logaddexp.reduce(log)
        return log, np.exp(log) @ steep - steep


def _families() -> tuple[Family, ...]:
    up: Array = np.pi * np.arange(1.0, UP + 1) / (HIGH - LOW)
    around: Array = np.repeat(np.arange(1.0, AROUND + 1), 2)
    both = np.meshgrid(around[: 2 * SKY_AROUND], up[:SKY_UP], indexing="ij")
    first, second = len(up), len(up) + len(around)
    last = second + both[0].size
    return (
        Family("elevation", slice(0, first), up[:, None], (12 * DEG,)),
        Family("azimuth", slice(first, second), around[:, None], (40 * DEG,)),
        Family(
            "the sky",
            slice(second, last),
            np.stack([one.ravel() for one in both], axis=1),
            (40 * DEG, 30 * DEG),
        ),
    )


FAMILIES = _families()
COUNT = FAMILIES[-1].place.stop


def columns(at: Circumstances) -> Array:
    """Return all waves at n pointings, shape (n, COUNT)."""
    up = np.cos(np.pi * np.arange(1, UP + 1) / (HIGH - LOW) * (at.el[:, None] - LOW))
    turns = np.arange(1, AROUND + 1) * at.az[:, None]
    around = np.stack([np.cos(turns), np.sin(turns)], axis=2).reshape(len(at), -1)
    sky = around[:, : 2 * SKY_AROUND, None] * up[:, None, :SKY_UP]
    # A wave has a mean square of one half, a product of two one of a quarter.
    return np.concatenate(
        [up * np.sqrt(2), around * np.sqrt(2), 2 * sky.reshape(len(at), -1)], axis=1
    )


#: Heights and lengths are known beforehand to so many e-foldings; heights are half the scatter.
HEIGHT_SPREAD, LENGTH_SPREAD = 2.0, 0.5
HALF = np.log(0.5)
#: Bounds: of heights over the scatter, of lengths over the usual ones, of noise over the scatter.
_HEIGHT, _LENGTH, _NOISE = np.log([1e-3, 30.0]), np.log([0.25, 4.0]), np.log([1e-2, 3.0])
#: So many steps at most, and so little gain in log-evidence, as a share of it, ends them.
_TURNS, _SETTLED = 60, 1e-5


@dataclass(frozen=True)
class Known:
    """Rows of measured offsets as the fit takes them."""

    model: Array  #: the columns of the model's terms, shape (m, p)
    waves: Array  #: all waves at each row, shape (m, COUNT)
    is_y: NDArray[np.bool_]  #: true for an elevation offset, shape (m,)
    value: Array  #: the offsets, shape (m,)

    def take(self, rows: NDArray[np.bool_]) -> Known:
        """Return some of the rows."""
        return Known(self.model[rows], self.waves[rows], self.is_y[rows], self.value[rows])

    def columns(self) -> Array:
        """Return the model's columns, and the waves of each axis, shape (m, p + 2 COUNT)."""
        y = self.is_y[:, None]
        return np.concatenate([self.model, self.waves * ~y, self.waves * y], axis=1)


@dataclass(frozen=True)
class Shrunk:
    """A fitted model with waves."""

    #: `values`, `covariance`: of the model's terms, then of the waves in cross-elevation and in
    #: elevation.
    values: Array
    covariance: Array
    freed: float  #: how many free coefficients the waves amount to
    #: The scatter that is left in each axis, in the units of the data.
    noise: dict[bool, float]
    logs: Array  #: what the evidence chose: a like fit may start there

    def predict(self, at: Known) -> Array:
        """Return what is predicted at some rows, shape (m,)."""
        return np.asarray(at.columns() @ self.values)


@one_thread
def fit(known: Known, start: Array | None = None) -> Shrunk:
    """Fit a model and waves; `start` are the `logs` of a like fit to go on from.

    Outliers lose their weight: first those from the model alone, then, once the
    waves are there, those from what all other readings predict.
    """
    axes = tuple(bool(one) for one in np.unique(known.is_y))
    weight, left = np.ones(len(known.value)), np.zeros(len(known.value))
    for axis in axes:
        rows = known.is_y == axis
        own = known.model[rows][:, np.any(known.model[rows] != 0, axis=0)]
        floor = robust.rounding(known.value[rows])
        weight[rows], left[rows], _ = robust.weights(own, known.value[rows], FIRST_REACH, floor)
    size = max(float(np.sqrt(np.average(left**2, weights=weight + 1e-9))), 1e-30)
    first = _best(known, weight, size, start)
    if weight.min() == 1:
        return first
    again = robust.flat_weight(_surprise(known, first, weight), 1.0, FIRST_REACH)
    return _best(known, again, size, first.logs)


def _surprise(known: Known, found: Shrunk, weight: Array) -> Array:
    """Return how many sigmas each reading is off what all the others predict, shape (m,)."""
    columns = known.columns()
    noise = np.where(known.is_y, found.noise.get(True, 1.0), found.noise.get(False, 1.0))
    spread = np.einsum("mk,mk->m", columns @ found.covariance, columns) / noise**2
    left = known.value - columns @ found.values
    # A reading that was in the fit has drawn it to itself; one without weight has not.
    own = np.minimum(weight * spread, 1 - 1e-9)
    return np.asarray(left / (1 - own) / (noise * np.sqrt(1 + spread / (1 - own))))


def _best(known: Known, weight: Array, size: float, start: Array | None) -> Shrunk:
    """Return the fit at the heights, lengths and noise of the greatest evidence."""
    from scipy.optimize import minimize

    evidence = _Evidence(known, weight, size)
    done = minimize(
        lambda logs: evidence.at(logs)[:2],
        evidence.first() if start is None else start,
        jac=True,
        method="L-BFGS-B",
        bounds=evidence.bounds(),
        options={"maxiter": _TURNS, "ftol": _SETTLED},
    )
    return evidence.solved(done.x)


class _Evidence:
    """The likelihood of the data with all coefficients integrated out."""

    def __init__(self, known: Known, weight: Array, size: float):
        self.axes, self.size = tuple(bool(one) for one in np.unique(known.is_y)), size
        self.p = known.model.shape[1]
        columns = known.columns()
        self.length = np.ones(columns.shape[1])
        size_of = np.linalg.norm(known.model, axis=0)
        self.length[: self.p] = np.where(size_of > 0, size_of, 1.0)
        whole = np.concatenate([columns / self.length, known.value[:, None] / self.size], axis=1)
        whole *= np.sqrt(weight)[:, None]
        of_axis = [known.is_y == axis for axis in self.axes]
        self.grams = [whole[rows].T @ whole[rows] for rows in of_axis]
        self.counts = [float(weight[rows].sum()) for rows in of_axis]
        self.parts = [(family, axis) for axis in self.axes for family in FAMILIES]

    def first(self) -> Array:
        """Return what is known of heights, lengths and noise before the data are looked at."""
        found = [one for family, _ in self.parts for one in (HALF, *np.log(family.length))]
        return np.array(found + [HALF] * len(self.axes))

    def bounds(self) -> list[tuple[float, float]]:
        """Return the bounds of each."""
        found = []
        for family, _ in self.parts:
            found += [tuple(_HEIGHT), *(tuple(np.log(one) + _LENGTH) for one in family.length)]
        return found + [tuple(_NOISE)] * len(self.axes)

    def at(self, logs: Array) -> tuple[float, Array, Array, Array, Array]:
        """Return minus the log-evidence, its slopes, the solution, its covariance, variances."""
        from scipy.linalg import lapack

        usual = self.first()
        spread = np.full(len(logs), np.inf)
        variance, slopes = np.zeros(2 * COUNT), []
        place = 0
        for family, axis in self.parts:
            end = place + 1 + len(family.length)
            spread[place], spread[place + 1 : end] = HEIGHT_SPREAD, LENGTH_SPREAD
            own = slice(axis * COUNT + family.place.start, axis * COUNT + family.place.stop)
            variance[own], slope = family.spectrum(logs[place + 1 : end])
            variance[own] += 2 * logs[place]
            slopes.append((slice(place, end), own, slope))
            place = end
        noise = logs[place:]
        gram = sum(g * np.exp(-2 * one) for g, one in zip(self.grams, noise, strict=True))
        normal = np.array(gram[:-1, :-1])
        # A whisper of a prior on the model's own terms lets them be dependent.
        prior = np.concatenate([np.full(self.p, 1e-9), np.exp(-variance)])
        normal[np.diag_indices_from(normal)] += prior
        root = np.linalg.cholesky(normal)
        covariance = lapack.dpotri(root, lower=1)[0]
        covariance = np.tril(covariance) + np.tril(covariance, -1).T
        values = lapack.dpotrs(root, gram[:-1, -1], lower=1)[0]
        off = (logs - usual) / spread
        counted = float(np.dot(self.counts, noise))
        value = float(
            (gram[-1, -1] - gram[:-1, -1] @ values + variance.sum()) / 2
            + np.log(np.diag(root)).sum()
            + counted
            + off @ off / 2
        )
        grown = (values**2 + np.diag(covariance))[self.p :]
        along = (1 - np.exp(-variance) * grown) / 2
        slope = off / spread
        for where, own, by_length in slopes:
            slope[where] += [2 * along[own].sum(), *(along[own] @ by_length)]
        for n, (own, count) in enumerate(zip(self.grams, self.counts, strict=True)):
            inner, cross = own[:-1, :-1], own[:-1, -1]
            left = own[-1, -1] - 2 * values @ cross + values @ inner @ values
            left += np.sum(covariance * inner)
            slope[place + n] += count - left * np.exp(-2 * noise[n])
        return value, slope, values, covariance, variance

    def solved(self, logs: Array) -> Shrunk:
        """Return the fit at some heights, lengths and noise."""
        _, _, values, covariance, variance = self.at(logs)
        scale = self.size / self.length
        freed = 1 - np.exp(-variance) * np.diag(covariance)[self.p :]
        there = np.repeat([axis in self.axes for axis in (False, True)], COUNT)
        place = sum(1 + len(family.length) for family, _ in self.parts)
        noise = np.exp(logs[place:]) * self.size
        return Shrunk(
            values * scale,
            covariance * np.outer(scale, scale),
            float(freed[there].sum()),
            dict(zip(self.axes, noise.tolist(), strict=True)),
            logs,
        )
