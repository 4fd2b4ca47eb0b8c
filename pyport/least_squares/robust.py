"""Robust least squares: outliers lose their vote, and keep their place in the list."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pyport.angles import Array
from pyport.least_squares.gram import cholesky

#: Columns whose squared lengths differ by less than this share are equally different: the first
#: of them is picked, so that no rounding of one machine or another chooses.
TIE = 1e-6


def most_different(columns: Array, room: int, least: float) -> Array:
    """Return orthonormal directions, each of the column least like those before it.

    Gram and Schmidt with pivoting. The columns' products tell which to pick, so
    that they are read once and not once for each pick.

    `columns`: columns of about unit length, shape (n, k).
    `room`: no more directions than this.
    `least`: what must be left of a column's length for it to count as different.
    Returns shape (n, at most room).
    """
    room = min(room, *columns.shape)
    left = (columns**2).sum(axis=0)
    products = columns.T @ columns
    factor = np.zeros((room, columns.shape[1]))
    picks: list[int] = []
    for n in range(room):
        pick = int(np.argmax(left >= (1 - TIE) * left.max()))
        if left[pick] < least**2:
            break
        factor[n] = products[pick] - factor[:n, pick] @ factor[:n]
        factor[n] /= np.sqrt(left[pick])
        left = left - factor[n] ** 2
        picks.append(pick)
    return np.linalg.qr(columns[:, picks])[0]


class Refit:
    """A design and data, ready to be fitted with one set of weights after another.

    Parameters
    ----------
    columns, value
        The design (m, k) and the data (m,).
    """

    def __init__(self, columns: Array, value: Array):
        self.columns = columns
        self.value = value
        self.products = columns.T @ columns
        self.rank = columns.shape[1]
        if not _distinguished(self.products):
            self.rank = int(np.linalg.matrix_rank(columns)) if columns.size else 0

    def residual(self, weight: Array) -> Array:
        """Return what the weighted least-squares fit leaves of the data, shape (m,)."""
        columns, value = self.columns, self.value
        products = self._weighted(weight)
        if not _distinguished(products):
            root = np.sqrt(weight)
            solution = np.linalg.lstsq(columns * root[:, None], value * root, rcond=1e-9)[0]
        else:
            solution = np.linalg.solve(products, columns.T @ (weight * value))
        return np.asarray(value - columns @ solution)

    def _weighted(self, weight: Array) -> Array:
        """Return the products under weights; most are one, and only the others are gone through."""
        other = np.flatnonzero(weight != 1)
        if 2 * len(other) < len(weight):
            few = self.columns[other]
            return np.asarray(self.products - (few * (1 - weight[other])[:, None]).T @ few)
        root = self.columns * np.sqrt(weight)[:, None]
        return np.asarray(root.T @ root)


def _distinguished(products: Array) -> bool:
    """Tell whether products alone distinguish the columns."""
    length = np.sqrt(np.diag(products))
    return bool(np.all(length > 0)) and cholesky(products / np.outer(length, length)) is not None


#: A normal sample's median absolute deviation is this share of its sigma.
_MAD = 0.6744897501960817
_ROUNDS = 30
#: A design with more columns than one for so many readings bends to single ones of them.
MANY = 6


def median(values: Array) -> float:
    """Return the median of finite values, sooner than numpy's, which looks for NaN besides."""
    half = len(values) // 2
    parted = np.partition(values, half)
    middle = float(parted[half])
    return middle if len(values) % 2 else (float(parted[:half].max()) + middle) / 2


def scale(
    residual: Array,
    floor: float = 0.0,
    through: int = 0,
    middle: Callable[[Array], float] = median,
) -> float:
    """Return a robust sigma of residuals about zero, no smaller than `floor`.

    A robust fit of many columns goes right through as many readings, which say
    nothing of the scatter: the `through` smallest residuals are passed over.

    The median absolute deviation, refined once by the rms of what lies within
    three of it (times 1.0135, what a normal sample loses by the cut), so that
    rounded data whose median deviation is zero still have a scatter. `middle` finds the median.
    """
    if through:
        residual = np.sort(np.abs(residual))[through:]
    if len(residual) == 0:
        return floor
    size = np.abs(residual)
    first = max(middle(size) / _MAD, floor, 1e-300)
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
