"""Coefficients, and their errors, under noise that is only roughly what it is taken for.

Generalised least squares takes its noise at its word: where the drift seems strong it fits
differences between neighbours alone. What looks like a drift may be a shape on the sky that no term
has, and then a fit by differences is off where the model is used. So coefficients are estimated
under a covariance whose drifts and departures are mostly moved to the white scatter, which costs
little where they are real, and their errors are those of this estimate under the whole covariance
(a sandwich: Liang & Zeger 1986, Biometrika 73, 13).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import ndtr, stdtrit

from pyport.angles import Array
from pyport.least_squares.gram import Solution, inverse_of
from pyport.noise.covariance import Covariance
from pyport.noise.estimation.frame import Frame
from pyport.noise.series import Noise
from pyport.thresholds import TRUST


def equal(value: Array, design: Array, given: Frame) -> Covariance:
    """Return the covariance of readings with one scatter, that of what a fit leaves.

    What TPOINT and the Field System's `error` do: their published rms and coefficients come
    out digit for digit.

    Parameters
    ----------
    value, design
        The data [rad], shape (m,), and the columns that are fitted, shape (m, p).
    given
        The frame of the recordings.
    """
    solution, _, rank, _ = np.linalg.lstsq(design, value, rcond=1e-9)
    left = value - design @ solution
    scatter = float(np.sqrt((left**2).sum() / max(len(value) - int(rank), 1)))
    noise = Noise(within=max(scatter, 1e-12), between=0.0)
    every = np.ones(len(value))
    return Covariance(given.parts, (noise,) * len(given.parts), every, every)


def solve(
    covariance: Covariance, columns: Array, value: Array, precision: Array | float = 0.0
) -> Solution:
    """Return coefficients and their covariance.

    Parameters
    ----------
    covariance
        Of the readings.
    columns, value
        What is fitted, shape (m, P), and the data, (m,), both in the same units [rad].
    precision
        What is known of the coefficients beforehand: `Solution.of`.

    Returns
    -------
    Solution
        `residual` is what generalised least squares under the whole covariance leaves: it tells
        whether the noise is as large as it was estimated.
    """
    data = np.concatenate([columns, value[:, None]], axis=1)
    strict = covariance.whiten(data)
    products = strict.T @ strict
    best = Solution.of(products, precision)
    soft = tempered(covariance)
    white = strict if soft is covariance else soft.whiten(data)
    normal = white[:, :-1].T @ white[:, :-1]
    normal += np.diag(np.full(len(normal), precision))
    inverse, _, known = inverse_of(normal)
    values = inverse @ (white[:, :-1].T @ white[:, -1])
    estimator = soft.unwhiten(white[:, :-1]) @ inverse
    errors, shares = covariance.errors(estimator)
    wider = widening(shares)
    scatter = errors.T @ errors * np.outer(wider, wider)
    # How far from where they start the coefficients may be drawn.
    scatter += (inverse * precision) @ inverse
    return replace(
        best,
        values=values,
        covariance=scatter,
        known=known,
        normal=normal,
    )


def widening(shares: Sequence[tuple[Array, float]]) -> Array:
    """Return by how much what is known of the variances widens each error, shape (P,).

    A variance that few sessions show, or a drift that turned few times, is itself uncertain: the
    degrees of freedom of an error are those of its parts, weighed by what they add to it
    (Satterthwaite 1946, Biometrics Bulletin 2, 110), and the error is half of the interval of
    Student's t that holds as much as one sigma of a normal.
    """
    total = rough = np.zeros(1)
    for variance, of in shares:
        total, rough = total + variance, rough + variance**2 / of
    dof = total**2 / np.maximum(rough, 1e-300)
    return np.asarray(stdtrit(np.maximum(dof, 1.0), ndtr(1.0)))


def tempered(covariance: Covariance) -> Covariance:
    """Return a covariance most of whose drifts and departures is white scatter instead.

    The same one where there are none.
    """
    if not covariance.departures and not any(noise.drifts for noise in covariance.noises):
        return covariance
    root = float(np.sqrt(TRUST))
    return replace(
        covariance,
        noises=tuple(_whiter(noise, root) for noise in covariance.noises),
        departures=tuple(replace(one, sigma=one.sigma * root) for one in covariance.departures),
    )


def _whiter(noise: Noise, root: float) -> Noise:
    return replace(
        noise,
        between=float(np.sqrt(noise.between**2 + (1 - root**2) * noise.drift**2)),
        drifts=tuple((amplitude * root, memory) for amplitude, memory in noise.drifts),
    )
