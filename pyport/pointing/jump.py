"""The curve in the sky where the RT32's secondary mirror lets go, and the step beyond it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pyport.angles import DEG, Array

#: Between which altitudes the curve runs east of south: 65 less and plus 7 deg. [rad]
_EAST_LOW, _EAST_HIGH = 57.9 * DEG, 72.1 * DEG


def jump_altitude(az_south: ArrayLike) -> Array:
    """Return the altitude of the jump [rad].

    Parameters
    ----------
    az_south
        Azimuth from south through west [rad], any shape, unwrapped as the cable is:
        the curve is not periodic, -100 deg and 260 deg differ.

    Notes
    -----
    Function Hjump of the RT32 Pointing Model (2004): 65 + 7 cos(A/2) deg for
    A <= 0, 55 + 15 ((A - 95)/90)^2 deg beyond.
    """
    az_south = np.asarray(az_south, dtype=float)
    return np.where(az_south <= 0, _east(az_south), _west(az_south))


def has_jumped_one(az_south: float, altitude: float) -> bool:
    """Tell what `has_jumped` does, for one direction [rad]."""
    if altitude < 0:
        return True
    if az_south <= 0:
        return altitude >= (65 + 7 * math.cos(az_south / 2)) * DEG
    return altitude >= (((az_south / DEG - 95) / 90) ** 2 * 15 + 55) * DEG


def _east(az_south: Array) -> Array:
    return np.asarray((65 + 7 * np.cos(az_south / 2)) * DEG)


def _west(az_south: Array) -> Array:
    curve = az_south / DEG
    curve -= 95
    curve /= 90
    curve *= curve
    curve *= 15
    curve += 55
    curve *= DEG
    return curve


def has_jumped(az_south: ArrayLike, altitude: ArrayLike) -> NDArray[np.bool_]:
    """Tell where the routines add the step, p12.

    At and above the curve; and below the horizon, since Hjump then returns the
    curve's altitude, a positive number, which its callers take for a yes.

    Parameters
    ----------
    az_south
        Azimuth from south through west [rad], unwrapped.
    altitude
        True altitude [rad], of a shape that broadcasts with the azimuth's.
    """
    az, alt = np.broadcast_arrays(
        np.asarray(az_south, dtype=float), np.asarray(altitude, dtype=float)
    )
    shape, az, alt = alt.shape, az.reshape(-1), alt.reshape(-1)
    east = az <= 0
    jumped = (east & (alt >= _EAST_HIGH)) | (~east & (alt >= _west(az)))
    # a cosine costs as much as all the rest: few points are so near that they need it
    near = np.flatnonzero(east & (alt > _EAST_LOW) & (alt < _EAST_HIGH))
    jumped[near] = alt[near] >= _east(az[near])
    jumped |= alt < 0
    return jumped.reshape(shape)[()]
