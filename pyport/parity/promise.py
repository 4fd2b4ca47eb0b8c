"""What the vectorised port promises: the oracle's own spread, and N ulp beyond it.

The port keeps REAL*8 throughout, and all that the promoted build shows (the roundings to REAL*4) is
in the spread already. What is left is derived output by output, not chosen:

- 1 ulp for Model and ModelA: two numbers equal but for their last REAL*8 digits may round to
  neighbouring REAL*4;
- 4 ulp for Hjump below the horizon: that 1, and the azimuth in degrees by way of 3.141593. Its
  error, 1.1e-7 of up to 270 deg, times the curve's slope there, 0.65, is 2.5 ulp of 64 deg.

At a zero ulp lose their meaning: taking the azimuth offset into half a turn costs 5e-14 deg, and
DASIN costs the altitude 1e-10 deg at the rim of the region that the ledger excludes around the
zenith. Answers ``ABSOLUTE_DEG`` apart are equal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyport.parity.ledger import explained
from pyport.parity.points import Points, Real4
from pyport.parity.ulp import ulps

#: Greatest distance beyond the oracle's own spread [ulp of REAL*4], in the order of ``OUTPUTS``.
PROMISED_ULP = (1, 1, 1, 1, 4)

#: Answers this close [deg] are equal: 0.7 microarcseconds.
ABSOLUTE_DEG = 2e-10

#: Where the promise holds: azimuth and altitude [rad], parameters [deg].
AZ_LIMIT, ALT_LIMIT, PARAMETER_LIMIT = 10.0, 2.0, 2e4


def promised(at: Points) -> NDArray[np.bool_]:
    """Tell at which points the promise holds: the cable's range and some, no infinities."""
    inside = (np.abs(at.az) <= AZ_LIMIT) & (np.abs(at.alt) <= ALT_LIMIT)
    sane = np.all(np.abs(at.parameters) <= PARAMETER_LIMIT, axis=1)
    return np.asarray(inside & sane[at.which])


def distances(expected: Real4, actual: Real4) -> NDArray[np.int64]:
    """Return the distances [ulp], shape (n, 5).

    Zero where answers are ``ABSOLUTE_DEG`` apart, and where both are half a turn: 180 and -180 deg
    are one angle.
    """
    with np.errstate(invalid="ignore"):
        close = np.abs(expected.astype(float) - actual) <= ABSOLUTE_DEG
    half_turns = (np.abs(expected) == np.float32(180)) & (np.abs(actual) == np.float32(180))
    return np.where(close | half_turns, 0, ulps(expected, actual))


def beyond(
    expected: Real4, actual: Real4, spread: Real4, at: Points
) -> tuple[NDArray[np.int64], dict[str, int]]:
    """Return the distances beyond the oracle's own spread, and how many the ledger explains.

    Parameters
    ----------
    expected, actual
        The answers of oracle and port, shape (n, 5).
    spread
        The least and greatest of the oracle's own answers, shape (2, n, 5).
    at
        The points.

    Returns
    -------
    beyond
        Shape (n, 5) [ulp], zero within the spread and where the ledger explains the distance.
    explained
        Entry of the ledger -> number of answers beyond the promise that it explains.
    """
    left = distances(np.clip(actual, *spread), actual)
    numbers = {}
    for name, mask in explained(at, expected).items():
        numbers[name] = int(((left > np.array(PROMISED_ULP)) & mask).sum())
        left = np.where(mask, 0, left)
    return left, numbers


def kept(worst: list[int]) -> bool:
    """Tell whether the worst distances beyond the spread, output by output, keep the promise."""
    return all(one <= bound for one, bound in zip(worst, PROMISED_ULP, strict=True))
