"""Robust least squares: outliers lose their vote, and keep their place in the list."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pyport.angles import Array
from pyport.least_squares.refit import Refit

#: A normal sample's median absolute deviation is this share of its sigma.
_MAD = 0.6744897501960817
_ROUNDS = 30
#: A design with more columns than one for so many readings bends to single ones of them.
MANY = 6


def scale(residual: Array, floor: float = 0.0, through: int = 0) -> float:
    """Return a robust sigma of residuals about zero, no smaller than `floor`.

    A robust fit of many columns goes right through as many readings, which say
    nothing of the scatter: the `through` smallest residuals are passed over.

    The median absolute deviation, refined once by the rms of what lies within
    three of it (times 1.0135, what a normal sample loses by the cut), so that
    rounded data whose median deviation is zero still have a scatter.
    """
    if through:
        residual = np.sort(np.abs(residual))[through:]
    if len(residual) == 0:
        return floor
    size = np.abs(residual)
    first = max(float(np.median(size)) / _MAD, floor, 1e-300)
    kept = size[size <= 3 * first]
    refined = 1.0135 * float(np.sqrt(kept @ kept / len(kept))) if len(kept) else first
    return max(refined, floor)


def biweight(residual: Array, sigma: float, reach: float) -> Array:
    """Return Tukey's weights: one at zero, zero beyond `reach` sigmas."""
    u = np.clip(np.abs(residual) / (reach * max(sigma, 1e-300)), 0, 1)
    return (1 - u**2) ** 2


class Weights(NamedTuple):
    """Robust weights (m,) of a linear fit, its residuals (m,), and whether they came to rest."""

    weight: Array
    residual: Array
    settled: bool


def weights(columns: Array, value: Array, reach: float, floor: float = 0.0) -> Weights:
    """Return robust weights of a linear fit and its residuals.

    It starts from least absolute deviations, which outliers cannot drag, and
    ends with the biweight; the weights are flat (one) inside the bulk's three
    sigmas so that ordinary noise is not thinned.

    `columns`, `value`: the design (m, K) and the data (m,).
    `reach`: sigmas beyond which a reading has no weight.
    `floor`: the smallest sigma to believe, in the units of `value`.
    """
    if len(value) == 0:
        return Weights(np.ones(0), value, settled=True)
    residual = value - np.median(value)
    weight = np.ones(len(value))
    refit = Refit(columns, value)
    spare = max(1, len(value) - refit.rank)
    settled = False
    for turn in range(_ROUNDS):
        residual = refit.residual(weight)
        if refit.rank * MANY > len(value):
            sigma = max(scale(residual, floor, len(value) - spare), 1e-300)
        else:
            sigma = max(scale(residual, floor) * np.sqrt(len(value) / spare), 1e-300)
        if turn < _ROUNDS // 2:
            new = 1 / np.maximum(np.abs(residual) / sigma, 0.1)
        else:
            new = flat_weight(residual, sigma, reach)
        if turn > _ROUNDS // 2 and np.allclose(new, weight, atol=1e-3):
            settled = True
            break
        weight = new
    return Weights(flat_weight(residual, sigma, reach), residual, settled)


def flat_weight(residual: Array, sigma: float, reach: float) -> Array:
    """Return one up to three sigmas, from there the biweight down to zero at `reach`."""
    beyond = np.maximum(np.abs(residual) - 3 * sigma, 0.0)
    return biweight(beyond, sigma, reach - 3)


def rounding(value: Array) -> float:
    """Return the scatter that rounding to the recorded digits makes, 0 where no step shows.

    The smallest step between distinct values over the square root of twelve:
    no noise smaller than that is believed.
    """
    distinct = np.unique(value)
    if len(distinct) < 2 or len(distinct) > 0.8 * len(value):
        return 0.0
    gaps = np.diff(distinct)
    gaps = gaps[gaps > 1e-12]
    return float(gaps.min()) / np.sqrt(12) if len(gaps) else 0.0
