"""The restricted likelihood of the noise of one series, scale and departures profiled out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtrs

from pyport.angles import Array
from pyport.noise.series import Noise, Series
from pyport.noise.whitening import FAR, factor, whitening
from pyport.pointing import kernel


@dataclass(frozen=True)
class Departing:
    """What departures of sessions and sources of one standard deviation do to a series.

    Attributes
    ----------
    columns
        In units of the scatter, q of them.
    faint
        Orthonormal directions among the columns that do not matter, shape (q, k).
    """

    columns: kernel.Columns
    faint: Array


@dataclass(frozen=True)
class Likelihood:
    """The restricted likelihood of a white part and a drift, the scale profiled out.

    `columns` holds those of the departures, of which the directions `faint` do not matter, the
    design and, last, the data; `variance` is relative.
    """

    columns: kernel.Columns
    variance: Array
    time: Array | None
    faint: Array

    @property
    def dof(self) -> int:
        """Return the deviations that tell of the noise."""
        return max(1, len(self.variance) - self.columns.full.shape[1] + 1)

    def at(self, drifts: Sequence[tuple[float, float]]) -> tuple[float, float]:
        """Return minus twice the log-likelihood and the scale, for drifts of unit scatter."""
        drifts = () if self.time is None else drifts
        found = kernel.products(self.columns, self.variance, self.time, drifts)
        if found is None:
            d, white = factor(self._dense, self.variance, self.time, drifts)
            gram = white.T @ white
        else:
            d, gram = found
        diagonal = np.einsum("kk->k", gram)
        departing, fixed = diagonal[: self.columns.q], diagonal[self.columns.q : -1]
        departing += 1.0
        fixed += 1e-12 * (1 + fixed)
        triangle = _triangle(gram[:-1, :-1])
        right = np.zeros((len(triangle), 1 + self.faint.shape[1]))
        right[:, 0], right[: len(self.faint), 1:] = gram[:-1, -1], self.faint
        solved = _forward(triangle, right)
        taken, logs = _without(solved[:, 0], solved[:, 1:])
        misfit = max(float(gram[-1, -1]) - taken, 1e-300)
        logs += float(np.log(d).sum()) + _log_determinant(triangle)
        return logs + self.dof * np.log(misfit), float(np.sqrt(misfit / self.dof))

    @cached_property
    def _dense(self) -> Array:
        return self.columns.dense()


def likelihood_of(
    value: Array,
    columns: Array,
    departing: Departing,
    weight: Array,
    precision: Array,
    part: Series,
) -> Likelihood:
    """Return the likelihood of a series' pointings, outliers left out; see `drift.draft`."""
    given = departing.columns.beside(np.concatenate([columns, value[:, None]], axis=1))
    seen = whitening(weight, precision, part, Noise(0.0, 1.0))
    kept = seen.variance < FAR
    if not (part.alone and kept.all()):
        given = seen.means_of(given).of_rows(kept)
    time = None if part.time is None else part.time[kept]
    return Likelihood(given, seen.variance[kept], time, departing.faint)


def _without(seen: Array, faint: Array) -> tuple[float, float]:
    """Return the square and the log-determinant that a fit loses with some directions left out.

    With M = L L' the products of all columns, b those with the data and V the directions (P, k),
    `seen` is L^-1 b and `faint` L^-1 V: without them b' M^-1 b is less by the part that
    (M^-1 b)' V (V' M^-1 V)^-1 V' M^-1 b is, and log|M| more by log|V' M^-1 V|.
    """
    square = float(seen @ seen)
    if not faint.shape[1]:
        return square, 0.0
    triangle = _triangle(faint.T @ faint)
    along = _forward(triangle, faint.T @ seen)
    return square - float(along @ along), _log_determinant(triangle)


#: What products of columns that hardly differ lose to rounding, over their squared lengths.
ROUNDING = 1e-11


# LAPACK alone: thousands of times, where what checks its input costs as much.
def _forward(triangle: Array, right: Array) -> Array:
    """Return L^-1 R."""
    return np.asarray(dtrtrs(triangle, right, lower=1)[0])


def _triangle(products: Array) -> Array:
    """Return the Cholesky triangle of products, held against rounding where that spoils them."""
    # Rows of what is symmetric are its columns, which LAPACK wants.
    triangle, fault = dpotrf(products.T, lower=1)
    if fault:
        lost = ROUNDING * (1 + np.diag(products))
        return np.asarray(np.linalg.cholesky(products + np.diag(lost)))
    return np.asarray(triangle)


def _log_determinant(triangle: Array) -> float:
    """Return the log-determinant of L L'."""
    return 2 * float(np.log(triangle.diagonal()).sum())
