"""Trials: what a candidate gains when it joins a model, and how much likelier it makes the data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.candidates import Candidate
from pyport.thresholds import VISIBLE

#: Prior variances that are tried, over the variance with which the best direction is known.
_STRENGTHS = np.geomspace(0.1, 1e9, 51)


@dataclass(frozen=True)
class CandidateFit:
    """What a candidate gains when it joins a model and the model is refitted.

    Attributes
    ----------
    candidate, scope
        What was tried, and for which blocks its coefficients are shared.
    gain
        Drop of the whitened sum of squares.
    dof
        Independent coefficients that it adds.
    delta_bic
        `gain` less what that many coefficients, and the choice among the members of a
        family, must earn (Chen & Chen 2008); above zero is worth having.
    evidence
        Twice the logarithm of how much likelier the data are with it, its coefficients drawn
        from one normal of the best width and the choice among its family paid for: what
        candidates are ranked by.
    noise_dof
        Deviations from which the scale of its noise is known.
    values
        Its coefficients, shape (P,).
    information
        Information on them with the model refitted, shape (P, P).
    drawn
        The same gain on each draw of the fitted noise, shape (draws,).
    """

    candidate: Candidate
    scope: str
    gain: float
    dof: int
    delta_bic: float
    evidence: float
    noise_dof: float
    values: Array
    information: Array
    drawn: Array

    @property
    def owed_to_scale(self) -> float:
        """Return what of its gain a scale of the noise that is known from few deviations owes.

        With n of them a gain g is worth n log(1 + g / n): Student's likelihood, not the normal one.
        Coefficients of single antennas gain little each beside their deviations.
        """
        if "antenna" in self.scope:
            return 0.0
        known = min(self.noise_dof, 1e6)
        return self.gain - float(known * np.log1p(self.gain / known))


def at_best(power: Array, along: Array) -> tuple[float, float]:
    """Return twice the log of the evidence at the best prior variance, and that variance.

    `power` (K,) holds the information on independent directions of equal prior
    variance, `along` (K,) the products with the data.
    """
    evidence, variance = each_at_best(power[None], along[None])
    return float(evidence[0]), float(variance[0])


def of_equal_prior(information: Array, moments: Array) -> tuple[float, float]:
    """Return what `at_best` does of columns whose coefficients have equal prior variance.

    `information` (k, k) holds the columns' products and `moments` (k,) those with the data, the
    model projected out of both.
    """
    power, vectors = np.linalg.eigh(information)
    return at_best(np.maximum(power, 0.0), vectors.T @ moments)


def each_at_best(power: Array, along: Array) -> tuple[Array, Array]:
    """Return what `at_best` does of each of n sets of directions, (n, K): shape (n,) each.

    Directions without information and products count for nothing.
    """
    variance = _STRENGTHS / np.maximum(power.max(axis=1, initial=0.0), 1e-150)[:, None]
    size, power, along = variance[:, :, None], power[:, None], along[:, None]
    evidence = (size * along**2 / (1 + size * power) - np.log1p(size * power)).sum(axis=2)
    best = np.arange(len(evidence)), np.argmax(evidence, axis=1)
    return evidence[best], variance[best]


def units(length: Array, precision: Array | float = 0.0) -> Array:
    """Return what each column is divided by for all coefficients to have equal precision, (k,).

    Its length (k,), so that its unit does not matter, or by what is known of its coefficient: the
    root of its `precision` (k,). Infinite where a column is empty.
    """
    return np.where(precision, np.sqrt(precision), np.where(length > 0, length, np.inf))


def shown(
    columns: Array, length: Array, data: Array, precision: Array | float = 0.0
) -> tuple[Array, Array]:
    """Return the information on independent directions of columns, and their products with data.

    Parameters
    ----------
    columns, data
        Whitened columns (n, k) and data (n,), the model projected out of both.
    length
        How long the columns were before, shape (k,): what the model draws all of shows nothing.
    precision
        What is known of their coefficients beforehand, shape (k,), up to a factor.
    """
    unit = columns / units(length, precision)
    return shown_of(unit.T @ unit, unit.T @ data)


def shown_of(information: Array, moments: Array) -> tuple[Array, Array]:
    """Return what `shown` does, of products of columns of unit length: (k, k) and (k,)."""
    power, vectors = np.linalg.eigh(information)
    good = power > VISIBLE**2 * max(1.0, float(power[-1]))
    return power[good], vectors[:, good].T @ moments
