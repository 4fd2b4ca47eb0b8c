"""Distance between answers: units in the last place of a REAL, steps of an INTEGER."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Distance between answers of different kinds: NaN and a number, infinite and finite, two texts.
UNLIKE = np.iinfo(np.int64).max

#: The greatest distance between two numbers that is counted.
FARTHEST = UNLIKE - 1

_INTEGERS: dict[int, type[np.signedinteger]] = {4: np.int32, 8: np.int64}


def ordinal(values: NDArray[np.floating]) -> NDArray[np.int64]:
    """Return the rank of each REAL*4 or REAL*8: neighbours differ by one, -0.0 and 0.0 too.

    `values`: float32 or float64 numbers, no NaN, any shape.
    """
    integer = _INTEGERS[values.dtype.itemsize]
    bits = np.ascontiguousarray(values).view(integer).reshape(values.shape).astype(np.int64)
    return np.where(bits < 0, -(bits & np.iinfo(integer).max) - 1, bits)


def ulps(expected: ArrayLike, actual: ArrayLike) -> NDArray[np.int64]:
    """Return how many REAL numbers apart two arrays are, element by element.

    REAL*8 where `expected` is float64, else REAL*4. Any NaN equals any other: IEEE 754 promises
    neither sign nor payload. A NaN and a number are ``UNLIKE``, so are infinity and a finite
    number.
    """
    real = np.float64 if getattr(expected, "dtype", None) == np.float64 else np.float32
    expected, actual = np.asarray(expected, real), np.asarray(actual, real)
    low, high = ordinal(expected), ordinal(actual)
    with np.errstate(over="ignore"):
        distance = np.abs(low - high)
    # REAL*8 of opposite signs may be farther apart than an INTEGER*8 counts
    distance = np.where(np.abs(low.astype(float) - high) >= 2.0**63, FARTHEST, distance)
    unlike = (np.isnan(expected) != np.isnan(actual)) | (np.isinf(expected) != np.isinf(actual))
    unlike |= np.isinf(expected) & np.isinf(actual) & (expected != actual)
    distance = np.where(unlike, UNLIKE, distance)
    return np.where(np.isnan(expected) & np.isnan(actual), 0, distance)


def distances(expected: NDArray, actual: NDArray) -> NDArray[np.int64]:
    """Return the distance of each pair of answers of any kind, the kind being that of `expected`.

    REAL in ulp, INTEGER in steps; LOGICAL and CHARACTER are equal or ``UNLIKE``.
    """
    if expected.dtype.kind == "f":
        return ulps(expected, actual)
    if expected.dtype.kind == "i":
        apart = np.abs(expected.astype(float) - actual.astype(float))
        with np.errstate(over="ignore"):
            exact = np.abs(expected.astype(np.int64) - actual.astype(np.int64))
        return np.where(apart >= 2.0**63, FARTHEST, exact)
    return np.where(expected == actual, 0, UNLIKE)


def neighbour(values: NDArray[np.floating], side: float) -> NDArray[np.floating]:
    """Return the next number of the same kind towards `side`."""
    with np.errstate(over="ignore"):  # beyond the largest number comes infinity
        return np.nextafter(values, values.dtype.type(side))
