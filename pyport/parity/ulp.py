"""Distance between floating-point numbers, counted in units in the last place."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Distance between numbers of different kinds: NaN and a number, infinite and finite.
UNLIKE = np.iinfo(np.int64).max


def ordinal(values: ArrayLike) -> NDArray[np.int64]:
    """Return the rank of each REAL*4: neighbours differ by one, -0.0 and 0.0 too.

    Parameters
    ----------
    values
        REAL*4 numbers (float32), no NaN, any shape.
    """
    bits = np.asarray(values, dtype=np.float32).view(np.int32).astype(np.int64)
    return np.where(bits < 0, -(bits & 0x7FFFFFFF) - 1, bits)


def ulps(expected: ArrayLike, actual: ArrayLike) -> NDArray[np.int64]:
    """Return how many REAL*4 numbers apart two arrays are, element by element.

    Any NaN equals any other: IEEE 754 promises neither sign nor payload. A NaN
    and a number are ``UNLIKE``, so are infinity and a finite number.
    """
    expected, actual = np.asarray(expected, np.float32), np.asarray(actual, np.float32)
    distance = np.abs(ordinal(expected) - ordinal(actual))
    unlike = (np.isnan(expected) != np.isnan(actual)) | (np.isinf(expected) != np.isinf(actual))
    unlike |= np.isinf(expected) & np.isinf(actual) & (expected != actual)
    distance = np.where(unlike, UNLIKE, distance)
    return np.where(np.isnan(expected) & np.isnan(actual), 0, distance)
