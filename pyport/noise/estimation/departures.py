"""The variances of departures, which are random effects, by restricted likelihood.

A session with one row borrows from the others; one with a hundred speaks for itself (Searle,
Casella & McCulloch 1992, Variance Components, ch. 6).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, solve_triangular
from scipy.linalg.lapack import dpotri

from pyport.angles import Array, Codes
from pyport.noise.covariance import Covariance
from pyport.noise.series import Departures, Possible
from pyport.thresholds import DEPARTURE_WORTH

#: Whitened data of less variance than this are fitted exactly: nothing departs.
EXACT = 1e-6
#: A column that keeps less of its squared length beside the model is drawn by it.
DRAWN = 1e-6
ROUNDS, CONVERGED = 30, 1e-4


@dataclass(frozen=True)
class _Projected:
    """What the whitened data say of all departures with the model projected out.

    `products` (q, q) and `moments` (q,) are those of the departures' columns, `kind` (q,) says
    which departures each column belongs to; `misfit` and `dof` are of the data.
    """

    products: Array
    moments: Array
    kind: Codes
    misfit: float
    dof: int

    @cached_property
    def power(self) -> Array:
        """Return the squared length of the columns of each kind, shape (kinds,)."""
        return np.asarray(np.bincount(self.kind, np.diag(self.products)), float)

    def lack(self, variances: Array, triangle: Array | None) -> float:
        """Return minus twice the restricted log-likelihood, the scale profiled out."""
        if triangle is None:
            return np.inf
        active = np.flatnonzero(variances[self.kind])
        root = np.sqrt(variances[self.kind[active]])
        along = _solved(triangle, root * self.moments[active])
        left = max(self.misfit - float(along @ along), EXACT)
        return 2 * float(np.log(np.diag(triangle)).sum()) + self.dof * float(np.log(left))

    def triangle(self, variances: Array) -> Array | None:
        """Return the triangle of 1 + R P R, P of the columns that depart, R their deviations.

        None where the rounding of the products outweighs one: the data do not hold so large a
        variance.
        """
        active = np.flatnonzero(variances[self.kind])
        root = np.sqrt(variances[self.kind[active]])
        inner = self.products if len(active) == len(self.kind) else self.products[active][:, active]
        inner = inner * root
        inner *= root[:, None]
        inner[np.diag_indices(len(active))] += 1.0
        if not np.isfinite(inner).all():
            return None
        try:
            return np.asarray(np.linalg.cholesky(inner))
        except np.linalg.LinAlgError:
            return None

    def step(self, variances: Array, triangle: Array) -> tuple[Array, Array]:
        """Return the gradient of `lack` and its expected curvature in the variances.

        With B = 1 + R P R the products that the active columns keep beside what departs are
        R^-1 (1 - B^-1) R^-1, those of them with idle ones R^-1 B^-1 R P.
        """
        active = np.flatnonzero(variances[self.kind])
        idle = np.flatnonzero(variances[self.kind] == 0)
        kinds = self.kind[active], self.kind[idle]
        root, count = np.sqrt(variances[kinds[0]]), len(variances)
        across = root[:, None] * self.products[np.ix_(active, idle)]
        weighed = _solved_twice(triangle, across)
        others = self.products[np.ix_(idle, idle)] - weighed.T @ across
        taken = _solved_twice(triangle, root * self.moments[active])
        spared, squares = _inverse_squares(triangle)
        seen, power = np.empty(len(self.kind)), np.empty(len(self.kind))
        seen[active], seen[idle] = taken / root, self.moments[idle] - across.T @ taken
        power[active], power[idle] = spared / root**2, np.diag(others)
        left = self.misfit - float(root * self.moments[active] @ taken)
        scale = max(left, EXACT) / self.dof
        gradient = np.asarray(np.bincount(self.kind, power - seen**2 / scale, count), float)
        # Half of it on and above the diagonal, whose squares come twice.
        half = _by_kind(squares, kinds[0], kinds[0], count)
        half += _by_kind(weighed**2, *kinds, count)
        curvature = half + half.T - np.diag(np.bincount(kinds[0], spared**2, count))
        unit = np.where(variances > 0, variances, 1.0)
        curvature = curvature / unit / unit[:, None]
        return gradient, curvature + _by_kind(others**2, kinds[1], kinds[1], count)


def _by_kind(values: Array, one: Codes, other: Codes, count: int) -> Array:
    """Return the sums of values (a, b) over the kinds of rows (a,) and columns (b,)."""
    kinds = np.arange(count)
    of_rows, of_columns = ((kind[:, None] == kinds).astype(float) for kind in (one, other))
    return np.asarray(of_rows.T @ (values @ of_columns))


def _inverse_squares(triangle: Array) -> tuple[Array, Array]:
    """Return what the inverse of L L' has less than one on its diagonal, and squares (q, q).

    Of one less that inverse, on and above the diagonal; below it are zeros. L is the lower
    triangle.
    """
    if not len(triangle):
        return np.zeros(0), triangle
    upper = dpotri(triangle.T)[0]
    spared = 1 - np.diag(upper)
    squares = np.square(upper, out=upper)
    np.fill_diagonal(squares, spared**2)
    return spared, squares


def _solved_twice(triangle: Array, right: Array) -> Array:
    """Return the inverse of L L' times columns (q, k) or one (q,)."""
    if not right.size:
        return right
    return np.asarray(cho_solve((triangle, True), right, check_finite=False))


def _solved(triangle: Array, right: Array) -> Array:
    if not len(right):
        return right
    return np.asarray(solve_triangular(triangle, right, lower=True, check_finite=False))


def estimate(
    covariance: Covariance, value: Array, design: Array, possible: Possible
) -> tuple[Departures, ...]:
    """Return the departures that are worth having, with their standard deviations.

    Parameters
    ----------
    covariance
        Of the readings; where it was asked for departures, the search starts from those it has.
    value, design
        The data (m,) and the columns that are always fitted, (m, p).
    possible
        The departures that are possible.
    """
    some = possible.departures
    if not some:
        return ()
    projected = _project(covariance, value, design, possible)
    if projected.misfit < EXACT * projected.dof:
        return ()
    if covariance.possible is None:
        variances = _smallest(projected)
    else:
        was = {one.whose: one.sigma**2 for one in covariance.departures}
        variances = np.array([was.get(one.whose, 0.0) for one in some])
    variances = _fitted(projected, variances)
    variances = _without_idle(projected, variances)
    dof = _known(projected, variances)
    return tuple(
        replace(one, sigma=float(np.sqrt(variances[n])), dof=float(dof[n]))
        for n, one in enumerate(some)
        if variances[n] > 0
    )


def _known(projected: _Projected, variances: Array) -> Array:
    """Return from how many deviations each variance is known, by the expected curvature."""
    free = np.flatnonzero(variances > 0)
    dof = np.ones(len(variances))
    triangle = projected.triangle(variances)
    if len(free) and triangle is not None:
        curvature = projected.step(variances, triangle)[1][np.ix_(free, free)]
        # The inverse of half the curvature is the variance of a variance: 2 / dof of its square.
        error = np.diag(np.linalg.pinv(curvature * np.outer(variances[free], variances[free])))
        dof[free] = 1 / np.clip(error, 1e-12, 1.0)
    return dof


def _project(covariance: Covariance, value: Array, design: Array, possible: Possible) -> _Projected:
    # What all labels share is no departure, whether the model has a term for it or lacks one.
    full = np.concatenate([possible.shared, design, value[:, None]], axis=1)
    gram, used = covariance.products_beside(possible, np.ones(len(possible.kind)), full)
    q = len(possible.kind)
    model, others = np.arange(q, len(gram) - 1), np.append(np.arange(q), len(gram) - 1)
    length = np.sqrt(np.maximum(np.diag(gram)[model], 1e-300))
    power, vectors = np.linalg.eigh(gram[np.ix_(model, model)] / np.outer(length, length))
    kept = power > 1e-10 * power.max(initial=0.0)
    shared = (vectors[:, kept] / np.sqrt(power[kept])).T @ (
        gram[np.ix_(model, others)] / length[:, None]
    )
    left = gram[np.ix_(others, others)] - shared.T @ shared
    # What the model draws all of is nothing that departs.
    drawn = np.diag(left)[:-1] < DRAWN * np.diag(gram)[:q]
    left[:-1][drawn], left[:, :-1][:, drawn] = 0.0, 0.0
    return _Projected(
        left[:-1, :-1],
        left[:-1, -1],
        possible.kind,
        float(left[-1, -1]),
        max(1, used - int(kept.sum())),
    )


def _smallest(projected: _Projected) -> Array:
    """Return variances (kinds,) that could just be seen."""
    power = projected.power
    return np.where(power > 0, np.bincount(projected.kind) / np.maximum(power, 1e-300), 0.0)


def _fitted(projected: _Projected, variances: Array) -> Array:
    """Return the variances of the greatest restricted likelihood, none below zero.

    Fisher scoring from some variances; what would go below zero stays there.
    """
    count, power = len(variances), projected.power
    while (triangle := projected.triangle(variances)) is None:
        variances = variances / 4
    lack = projected.lack(variances, triangle)
    for _ in range(ROUNDS):
        gradient, curvature = projected.step(variances, triangle)
        free = (variances > 0) | ((gradient < 0) & (power > 0))
        move = np.zeros(count)
        if free.any():
            inner = curvature[np.ix_(free, free)]
            inner = inner + 1e-9 * np.diag(np.diag(inner)) + 1e-300 * np.eye(len(inner))
            move[free] = -np.linalg.solve(inner, gradient[free])
        share = 1.0
        while share > 1e-3:
            new = np.maximum(variances + share * move, 0.0)
            factored = projected.triangle(new)
            better = projected.lack(new, factored)
            if factored is not None and better <= lack + 1e-12:
                break
            share /= 2
        else:
            break
        change = lack - better
        variances, lack, triangle = new, better, factored
        if change < CONVERGED:
            break
    return variances


def _without_idle(projected: _Projected, variances: Array) -> Array:
    """Set variances to zero that the data can do without, the idlest first."""
    variances = variances.copy()
    while (variances > 0).any():
        lack = projected.lack(variances, projected.triangle(variances))
        without = {}
        for one in np.flatnonzero(variances > 0):
            fewer = variances.copy()
            fewer[one] = 0.0
            without[int(one)] = projected.lack(fewer, projected.triangle(fewer)) - lack
        idlest = min(without, key=lambda one: without[one])
        if without[idlest] > DEPARTURE_WORTH:
            break
        variances[idlest] = 0.0
    return variances
