"""Combinations of coefficients: what data know when they do not know each coefficient alone.

Columns that are nearly sums of one another leave directions in the space of their coefficients
that the data hardly see. A coefficient along such a direction is any number; across it the same
coefficients are known well. Belsley, Kuh & Welsch 1980, Regression Diagnostics, ch. 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, Array, decimals
from pyport.effects.base import Coefficient
from pyport.effects.empirical.drivers import unit_in_words
from pyport.fitting.fit import Fit, expanded
from pyport.fitting.soundness import largest_offset, named

#: A coefficient of whose column the other columns leave less than this share of the rms is not
#: known alone: an error of a tenth of the others' curves is an error of itself as a whole.
HIDDEN = 0.1
#: A direction hides a coefficient to that degree only if its eigenvalue is below the square.
NEAR_NULL = HIDDEN**2
#: Variance inflation from which a coefficient shares in what hides another (Marquardt 1970,
#: Technometrics 12, 591).
INFLATED = 10.0
#: Share of a coefficient's variance that those directions must make up (Belsley et al., p. 112).
PROPORTION = 0.5
#: Coefficients whose parts in the hidden directions overlap by less than this do not belong
#: together: three of one axis and two of another are two combinations.
OVERLAP = 0.02
#: So many directions are put into a sentence; reports hold them all.
MOST_DIRECTIONS = 2
#: How a weight is spelt whose coefficient has a plain unit.
_PER = {"arcsec": "", "": " arcsec"} | {one: f" arcsec/{one}" for one in ("s", "deg", "K", "h")}
#: Eigenvalues below this, beside the largest, are rounding.
ROUNDING = 1e-10
#: With more coefficients than this nobody reads combinations.
MOST_COEFFICIENTS = 1500


@dataclass(frozen=True)
class Direction:
    """A weighted sum of coefficients that the data know.

    `weights` are those of the coefficients in their internal units; `value` and `sigma` [rad]
    are those of the sum, which is about the rms of what the sum adds to the offsets.
    """

    weights: tuple[float, ...]
    value: float
    sigma: float


@dataclass(frozen=True)
class Combination:
    """Coefficients of which these data know combinations only."""

    places: tuple[int, ...]  #: of the coefficients among all
    #: `names`, `coefficients`: what they are called, and what they are.
    names: tuple[str, ...]
    coefficients: tuple[Coefficient, ...]
    #: Share of the rms of each one's column that the other columns leave.
    visible: tuple[float, ...]
    #: The combinations that the data know, first the one that adds most to the offsets.
    known: tuple[Direction, ...]

    @property
    def sentence(self) -> str:
        """Return what is known of the coefficients, and that none is known alone."""
        names = [one.replace("_", " ") for one in self.names]
        listed = f"{', '.join(names[:-1])} and {names[-1]}"
        if not self.known:
            return f"{listed} cannot be distinguished here, and no combination of them is known"
        sums = [f"{self.formula(one)} = {amount(one)}" for one in self.known[:MOST_DIRECTIONS]]
        return f"{listed} are known in combination only: {', and '.join(sums)}"

    def formula(self, one: Direction) -> str:
        """Return a direction as a sum, with arcsec for a unit of each coefficient."""
        terms = []
        for name, coefficient, weight in zip(
            self.names, self.coefficients, one.weights, strict=True
        ):
            of_unit = weight * coefficient.scale / ARCSEC
            unit = _PER.get(coefficient.unit, f" arcsec/({unit_in_words(coefficient.unit)})")
            sign = "-" if of_unit < 0 else "+"
            terms.append(f"{sign} {abs(of_unit):.3g}{unit} {name}")
        return " ".join(terms).removeprefix("+ ")

    def as_json(self) -> dict[str, Any]:
        """Return it as reports spell it."""
        return {
            "coefficients": list(self.names),
            "visible_share": list(self.visible),
            "sentence": self.sentence,
            "known": [
                {
                    "formula": self.formula(one),
                    "weights_arcsec_per_unit": [
                        weight * c.scale / ARCSEC
                        for weight, c in zip(one.weights, self.coefficients, strict=True)
                    ],
                    "value_arcsec": one.value / ARCSEC,
                    "sigma_arcsec": one.sigma / ARCSEC,
                }
                for one in self.known
            ],
        }


def amount(one: Direction) -> str:
    """Return a direction's value with its error, the digits that the error allows."""
    value, sigma = one.value / ARCSEC, one.sigma / ARCSEC
    digits = decimals(sigma, 3)
    return f"{value:.{digits}f} +- {sigma:.{digits}f} arcsec"


def combinations(
    names: Sequence[str],
    coefficients: Sequence[Coefficient],
    columns: Array,
    values: Array,
    covariance: Array,
    largest: float = np.inf,
) -> tuple[Combination, ...]:
    """Return the combinations that data know where they do not know coefficients alone.

    `names`, `coefficients`: what the P coefficients are called, and what they are.
    `columns`: what one unit of each adds to each number, (m, P).
    `values`, `covariance`: coefficients (P,) and their covariance (P, P), internal units;
      pseudo-inverse where the columns do not determine all.
    `largest`: the largest offset in the data [rad]: what comes out bigger is not known.
    """
    if not 1 < columns.shape[1] <= MOST_COEFFICIENTS:
        return ()
    length, eigenvalues, vectors = _spectrum(columns)
    near = eigenvalues < NEAR_NULL
    if not near.any():
        return ()
    visible = _visible(eigenvalues, vectors)
    unseen = vectors[:, near]
    parts = (unseen**2 / np.maximum(eigenvalues[near], ROUNDING * eigenvalues[-1])).sum(axis=1)
    inflation = visible**-2.0
    shares = (visible**2 < 1 / INFLATED) & (parts >= PROPORTION * inflation) & (length > 0)
    found = []
    for places in _together(unseen, np.flatnonzero(shares)):
        if len(places) < 2 or visible[places].min() >= HIDDEN:
            continue
        size = length[places] / np.sqrt(np.any(columns[:, places] != 0, axis=1).sum())
        seen = _seen(eigenvalues, vectors, places)
        known = _known(seen, size, values[places], covariance[np.ix_(places, places)])
        found.append(
            Combination(
                tuple(places.tolist()),
                tuple(names[n] for n in places),
                tuple(coefficients[n] for n in places),
                tuple(visible[places].tolist()),
                tuple(one for one in known if max(abs(one.value), one.sigma) <= largest),
            )
        )
    return tuple(found)


def of_fit(fit: Fit) -> tuple[Combination, ...]:
    """Return the combinations that a fit knows where it does not know coefficients alone."""
    names = [name for name, _, _ in named(fit)]
    coefficients = [each for one in fit.coefficients for each in one.term.effect.coefficients]
    given = [each for one in fit.coefficients for each in one.term.given(one.labels)]
    terms = [*{id(one.term): one.term for one in fit.coefficients}.values()]
    design = expanded(fit.recordings, fit.stack, terms)[0]
    largest = largest_offset(fit.stack, fit.recordings.at)
    value = fit.shortest + np.array(given)
    return combinations(names, coefficients, design, value, fit.covariance, largest)


def _spectrum(columns: Array) -> tuple[Array, Array, Array]:
    """Return the columns' lengths (P,), and the spectrum of their products at unit length."""
    length = np.linalg.norm(columns, axis=0)
    unit = np.divide(columns, length, out=np.zeros_like(columns), where=length > 0)
    eigenvalues, vectors = np.linalg.eigh(unit.T @ unit)
    return length, np.maximum(eigenvalues, 0.0), vectors


def _visible(eigenvalues: Array, vectors: Array) -> Array:
    """Return what the others leave of each column's rms, shape (P,): inflation's inverse root."""
    floor = ROUNDING * max(1.0, float(eigenvalues.max(initial=1.0)))
    inflation = (vectors**2 / np.maximum(eigenvalues, floor)).sum(axis=1)
    return np.asarray(1 / np.sqrt(inflation), float)


def _together(unseen: Array, places: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """Return the places that share directions which the data hardly see."""
    overlap = np.abs(unseen[places] @ unseen[places].T) > OVERLAP
    left = set(range(len(places)))
    groups = []
    while left:
        whole, new = set(), {min(left)}
        while new:
            whole |= new
            new = {int(n) for one in new for n in np.flatnonzero(overlap[one])} - whole
        left -= whole
        groups.append(places[sorted(whole)])
    return groups


def _seen(eigenvalues: Array, vectors: Array, places: NDArray[np.intp]) -> Array:
    """Return the products of some unit columns with all others projected out, shape (n, n)."""
    floor = ROUNDING * max(1.0, float(eigenvalues.max(initial=1.0)))
    inverse = (vectors[places] / np.maximum(eigenvalues, floor)) @ vectors[places].T
    return np.asarray(np.linalg.inv(inverse), float)


def _known(seen: Array, size: Array, values: Array, covariance: Array) -> tuple[Direction, ...]:
    """Return the directions that are seen, first the one that adds most to the offsets.

    `seen` (n, n) holds the products of the unit columns beside all others, `size` (n,) the rms
    of the columns.
    """
    power, directions = np.linalg.eigh(seen)
    found = []
    for n in np.flatnonzero(power >= NEAR_NULL)[::-1]:
        direction = directions[:, n]
        weights = size * direction / direction[np.argmax(np.abs(direction))]
        sigma = float(np.sqrt(max(float(weights @ covariance @ weights), 0.0)))
        found.append(Direction(tuple(weights.tolist()), float(weights @ values), sigma))
    return tuple(found)
