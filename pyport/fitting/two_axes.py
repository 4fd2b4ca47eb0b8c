"""One effect seen twice: whether its coefficients come out alike from either part of the data.

What leans or turns a telescope acts on cross-elevation and elevation at once, in a
ratio that geometry fixes. Each axis alone then gives the coefficients, and the two must
agree; where they do not, the effect is not what moves the telescope, or not all of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.least_squares.gram import inverted

#: Axes that agree differ so much with less than this chance, over all effects of a model.
UNLIKELY = 0.01


@dataclass(frozen=True)
class Difference:
    """An effect's coefficients from one part of the data and from another, in internal units."""

    #: Which of the coefficients are compared: those that either part determines, shape (k,).
    of: NDArray[np.intp]
    #: `first`, `second`: their values from each part, shape (k,).
    first: Array
    second: Array
    #: `sigma_first`, `sigma_second`: one-sigma errors of those, shape (k,).
    sigma_first: Array
    sigma_second: Array
    chi2: float  #: square of their difference in units of its covariance
    p_value: float  #: chance of differing so much or more when both are one

    @property
    def sigmas(self) -> float:
        """Return how far apart they are: the deviation of a normal that is as unlikely."""
        return as_unlikely(self.p_value)


def as_unlikely(chance: float) -> float:
    """Return the deviation [sigma] beyond which a normal lies, on either side, with a chance."""
    from scipy.special import ndtri

    return float(-ndtri(max(chance, 1e-300) / 2))


def difference(
    others: Array, first: Array, second: Array, data: Array, dof: float = np.inf
) -> Difference | None:
    """Compare what two parts of the data say of an effect, everything else fitted to all.

    `others`: columns of unit scatter of everything else in the model, shape (m, p).
    `first`, `second`: those of the effect as it acts on one part and on the other, shape (m, k)
      each.
    `data`: the offsets, of unit scatter, shape (m,).
    `dof`: deviations from which the scatter is known.
    Returns `Difference | None`: none where no coefficient is determined by either part alone. More
      scatter than unity widens the errors; less does not narrow them.
    """
    columns = np.concatenate([others, first, second], axis=1)
    rows = int(np.count_nonzero(data))
    normal, moments = columns.T @ columns, columns.T @ data
    return from_products(normal, moments, float(data @ data), first.shape[1], rows, dof)


def from_products(
    normal: Array, moments: Array, total: float, k: int, rows: int, dof: float = np.inf
) -> Difference | None:
    """Return what `difference` does, from the products of its columns.

    `normal`, `moments`, `total`: products of all columns, those of both parts last, shape (p + 2 k,
      p + 2 k); their products with the data; the data's square.
    `k`: how many coefficients are compared.
    `rows`: how many data there are.
    `dof`: deviations from which the scatter is known.
    """
    inverse, rank, _, known = inverted(normal)
    there = known[-2 * k : -k] & known[-k:]
    if not there.any():
        return None
    if not there.all():
        joined = _joined(len(normal), k, there)
        fewer = joined.T @ normal @ joined, joined.T @ moments
        found = from_products(*fewer, total, int(there.sum()), rows, dof)
        return found and replace(found, of=np.flatnonzero(there)[found.of])
    values = inverse @ moments
    spare = max(1, rows - rank)
    left = max(total - float(moments @ values), 0.0)
    covariance = inverse[-2 * k :, -2 * k :] * max(1.0, left / spare)
    chi2 = _chi2(values[-2 * k :], covariance)
    sigma = np.sqrt(np.diag(covariance))
    chance = _chance(chi2, k, min(dof, spare))
    return Difference(
        np.arange(k), values[-2 * k : -k], values[-k:], sigma[:k], sigma[k:], chi2, chance
    )


def _joined(size: int, k: int, there: NDArray[np.bool_]) -> Array:
    """Return what makes one column for both parts of every coefficient that is not `there`."""
    whole = np.eye(size)
    first, second = whole[:, -2 * k : -k], whole[:, -k:]
    both = (first + second)[:, ~there]
    return np.concatenate([whole[:, : -2 * k], both, first[:, there], second[:, there]], axis=1)


def _chi2(values: Array, covariance: Array) -> float:
    """Return the squared difference of two halves of some values (2k,) over its covariance."""
    k = len(values) // 2
    apart = values[:k] - values[k:]
    own = covariance[:k, :k] + covariance[k:, k:] - covariance[:k, k:] - covariance[k:, :k]
    return float(apart @ inverted(own)[0] @ apart)


def _chance(chi2: float, k: int, dof: float) -> float:
    """Return the chance of so large a square of `k` differences, the scatter known from `dof`."""
    from scipy.special import chdtrc, fdtrc

    if not np.isfinite(dof) or dof > 1e6:
        return float(chdtrc(k, chi2))
    return float(fdtrc(k, dof, chi2 / k))
