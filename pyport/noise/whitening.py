"""Whitening under the noise of one antenna and axis.

Readings of one pointing that differ (channels of one scan) scatter by `within`; pointings
scatter by `between` on top; and what drifts is a sum of Ornstein-Uhlenbeck processes. Whitening
turns columns into ones of unit scatter, so that plain least squares is the right thing to do.
What both axes, sessions and sources share is added by `covariance`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.noise.series import Noise, Series
from pyport.pointing import kernel

#: A reading of less weight than this is an outlier; its variance is taken as `FAR` [rad^2].
NO_WEIGHT = 1e-9
FAR = 1e4

#: Amplitude and memory [s] of each Ornstein-Uhlenbeck process.
Drifts = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class Pointings:
    """The pointings of a series: the means of their readings, and how each differs from its own.

    Attributes
    ----------
    part
        The series.
    variance
        Of the mean of each pointing, drift apart [rad^2], shape (p,).
    share
        Of each reading in its pointing's mean, shape (n,); None where all stand alone.
    root
        One over the scatter of each reading about that mean, shape (n,), zero where it stands
        alone; None where none scatters.
    """

    part: Series
    variance: Array
    share: Array | None = None
    root: Array | None = None

    def means(self, columns: Array) -> Array:
        """Return the means (p, K) of columns (n, K)."""
        if self.share is None:
            return columns if self.part.order is None else columns[self.part.order]
        return np.asarray(self.part.sums @ (self.share[:, None] * columns))

    def products(self, columns: kernel.Columns, drifts: Drifts) -> Array | None:
        """Return the products (K, K) of whitened columns (n, K); None without the kernel."""
        means = self.means_of(columns)
        found = kernel.products(means, self.variance, self.part.time, drifts)
        if found is None or self.root is None:
            return None if found is None else found[1]
        apart = np.flatnonzero(self.root)
        own = columns.beside_means(means, apart, self.part.pointing[apart], self.root[apart])
        return found[1] + own.products()

    def means_of(self, columns: kernel.Columns) -> kernel.Columns:
        """Return the means (p, K) of columns (n, K) of which many numbers are zero."""
        if self.share is None and self.part.order is None:
            return columns
        ones = np.ones(len(self.part.rows))
        return columns.summed(self.part.sums, ones if self.share is None else self.share)


def pointings_of(weights: Array, precision: Array, part: Series, noise: Noise) -> Pointings:
    """Return the pointings of a series whose readings have some robust weights and precision, (n,).

    The scatter of a lone reading is `within` and `between` together, and its weight is that of
    both.
    """
    variance, own = _variances(weights, precision, part, noise)
    if own is None:
        return Pointings(part, variance)
    share = own / np.bincount(part.pointing, own)[part.pointing]
    root = np.where(part.lone, 0.0, np.sqrt(own)) if noise.within > 0 else None
    return Pointings(part, variance, share, root)


def _variances(
    weights: Array, precision: Array, part: Series, noise: Noise
) -> tuple[Array, Array | None]:
    """Return the variance of each pointing's mean (p,) and the precision of each reading (n,).

    The precision about its pointing's mean: None where all stand alone.
    """
    count = part.readings
    if count.max() == 1:
        if part.order is not None:
            weights, precision = weights[part.order], precision[part.order]
        variance = (noise.between**2 + noise.within**2) / np.maximum(weights * precision, 1e-12)
        return np.where(weights < NO_WEIGHT, FAR, variance), None
    own = np.maximum(weights * precision, 1e-12) / (noise.within or 1.0) ** 2
    best = np.zeros(len(count))
    # Where repeats scatter their weights stand in `own`; a lone reading's is that of both scatters.
    apart = ~part.lone & (noise.within > 0)
    np.maximum.at(best, part.pointing, np.where(apart, 1.0, weights) * precision)
    variance = noise.between**2 / np.maximum(best, 1e-12)
    if noise.within > 0:
        variance = variance + 1 / np.bincount(part.pointing, own)
    # An outlier says nothing, whatever the noise: its variance must not move with it.
    heaviest = np.zeros(len(count))
    np.maximum.at(heaviest, part.pointing, weights)
    return np.where(heaviest < NO_WEIGHT, FAR, variance), own


def variance_of_means(weights: Array, precision: Array, part: Series, noise: Noise) -> Array:
    """Return the variance of each pointing's mean, drift apart [rad^2], shape (p,)."""
    return _variances(weights, precision, part, noise)[0]


def whiten_series(
    columns: Array, weights: Array, precision: Array, part: Series, noise: Noise
) -> tuple[Array, Array | None]:
    """Return the whitened means of a series' pointings (p, K) and their readings' deviations.

    Parameters
    ----------
    columns, weights, precision
        Rows of the series: columns (n, K), robust weights (n,), one for an ordinary reading,
        and relative precision (n,), one for a reading of usual scatter.
    """
    seen = pointings_of(weights, precision, part, noise)
    means = seen.means(columns)
    white = decorrelate(means, seen.variance, part, noise)
    directions, power = centring(seen.variance, part, noise)
    apart = None if seen.root is None else seen.root[:, None] * (columns - means[part.pointing])
    return _scaled(white, directions, 1 / np.sqrt(power)), apart


def whiten_lone(
    columns: Array, weights: Array, precision: Array, part: Series, noise: Noise, out: Array
) -> bool:
    """Write what `whiten_series` returns where the kernel can: readings alone, drifts not centred.

    Parameters
    ----------
    columns, weights, precision, out
        Of all readings, not only of the rows of the series: shapes (m, K), (m,), (m,), (m, K).
    """
    if not part.alone or noise.centred:
        return False
    rows = part.rows
    variance = variance_of_means(weights[rows], precision[rows], part, noise)
    drifts = () if part.time is None else noise.drifts
    return kernel.whiten(columns, variance, part.time, drifts, (rows, out)) is not None


def products(
    columns: kernel.Columns, weights: Array, precision: Array, part: Series, noise: Noise
) -> Array | None:
    """Return the products of what `whiten_series` returns of columns (n, K): shape (K, K).

    None where the kernel cannot: drifts that are centred.
    """
    if noise.centred:
        return None
    return pointings_of(weights, precision, part, noise).products(columns, noise.drifts)


def decorrelate(columns: Array, variance: Array, part: Series, noise: Noise) -> Array:
    """Divide by the scatter, after taking out what the past of the drift predicts."""
    return factor(columns, variance, part.time, noise.drifts)[1]


def centring(variance: Array, part: Series, noise: Noise) -> tuple[Array, Array]:
    """Return by what a centred drift differs from one that may have a mean.

    With C = W + D the covariance of pointings and b = D 1 / n, the drift less its mean has the
    covariance D - 1 b' - b 1' + mean(b) 1 1'. Where a constant is fitted that is the same to every
    result; where none is, the drift would pass for one.

    Returns
    -------
    directions, power
        In the space that C whitens: orthonormal, shape (p, k), and the variance in each, (k,).
    """
    if not noise.centred or part.time is None or not noise.drifts:
        return np.zeros((len(variance), 0)), np.zeros(0)
    from celerite2 import driver

    one = np.ones((len(variance), 1))
    d, *triangle = _triangle(variance, part.time, noise.drifts)
    above = driver.matmul_upper(*triangle, one, one.copy()) * d[:, None]
    whole = driver.matmul_lower(*triangle, above, above.copy())[:, 0]
    mean = (whole - variance) / len(variance)
    columns = np.stack([one[:, 0], mean], axis=1)
    basis, triangular = np.linalg.qr(decorrelate(columns, variance, part, noise))
    added = np.array([[mean.mean(), -1.0], [-1.0, 0.0]])
    power, vectors = np.linalg.eigh(np.eye(2) + triangular @ added @ triangular.T)
    return basis @ vectors, power


def _scaled(white: Array, directions: Array, by: Array) -> Array:
    """Return whitened columns (p, K) multiplied by some factors (k,) in orthonormal directions."""
    if not len(by):
        return white
    return np.asarray(white + directions @ ((by - 1)[:, None] * (directions.T @ white)))


def factor(
    columns: Array, variance: Array, time: Array | None, drifts: Drifts
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
    from celerite2 import driver

    d, *triangle = _triangle(variance, time, drifts)
    z = np.ascontiguousarray(columns)
    z = driver.solve_lower(*triangle, z, np.empty_like(z))
    z /= np.sqrt(d)[:, None]
    return d, z


def _triangle(
    variance: Array, time: Array, drifts: Drifts
) -> tuple[Array, Array, Array, Array, Array]:
    """Return the diagonal of the covariance's factors L D L', and what makes L.

    The covariance of Ornstein-Uhlenbeck processes is semiseparable
    (Foreman-Mackey et al. 2017, AJ 154, 220).
    """
    from celerite2 import driver

    n, terms = len(variance), len(drifts)
    amplitude, memory = np.array(drifts).T
    rate, power = 1 / memory, np.tile(amplitude**2, (n, 1))
    ones = np.ones((n, terms))
    d, w = np.empty(n), np.empty((n, terms))
    driver.factor(time, rate, variance + power.sum(axis=1), power, ones, d, w)
    return d, time, rate, power, w


def unwhiten_series(
    means: Array, deviations: Array, weights: Array, precision: Array, part: Series, noise: Noise
) -> Array:
    """Return the transpose of `whiten_series`: columns (n, K) of means (p, K) and deviations."""
    seen = pointings_of(weights, precision, part, noise)
    directions, power = centring(seen.variance, part, noise)
    means = _scaled(means, directions, 1 / np.sqrt(power))
    if part.time is None or not noise.drifts:
        inner = means / np.sqrt(seen.variance)[:, None]
    else:
        from celerite2 import driver

        d, *triangle = _triangle(seen.variance, part.time, noise.drifts)
        z = np.ascontiguousarray(means / np.sqrt(d)[:, None])
        inner = driver.solve_upper(*triangle, z, np.empty_like(z))
    if seen.share is None:
        return inner[part.pointing]
    share = seen.share[:, None]
    if seen.root is None:
        return share * inner[part.pointing]
    inside = seen.root[:, None] * deviations
    return share * (inner - part.sums @ inside)[part.pointing] + inside


def series_errors(
    estimators: Array, weights: Array, precision: Array, part: Series, noise: Noise
) -> tuple[Array, Array | None]:
    """Return rows whose products are the covariance of estimators (n, K) of readings.

    Those of the pointings' means, (p, K), and of the deviations from them, (n, K).
    """
    variance, own = _variances(weights, precision, part, noise)
    pooled = np.asarray(part.sums @ estimators)
    if part.time is None or not noise.drifts:
        outer = pooled * np.sqrt(variance)[:, None]
    else:
        from celerite2 import driver

        d, *triangle = _triangle(variance, part.time, noise.drifts)
        outer = driver.matmul_upper(*triangle, pooled, pooled.copy()) * np.sqrt(d)[:, None]
    directions, power = centring(variance, part, noise)
    outer = _scaled(outer, directions, np.sqrt(power))
    if own is None or noise.within == 0:
        return outer, None
    root, total = np.sqrt(own)[:, None], np.bincount(part.pointing, own)
    return outer, estimators / root - root * (pooled / total[:, None])[part.pointing]
