"""Departures of sessions and sources: random effects, their variances by restricted likelihood.

What nights do to the zeros, the tilts and the sag is noise to every other effect, and so is what
is wrong with the catalogue's places. A session with one row borrows from the others; one with a
hundred speaks for itself (Searle, Casella & McCulloch 1992, Variance Components, ch. 6).
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.linalg.lapack import dpotri

from pyport.angles import Array, Codes
from pyport.effects import CATALOGUE
from pyport.effects.base import Circumstances, MissingColumn
from pyport.effects.sky.astrometry import parallactic
from pyport.noise.covariance import Covariance
from pyport.noise.pointings import pointings
from pyport.noise.series import Departures, Possible
from pyport.recordings.schema import Recordings, Stack, group
from pyport.thresholds import DEPARTURE_WORTH, ENOUGH, PER_SOURCE, SEVERAL

#: Whitened data of less variance than this are fitted exactly: nothing departs.
EXACT = 1e-6
#: A column that keeps less of its squared length beside the model is drawn by it.
DRAWN = 1e-6
ROUNDS, CONVERGED = 30, 1e-4


def possible(recordings: Recordings, data: Stack) -> tuple[Departures, ...]:
    """Return the departures that the recordings of a single antenna could show, all of zero size.

    Sessions may depart in both zeros, in the tilts and in the sag, and so may stretches of rows
    where the order is all that is known of time; sources in the place that the
    catalogue gives them, or, where the sky's turn at the site is not known, in both offsets.
    """
    if len(np.unique(recordings.label("antenna").astype(str))) > 1:
        return ()
    antenna = str(recordings.label("antenna")[0]) if len(recordings) else ""
    found = [*_of_sessions(recordings, data, antenna), *_of_sources(recordings, data, antenna)]
    return tuple(one for one in found if one.columns.any())


def terms_of_sessions(at: Circumstances) -> dict[str, tuple[Array, Array]]:
    """Return what sessions may depart in: term -> both axes for departures of one, (n, k) each."""
    none, one = np.zeros((len(at), 1)), np.ones((len(at), 1))
    across, along = at.mount.names
    return {
        f"zero in {across}": (one, none),
        f"zero in {along}": (none, one),
        f"tilt of the {at.mount.fixed}": CATALOGUE["tilt"].columns(at),
        "sag": CATALOGUE["sag_cosine"].columns(at),
    }


def terms_of_sources(at: Circumstances) -> dict[str, tuple[Array, Array]]:
    """Return what sources may depart in: term -> both axes for departures of one, (n, k) each.

    In place, or, where the sky's turn is not known, in both offsets.
    """
    with contextlib.suppress(MissingColumn):
        turned = [np.stack(at.along_axes(*one), axis=0) for one in parallactic(at)]
        if np.isfinite(np.stack(turned)).all():
            x, y = np.stack(turned, axis=-1)
            return {"place in the catalogue": (x, y)}
    none, one = np.zeros((len(at), 1)), np.ones((len(at), 1))
    across, along = at.mount.names
    return {f"offset in {across}": (one, none), f"offset in {along}": (none, one)}


def _of_sessions(recordings: Recordings, data: Stack, antenna: str) -> list[Departures]:
    of, night, labels = _nights(recordings)
    if len(labels) < SEVERAL:
        return []
    inside = night[data.row][:, None] == np.arange(len(labels))
    terms = terms_of_sessions(recordings.at)
    return [_departures(one, of, antenna, labels, inside, data, terms) for one in terms]


def _nights(recordings: Recordings) -> tuple[str, Codes, tuple[str, ...]]:
    """Return what stands for nights, for each row its number (n,), and the label of each.

    Sessions; where there is one, and the order of the rows is all that tells of time, stretches
    of about `ENOUGH` pointings, for nobody wrote down where a night ends.
    """
    session, names = group(recordings, ("session",))
    if len(names) > 1 or "order" not in recordings.at:
        return "session", session, tuple(name for (name,) in names)
    order = np.asarray(recordings.at.column("order")).argsort()
    begun = np.zeros(len(order), np.intp)
    begun[np.unique(pointings(recordings)[order], return_index=True)[1]] = 1
    place = np.empty(len(order), np.intp)
    place[order] = np.cumsum(begun) - 1
    there = int(begun.sum())
    count = max(1, round(there / ENOUGH))
    stretch = place * count // there
    rows = [np.flatnonzero(stretch[order] == one) + 1 for one in range(count)]
    return "stretch", stretch, tuple(f"rows {one[0]} to {one[-1]}" for one in rows)


def _of_sources(recordings: Recordings, data: Stack, antenna: str) -> list[Departures]:
    source, names = group(recordings, ("source",))
    number = pointings(recordings)
    there = len(np.unique(number))
    if len(names) < SEVERAL or there < PER_SOURCE * len(names):
        return []
    pairs = np.unique(np.stack([source, number]), axis=1)[0]
    again = np.flatnonzero(np.bincount(pairs, minlength=len(names)) > 1)
    if len(again) < SEVERAL:
        return []
    inside = source[data.row][:, None] == again
    labels = tuple(names[one][0] for one in again)
    terms = terms_of_sources(recordings.at)
    return [_departures(one, "source", antenna, labels, inside, data, terms) for one in terms]


def _departures(
    term: str,
    of: str,
    antenna: str,
    labels: tuple[str, ...],
    inside: NDArray[np.bool_],
    data: Stack,
    terms: Mapping[str, tuple[Array, Array]],
) -> Departures:
    """Return the departures of some labels in a term; `inside` (m, labels) says whose is whose."""
    columns = data.spread(*terms[term]).T
    return Departures(
        term,
        of,
        antenna,
        labels * len(columns),
        np.concatenate([inside * column[:, None] for column in columns], axis=1),
    )


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
        root = np.sqrt(variances[self.kind[active]])
        inverse = _inverse(triangle)
        taken = root * (inverse @ (root * self.moments[active]))
        across = self.products[np.ix_(active, idle)]
        weighed = inverse @ (root[:, None] * across)
        own = (np.eye(len(active)) - inverse) / root / root[:, None]
        between = weighed / root[:, None]
        others = self.products[np.ix_(idle, idle)] - weighed.T @ (root[:, None] * across)
        seen, power = np.empty(len(self.kind)), np.empty(len(self.kind))
        seen[active], seen[idle] = taken / root**2, self.moments[idle] - across.T @ taken
        power[active], power[idle] = np.diag(own), np.diag(others)
        left = self.misfit - float(self.moments[active] @ taken)
        scale = max(left, EXACT) / self.dof
        count = len(variances)
        gradient = np.asarray(np.bincount(self.kind, power - seen**2 / scale, count), float)
        curvature = _by_kind(own, self.kind[active], self.kind[active], count)
        crossed = _by_kind(between, self.kind[active], self.kind[idle], count)
        curvature += crossed + crossed.T + _by_kind(others, self.kind[idle], self.kind[idle], count)
        return gradient, curvature


def _by_kind(values: Array, one: Codes, other: Codes, count: int) -> Array:
    """Return the sums of squares of values (a, b) over the kinds of rows (a,) and columns (b,)."""
    kinds = np.arange(count)
    of_rows, of_columns = ((kind[:, None] == kinds).astype(float) for kind in (one, other))
    return np.asarray(of_rows.T @ (values**2 @ of_columns))


def _inverse(triangle: Array) -> Array:
    """Return the inverse of L L' from its lower triangle L."""
    if not len(triangle):
        return triangle
    upper = dpotri(triangle.T)[0]
    return np.asarray(np.triu(upper) + np.triu(upper, 1).T)


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
        Of the readings, without any departures.
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
    variances = _fitted(projected, len(some))
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


def _fitted(projected: _Projected, count: int) -> Array:
    """Return the variances of the greatest restricted likelihood, none below zero.

    Fisher scoring from small variances; what would go below zero stays there.
    """
    power = np.bincount(projected.kind, np.diag(projected.products), count)
    many = np.bincount(projected.kind, minlength=count)
    variances = np.where(power > 0, many / np.maximum(power, 1e-300), 0.0)
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
