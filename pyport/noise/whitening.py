"""Whitening under the noise of one antenna and axis.

Readings of one pointing that differ (channels of one scan) scatter by `within`; pointings
scatter by `between` on top; and what drifts is a sum of Ornstein-Uhlenbeck processes. Whitening
turns columns into ones of unit scatter, so that plain least squares is the right thing to do.
What both axes, sessions and sources share is added by `covariance`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyport.angles import Array
from pyport.noise.series import Noise, Series
from pyport.pointing import kernel

#: A reading of less weight than this is an outlier; its variance is taken as `FAR` [rad^2].
NO_WEIGHT = 1e-9
FAR = 1e4


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
    means, variance, deviations = by_pointing(columns, weights, precision, part, noise)
    white = decorrelate(means, variance, part, noise)
    directions, power = centring(variance, part, noise)
    return _scaled(white, directions, 1 / np.sqrt(power)), deviations


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
    variance = by_pointing(columns[:0], weights[rows], precision[rows], part, noise)[1]
    drifts = () if part.time is None else noise.drifts
    return kernel.whiten(columns, variance, part.time, drifts, (rows, out)) is not None


def products(
    columns: kernel.Columns, weights: Array, precision: Array, part: Series, noise: Noise
) -> Array | None:
    """Return the products of what `whiten_series` returns of columns (n, K): shape (K, K).

    None where the kernel cannot: readings that share a pointing, drifts that are centred.
    """
    if not part.alone or noise.centred:
        return None
    variance = variance_of_means(weights, precision, part, noise)
    found = kernel.products(columns, variance, part.time, noise.drifts)
    return None if found is None else found[1]


def by_pointing(
    columns: Array, weights: Array, precision: Array, part: Series, noise: Noise
) -> tuple[Array, Array, Array | None]:
    """Return each pointing's mean, the variance of that mean, and whitened deviations from it.

    A lone reading has no deviation; its scatter is `within` and `between` together, and its
    weight is that of both. Where all stand alone there are no deviations.
    """
    count = part.readings
    if count.max() == 1:
        if part.order is not None:
            columns, weights = columns[part.order], weights[part.order]
            precision = precision[part.order]
        variance = (noise.between**2 + noise.within**2) / np.maximum(weights * precision, 1e-12)
        variance = np.where(weights < NO_WEIGHT, FAR, variance)
        return columns, variance, None
    own = _precisions(weights, precision, noise)
    total = np.bincount(part.pointing, own)
    means = np.empty((len(count), columns.shape[1]))
    for k, column in enumerate(columns.T):
        means[:, k] = np.bincount(part.pointing, own * column) / total
    deviations, best = np.zeros_like(columns), np.zeros(len(count))
    # Where repeats scatter their weights stand in `own`; a lone reading's is that of both scatters.
    apart = (count[part.pointing] > 1) & (noise.within > 0)
    np.maximum.at(best, part.pointing, np.where(apart, 1.0, weights) * precision)
    variance = noise.between**2 / np.maximum(best, 1e-12)
    if noise.within > 0:
        deviations = (columns - means[part.pointing]) * np.sqrt(own)[:, None]
        variance = variance + 1 / total
    # An outlier says nothing, whatever the noise: its variance must not move with it.
    heaviest = np.zeros(len(count))
    np.maximum.at(heaviest, part.pointing, weights)
    return means, np.where(heaviest < NO_WEIGHT, FAR, variance), deviations


def variance_of_means(weights: Array, precision: Array, part: Series, noise: Noise) -> Array:
    """Return the variance of each pointing's mean, drift apart [rad^2], shape (p,)."""
    return by_pointing(np.zeros((len(weights), 0)), weights, precision, part, noise)[1]


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
    from celerite2 import driver

    d, *triangle = _triangle(variance, time, drifts)
    z = np.ascontiguousarray(columns)
    z = driver.solve_lower(*triangle, z, np.empty_like(z))
    z /= np.sqrt(d)[:, None]
    return d, z


def _triangle(
    variance: Array, time: Array, drifts: Sequence[tuple[float, float]]
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
    variance = variance_of_means(weights, precision, part, noise)
    directions, power = centring(variance, part, noise)
    means = _scaled(means, directions, 1 / np.sqrt(power))
    if part.time is None or not noise.drifts:
        inner = means / np.sqrt(variance)[:, None]
    else:
        from celerite2 import driver

        d, *triangle = _triangle(variance, part.time, noise.drifts)
        z = np.ascontiguousarray(means / np.sqrt(d)[:, None])
        inner = driver.solve_upper(*triangle, z, np.empty_like(z))
    if part.readings.max() == 1:
        return inner[part.pointing]
    own = _precisions(weights, precision, noise)
    share = (own / np.bincount(part.pointing, own)[part.pointing])[:, None]
    if noise.within == 0:
        return share * inner[part.pointing]
    inside = np.sqrt(own)[:, None] * deviations
    return share * (inner - _pooled(inside, part))[part.pointing] + inside


def series_errors(
    estimators: Array, weights: Array, precision: Array, part: Series, noise: Noise
) -> tuple[Array, Array | None]:
    """Return rows whose products are the covariance of estimators (n, K) of readings.

    Those of the pointings' means, (p, K), and of the deviations from them, (n, K).
    """
    variance = variance_of_means(weights, precision, part, noise)
    pooled = _pooled(estimators, part)
    if part.time is None or not noise.drifts:
        outer = pooled * np.sqrt(variance)[:, None]
    else:
        from celerite2 import driver

        d, *triangle = _triangle(variance, part.time, noise.drifts)
        outer = driver.matmul_upper(*triangle, pooled, pooled.copy()) * np.sqrt(d)[:, None]
    directions, power = centring(variance, part, noise)
    outer = _scaled(outer, directions, np.sqrt(power))
    if part.readings.max() == 1 or noise.within == 0:
        return outer, None
    own = _precisions(weights, precision, noise)
    root, total = np.sqrt(own)[:, None], np.bincount(part.pointing, own)
    return outer, estimators / root - root * (pooled / total[:, None])[part.pointing]


def _precisions(weights: Array, precision: Array, noise: Noise) -> Array:
    """Return one over the variance of each reading about its pointing's mean, shape (n,)."""
    return np.asarray(np.maximum(weights * precision, 1e-12) / (noise.within or 1.0) ** 2)


def _pooled(columns: Array, part: Series) -> Array:
    """Return the sums (p, K) of columns (n, K) over the readings of each pointing."""
    out = np.zeros((len(part.readings), columns.shape[1]))
    np.add.at(out, part.pointing, columns)
    return out
