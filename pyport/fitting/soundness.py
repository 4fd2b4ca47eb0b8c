"""Whether a fit's numbers can be trusted: what every fit of this program says of itself."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pyport.angles import Array

#: Belsley, Kuh & Welsch 1980, Regression Diagnostics: moderate to strong dependencies above 30.
ILL_POSED = 30.0
#: What rounding may make of an eigenvalue of zero, beside the largest.
ROUNDING = 1e-8


def doubts(
    *, condition: float, covariance: Array, numbers: int, rank: int, settled: bool = True
) -> Iterator[str]:
    """Yield a sentence for everything that is wrong with a fit as a whole.

    `condition`: condition number of the design, columns scaled to unit length.
    `covariance`: of the coefficients that the data determine, shape (P, P).
    `numbers`: measured numbers that count: those of some weight.
    `rank`: independent coefficients.
    `settled`: whether the weights of a robust fit came to rest.
    """
    if not settled:
        yield "the fit did not converge: its weights still change with every round"
    if numbers < rank:
        yield f"{numbers} offsets that count cannot determine {rank} coefficients"
    elif numbers == rank:
        yield (
            f"{numbers} offsets that count for {rank} coefficients: the curve goes through all of "
            "them, and the errors say nothing"
        )
    if not positive(covariance):
        yield "the covariance is not positive: some errors and correlations mean nothing"
    if condition > ILL_POSED:
        yield (
            f"the condition number {condition:.3g} is above {ILL_POSED:g}: "
            "these directions do not distinguish all terms well"
        )


def positive(covariance: Array) -> bool:
    """Tell whether a matrix can be a covariance: finite, and no combination has a square below 0.

    A coefficient without error, its row and column zero, is left out.
    """
    if not np.isfinite(covariance).all():
        return False
    variance = np.diag(covariance)
    if np.any(variance < 0):
        return False
    there = variance > 0
    if np.any(covariance[~there] != 0):
        return False
    sigma = np.sqrt(variance[there])
    if len(sigma) == 0:
        return True
    eigenvalues = np.linalg.eigvalsh(covariance[np.ix_(there, there)] / np.outer(sigma, sigma))
    return bool(eigenvalues[0] > -ROUNDING * eigenvalues[-1])
