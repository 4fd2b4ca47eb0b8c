"""Whitening under the noise of one antenna and axis.

Readings of one pointing that differ (channels of one scan) scatter by `within`; pointings
scatter by `between` on top; and what drifts is a sum of Ornstein-Uhlenbeck processes. Whitening
turns columns into ones of unit scatter, so that plain least squares is the right thing to do.
What both axes, sessions and sources share is added by `covariance`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pyport.angles import Array
from pyport.noise.series import Noise, Series
from pyport.pointing import kernel

#: A reading of less weight than this is an outlier; its variance is taken as `FAR` [rad^2].
NO_WEIGHT = 1e-9
FAR = 1e4


@dataclass(frozen=True)
class Whitening:
    """What whitens the readings of one series.

    Attributes
    ----------
    part, noise
        The series and its noise.
    variance
        Of the mean of each pointing, drift apart [rad^2], shape (p,).
    own
        Precision of each reading about its pointing's mean [1/rad^2], up to a factor where
        readings do not scatter about it, shape (n,); None where all stand alone.
    """

    part: Series
    noise: Noise
    variance: Array
    own: Array | None = None

    @property
    def drifts(self) -> Sequence[tuple[float, float]]:
        """Return amplitude and memory [s] of what drifts; none where no times are known."""
        return () if self.part.time is None else self.noise.drifts

    @cached_property
    def share(self) -> Array | None:
        """Return the share of each reading in its pointing's mean, (n,); None where all are one."""
        if self.own is None:
            return None
        return self.own / np.bincount(self.part.pointing, self.own)[self.part.pointing]

    @cached_property
    def root(self) -> Array | None:
        """Return one over the scatter of each reading about its pointing's mean, (n,).

        Zero where it stands alone; None where none scatters.
        """
        if self.own is None or self.noise.within == 0:
            return None
        return np.where(self.part.lone, 0.0, np.sqrt(self.own))

    def means(self, columns: Array) -> Array:
        """Return the means (p, K) of columns (n, K)."""
        if self.share is None:
            return columns
        return np.asarray(self.part.sums @ (self.share[:, None] * columns))

    def means_of(self, columns: kernel.Columns) -> kernel.Columns:
        """Return the means (p, K) of columns (n, K) of which many numbers are zero."""
        return columns if self.share is None else columns.summed(self.part.sums, self.share)

    def whiten(self, columns: Array) -> tuple[Array, Array | None]:
        """Return whitened means (p, K) of columns (n, K), and whitened deviations from them."""
        means = self.means(columns)
        white = factor(means, self.variance, self.part.time, self.drifts)[1]
        white = self._without_mean(white, -0.5)
        if self.root is None:
            return white, None
        return white, self.root[:, None] * (columns - means[self.part.pointing])

    def whiten_lone(self, columns: Array, out: Array) -> bool:
        """Write what `whiten` returns where the kernel can: readings alone, drifts not centred.

        `columns`, `out`: of all readings, not only of the series': (m, K) both.
        """
        if self.own is not None or self.noise.centred:
            return False
        given = self.variance, self.part.time, self.drifts
        return kernel.whiten(columns, *given, (self.part.rows, out)) is not None

    def products(self, columns: kernel.Columns) -> Array | None:
        """Return the products (K, K) of what `whiten` returns of columns (n, K).

        None where the kernel cannot: drifts that are centred.
        """
        if self.noise.centred:
            return None
        means = self.means_of(columns)
        found = kernel.products(means, self.variance, self.part.time, self.drifts)
        if found is None or self.root is None:
            return None if found is None else found[1]
        apart = np.flatnonzero(self.root)
        own = columns.beside_means(means, apart, self.part.pointing[apart], self.root[apart])
        return found[1] + own.products()

    def unwhiten(self, means: Array, deviations: Array) -> Array:
        """Return the transpose of `whiten`: columns (n, K) of means (p, K) and deviations."""
        means = self._without_mean(means, -0.5)
        if not self.drifts:
            inner = means / np.sqrt(self.variance)[:, None]
        else:
            inner = self._factors.times("solve_upper", means / self._factors.root[:, None])
        if self.share is None:
            return np.asarray(inner)
        share = self.share[:, None]
        if self.root is None:
            return np.asarray(share * inner[self.part.pointing])
        inside = self.root[:, None] * deviations
        return np.asarray(share * (inner - self.part.sums @ inside)[self.part.pointing] + inside)

    def errors(self, estimators: Array) -> tuple[Array, Array | None]:
        """Return rows whose products are the covariance of estimators (n, K) of readings.

        Those of the pointings' means, (p, K), and of the deviations from them, (n, K).
        """
        pooled = np.asarray(self.part.sums @ estimators)
        if not self.drifts:
            outer = pooled * np.sqrt(self.variance)[:, None]
        else:
            outer = self._factors.times("matmul_upper", pooled) * self._factors.root[:, None]
        outer = self._without_mean(outer, 0.5)
        if self.own is None or self.share is None or self.noise.within == 0:
            return outer, None
        root, share = np.sqrt(self.own)[:, None], self.share[:, None]
        return outer, (estimators - share * pooled[self.part.pointing]) / root

    def log_determinant(self) -> float:
        """Return the logarithm of the determinant of the means' covariance."""
        none = np.zeros((len(self.variance), 0))
        variances = factor(none, self.variance, self.part.time, self.drifts)[0], self._centring[1]
        return sum(float(np.log(one).sum()) for one in variances)

    def _without_mean(self, white: Array, power: float) -> Array:
        """Return whitened columns (p, K) under drifts counted from their mean, or the inverse.

        `power`: minus a half to whiten, a half for the inverse.
        """
        directions, variance = self._centring
        if not len(variance):
            return white
        by = variance**power - 1
        return np.asarray(white + directions @ (by[:, None] * (directions.T @ white)))

    @cached_property
    def _factors(self) -> _Factors:
        return _factors(self.variance, self.part.time, self.drifts)

    @cached_property
    def _centring(self) -> tuple[Array, Array]:
        """Return by what a centred drift differs from one that may have a mean.

        With C = W + D the covariance of pointings and b = D 1 / n, the drift less its mean has
        the covariance D - 1 b' - b 1' + mean(b) 1 1'. Where a constant is fitted that is the same
        to every result; where none is, the drift would pass for one.

        Returns
        -------
        directions, power
            In the space that C whitens: orthonormal, shape (p, k), and the variance in each, (k,).
        """
        if not self.noise.centred or not self.drifts:
            return np.zeros((len(self.variance), 0)), np.zeros(0)
        one = np.ones((len(self.variance), 1))
        above = self._factors.times("matmul_upper", one) * self._factors.d[:, None]
        whole = self._factors.times("matmul_lower", above)[:, 0]
        mean = (whole - self.variance) / len(self.variance)
        columns = np.stack([one[:, 0], mean], axis=1)
        white = factor(columns, self.variance, self.part.time, self.drifts)[1]
        basis, triangular = np.linalg.qr(white)
        added = np.array([[mean.mean(), -1.0], [-1.0, 0.0]])
        power, vectors = np.linalg.eigh(np.eye(2) + triangular @ added @ triangular.T)
        return basis @ vectors, power


def whitening(weights: Array, precision: Array, part: Series, noise: Noise) -> Whitening:
    """Return what whitens a series whose readings have some robust weights and precision, (n,).

    One for an ordinary reading and for one of usual scatter. The scatter of a lone reading is
    `within` and `between` together, and its weight is that of both.
    """
    if part.alone:
        variance = (noise.between**2 + noise.within**2) / np.maximum(weights * precision, 1e-12)
        return Whitening(part, noise, np.where(weights < NO_WEIGHT, FAR, variance))
    count = len(part.readings)
    own = np.maximum(weights * precision, 1e-12) / (noise.within or 1.0) ** 2
    best, heaviest = np.zeros(count), np.zeros(count)
    # Where repeats scatter their weights stand in `own`; a lone reading's is that of both scatters.
    apart = ~part.lone & (noise.within > 0)
    np.maximum.at(best, part.pointing, np.where(apart, 1.0, weights) * precision)
    variance = noise.between**2 / np.maximum(best, 1e-12)
    if noise.within > 0:
        variance = variance + 1 / np.bincount(part.pointing, own)
    # An outlier says nothing, whatever the noise: its variance must not move with it.
    np.maximum.at(heaviest, part.pointing, weights)
    return Whitening(part, noise, np.where(heaviest < NO_WEIGHT, FAR, variance), own)


def factor(
    columns: Array, variance: Array, time: Array | None, drifts: Sequence[tuple[float, float]]
) -> tuple[Array, Array]:
    """Whiten columns (n, K) under independent noise and drifts, in linear time.

    Returns
    -------
    d
        Variance of each row given the rows before it, shape (n,).
    white
        The columns with unit scatter, shape (n, K).
    """
    if time is None or len(drifts) == 0:
        return variance, columns / np.sqrt(variance)[:, None]
    compiled = kernel.whiten(columns, variance, time, drifts)
    if compiled is not None:
        return compiled
    factors = _factors(variance, time, drifts)
    return factors.d, factors.times("solve_lower", columns) / factors.root[:, None]


@dataclass(frozen=True)
class _Factors:
    """The factors L D L' of a covariance, d (n,) the diagonal of D and `lower` what makes L.

    The covariance of Ornstein-Uhlenbeck processes is semiseparable
    (Foreman-Mackey et al. 2017, AJ 154, 220).
    """

    d: Array
    lower: tuple[Array | None, Array, Array, Array]

    @cached_property
    def root(self) -> Array:
        """Return the root of D, (n,)."""
        return np.sqrt(self.d)

    def times(self, how: str, columns: Array) -> Array:
        """Return L or its transpose, or the inverse of one, times columns (n, K)."""
        from celerite2 import driver

        given = np.ascontiguousarray(columns)
        return np.asarray(getattr(driver, how)(*self.lower, given, given.copy()))


def _factors(
    variance: Array, time: Array | None, drifts: Sequence[tuple[float, float]]
) -> _Factors:
    from celerite2 import driver

    n, terms = len(variance), len(drifts)
    amplitude, memory = np.array(drifts).T
    rate, power = 1 / memory, np.tile(amplitude**2, (n, 1))
    ones = np.ones((n, terms))
    d, w = np.empty(n), np.empty((n, terms))
    driver.factor(time, rate, variance + power.sum(axis=1), power, ones, d, w)
    return _Factors(d, (time, rate, power, w))
