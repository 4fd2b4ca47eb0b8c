"""The covariance of all readings, and whitening under it.

Per series (one antenna, one axis): white scatter and drift. Across both axes of an antenna: what
moves them together from pointing to pointing. Across all readings of an antenna: departures of
sessions and of sources, which are random effects.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
from pyport.least_squares.gram import AT_A_TIME, in_place
from pyport.noise.series import Departures, Noise, Possible, Series
from pyport.noise.whitening import Whitening, whitening
from pyport.thresholds import OUTLIER_WEIGHT

#: A direction of the departures that adds less than this share to the variance is left out.
NEGLIGIBLE = 1e-4


@dataclass(frozen=True)
class Covariance:
    """The covariance of all m readings.

    Attributes
    ----------
    parts, noises
        The series, and the noise of each.
    weights
        Robust weights of the readings, shape (m,): one for an ordinary one, near zero for outliers.
    precision
        Relative precision of the readings, shape (m,): one where the scatter is usual.
    departures
        Random effects with a variance above zero.
    starts
        The likeliest drift of each series, for whoever estimates another one like it.
    coupling
        Correlation of both axes' scatter from pointing to pointing, by antenna.
    possible
        All departures that were possible, None where nobody asked.
    """

    parts: tuple[Series, ...]
    noises: tuple[Noise, ...]
    weights: Array
    precision: Array
    departures: tuple[Departures, ...] = ()
    starts: tuple[int | None, ...] = ()
    coupling: dict[str, float] = field(default_factory=dict)
    possible: Possible | None = field(default=None, repr=False)

    def whiten(self, columns: Array) -> Array:
        """Return columns of unit scatter.

        Parameters
        ----------
        columns
            Shape (m, K).

        Returns
        -------
        Array
            Shape (M, K), M being m or 2 m: for each reading its deviation from its pointing's
            mean, which nobody needs where all stand alone, and the pointing's mean at its first
            reading, zero elsewhere. Sums of products over all rows are what generalised least
            squares needs; labels of the rows are `np.resize` of the readings'.
        """
        return self._without_departures(self._within_axes(columns))

    def products(self, columns: Array) -> Array:
        """Return the products of `whiten(columns)`, (K, K), without these where it can be."""
        known, shared, gram = self._beside_departures(columns)
        return np.asarray(gram - shared.T @ np.linalg.solve(known, shared))

    def _beside_departures(self, columns: Array) -> tuple[Array, Array, Array]:
        """Return 1 + Z'Z, Z'C and C'C of what departs, Z, and columns C (m, K): whitened."""
        sizes = self._possible.sizes(self.departures)
        gram, _ = self.products_beside(self._possible, sizes, columns)
        own, other = np.flatnonzero(sizes), np.arange(len(sizes), len(gram))
        known = np.eye(len(own)) + gram[np.ix_(own, own)]
        return known, gram[np.ix_(own, other)], gram[np.ix_(other, other)]

    @cached_property
    def _possible(self) -> Possible:
        return self.possible or Possible(self.departures, self.parts)

    def products_beside(
        self, possible: Possible, sizes: Array, columns: Array
    ) -> tuple[Array, int]:
        """Return whitened products of departures and of columns (m, p), nothing departing.

        And how many readings there are. Series whose readings stand alone, in axes that are
        not coupled, are gone through without the zeros of what departs; `sizes` (q,) are what
        those columns are multiplied by.
        """
        q = len(sizes)
        gram, used = np.zeros((q + columns.shape[1],) * 2), 0
        for one, few in zip(self._whitenings, possible.few, strict=True):
            rows = one.part.rows
            there = np.flatnonzero(columns[rows].any(axis=0))
            given = few.scaled(sizes).beside(columns[np.ix_(rows, there)])
            found = None if self.coupling else one.products(given)
            if found is None or not np.isfinite(np.diag(found)).all():
                break
            places = np.concatenate([np.flatnonzero((sizes != 0) & few.there), q + there])
            gram[np.ix_(places, places)] += found
            used += int(np.count_nonzero(given.full.any(axis=1) | (np.diff(given.starts) > 0)))
        else:
            return gram, used
        every = np.concatenate([possible.columns * sizes, columns], axis=1)
        white = np.nan_to_num(self._within_axes(every))
        # Not the rows of `white`: a lone reading is its pointing's mean but for rounding.
        return white.T @ white, int(np.count_nonzero(every.any(axis=1)))

    def unwhiten(self, white: Array) -> Array:
        """Return the transpose of `whiten`, applied to columns (M, K): shape (m, K).

        Of whitened columns it makes the inverse covariance times the columns.
        """
        out = self._without_departures(white.copy())
        start = self.means.start
        for x, y, correlation in self._coupled:
            rows = start + y
            out[rows] /= np.sqrt(1 - correlation**2)
            out[start + x] -= correlation * out[rows]
        columns = np.zeros((len(self.weights), white.shape[1]))
        for one in self._whitenings:
            rows = one.part.rows
            columns[rows] = one.unwhiten(out[start + one.part.first], out[rows])
        return columns

    def errors(self, estimators: Array) -> tuple[Array, list[tuple[Array, float]]]:
        """Return rows (r, K) whose products are the covariance of linear estimators (m, K).

        An estimator is the weight of each reading in what is estimated. With it comes all that adds
        to their variances, (K,) each, and its degrees of freedom: white scatter, and each drift, of
        each series; departures of each term.
        """
        shares: list[tuple[Array, float]] = []
        start, rows = self.means.start, self.means.stop
        out = np.zeros((rows, estimators.shape[1]))
        for one in self._whitenings:
            part, noise, own = one.part, one.noise, estimators[one.part.rows]
            means, inside = one.errors(own)
            out[start + part.first] = means
            if inside is not None:
                out[part.rows] = inside
            whole = white = _variance(means, inside)
            if noise.drifts:
                still = replace(one, noise=replace(noise, drifts=()))
                white = _variance(*still.errors(own))
            shares.append((white, noise.dof))
            drifting = np.maximum(whole - white, 0.0)
            shares += [
                (drifting * (amplitude / noise.drift) ** 2, part.turns(memory))
                for amplitude, memory in noise.drifts
            ]
        for x, y, correlation in self._coupled:
            out[start + x] += correlation * out[start + y]
            out[start + y] *= np.sqrt(1 - correlation**2)
        departing = [(one.columns * one.sigma).T @ estimators for one in self.departures]
        shares += [
            (_variance(rows), one.dof) for rows, one in zip(departing, self.departures, strict=True)
        ]
        return np.concatenate([out, *departing]), shares

    def _without_departures(self, out: Array) -> Array:
        """Take what departures do out of whitened columns (M, K), in place."""
        for rows, unit, inner, _ in self._departing:
            own = out[rows]
            along = inner @ (unit.T @ own)
            for low in range(0, len(own), AT_A_TIME):
                some = slice(low, low + AT_A_TIME)
                own[some] += unit[some] @ along
            if not isinstance(rows, slice):
                out[rows] = own
        return out

    def _within_axes(self, columns: Array) -> Array:
        """Whiten as if no session or source departed."""
        start = self.means.start
        out = np.zeros((self.means.stop, columns.shape[1]))
        for one in self._whitenings:
            if one.whiten_lone(columns, out[start:]):
                continue
            means, deviations = one.whiten(columns[one.part.rows])
            if deviations is not None:
                out[one.part.rows] = deviations
            out[start + one.part.first] = means
        for x, y, correlation in self._coupled:
            rows = start + y
            out[rows] = (out[rows] - correlation * out[start + x]) / np.sqrt(1 - correlation**2)
        return out

    @cached_property
    def _whitenings(self) -> tuple[Whitening, ...]:
        """Return what whitens each series."""
        return tuple(
            whitening(self.weights[part.rows], self.precision[part.rows], part, noise)
            for part, noise in zip(self.parts, self.noises, strict=True)
        )

    @cached_property
    def means(self) -> slice:
        """Return the whitened rows that hold pointings' means."""
        m = len(self.weights)
        alone = all(part.alone for part in self.parts)
        return slice(0, m) if alone else slice(m, 2 * m)

    @cached_property
    def _coupled(self) -> list[tuple[Codes, Codes, float]]:
        """Return for each antenna with coupled axes the first readings of its pointings in both."""
        return [
            (*both_axes(self.parts, antenna), correlation)
            for antenna, correlation in self.coupling.items()
        ]

    @cached_property
    def _departing(self) -> list[tuple[Codes | slice, Array, Array, Array]]:
        """Return for each antenna what departures ask for: rows, Z, W and shrinkage h.

        With Z the whitened columns times their standard deviations and Z Z' = U s^2 U', the
        inverse root of 1 + Z Z' is 1 + U h U', h = 1 / sqrt(1 + s^2) - 1. Of Z' Z = V s^2 V'
        follows U = Z V / s, so that it is 1 + Z W Z', W = V h / s^2 V'.
        """
        found = []
        for antenna in dict.fromkeys(one.antenna for one in self.departures):
            unit = self._within_axes(
                np.concatenate(
                    [one.columns * one.sigma for one in self.departures if one.antenna == antenna],
                    axis=1,
                )
            )
            rows = in_place(np.flatnonzero(unit.any(axis=1)))
            unit = unit[rows]
            power, vectors = np.linalg.eigh(unit.T @ unit)
            kept = power > NEGLIGIBLE
            power, vectors = power[kept], vectors[:, kept]
            shrinkage = 1 / np.sqrt(1 + power) - 1
            found.append((rows, unit, vectors * (shrinkage / power) @ vectors.T, shrinkage))
        return found

    def departed(self, residual: Array) -> Array:
        """Return what sessions and sources depart by, as residuals show it [rad], shape (m,).

        The best linear prediction (Robinson 1991, Statistical Science 6, 15): what few readings
        say is drawn toward zero, a session without any stays there.
        """
        return np.asarray(self._possible.columns @ self._departing_by(residual))

    def departed_by(self, residual: Array) -> list[Array]:
        """Return for each of `departures` what its labels depart by [rad], (numbers, labels)."""
        values, kind = self._departing_by(residual), self._possible.kind
        place = {one.whose: n for n, one in enumerate(self._possible.departures)}
        return [
            values[kind == place[one.whose]].reshape(-1, len(set(one.labels)))
            for one in self.departures
        ]

    def _departing_by(self, residual: Array) -> Array:
        """Return what each column of what possibly departs stands for [rad], shape (q,)."""
        sizes = self._possible.sizes(self.departures)
        values = np.zeros(len(sizes))
        if self.departures:
            known, shared, _ = self._beside_departures(residual[:, None])
            values[sizes != 0] = np.linalg.solve(known, shared)[:, 0]
        return sizes * values

    def drifted(self, residual: Array) -> Array:
        """Return what drifts have moved readings by, as residuals show it [rad], shape (m,).

        The best linear prediction, as of what departs.
        """
        pull = self.unwhiten(self.whiten(residual[:, None]))
        moved = (residual - self.departed(residual))[:, None]
        found = np.zeros(len(residual))
        for one in self._whitenings:
            rows = one.part.rows
            drift = one.means(moved[rows])[:, 0] - one.variance * (one.part.sums @ pull[rows])[:, 0]
            found[rows] = drift[one.part.pointing]
        return found

    @cached_property
    def log_determinant(self) -> float:
        """Return the logarithm of the covariance's determinant, that of replicates left out."""
        total = sum(one.log_determinant() for one in self._whitenings)
        for x, _, correlation in self._coupled:
            total += len(x) * float(np.log1p(-(correlation**2)))
        for *_, shrinkage in self._departing:
            total -= 2 * float(np.log1p(shrinkage).sum())
        return total

    @property
    def used(self) -> NDArray[np.bool_]:
        """Tell which readings are no outliers, shape (m,)."""
        return self.weights >= OUTLIER_WEIGHT

    @property
    def shown(self) -> tuple[Noise, ...]:
        """Return the noise of each series as it shows within the recordings."""
        pairs = zip(self.noises, self.parts, strict=True)
        return tuple(noise.about_mean(part.span) for noise, part in pairs)

    @cached_property
    def scatter(self) -> Array:
        """Return the scatter of each reading about the true curve, sessions' own apart [rad]."""
        floor = np.zeros(len(self.weights))
        for part, noise in zip(self.parts, self.noises, strict=True):
            white = (noise.within**2 + noise.between**2) / self.precision[part.rows]
            floor[part.rows] = np.sqrt(white + noise.drift**2)
        return floor

    @cached_property
    def floor(self) -> Array:
        """Return the scatter of each reading from pointing to pointing alone, tails apart [rad]."""
        floor = np.zeros(len(self.weights))
        for part, noise in zip(self.parts, self.noises, strict=True):
            white = np.hypot(noise.within, noise.between / noise.tail)
            floor[part.rows] = white / np.sqrt(self.precision[part.rows])
        return floor

    @property
    def dof(self) -> dict[str, float]:
        """Return for each antenna from how many deviations its scatter is known."""
        found: dict[str, float] = {}
        for part, noise in zip(self.parts, self.noises, strict=True):
            found[part.antenna] = found.get(part.antenna, 0.0) + noise.dof
        return found


def _variance(rows: Array, more: Array | None = None) -> Array:
    """Return the variances of linear estimators whose errors are some rows (r, K), shape (K,)."""
    found = (rows**2).sum(axis=0)
    return np.asarray(found if more is None else found + (more**2).sum(axis=0))


def both_axes(parts: Sequence[Series], antenna: str) -> tuple[Codes, Codes]:
    """Return the first readings in x and in y of the pointings that have both, shape (p,) each."""
    own = {part.is_y: part for part in parts if part.antenna == antenna}
    if len(own) < 2:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    _, x, y = np.intersect1d(own[False].number, own[True].number, return_indices=True)
    return own[False].first[x], own[True].first[y]
