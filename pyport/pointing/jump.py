"""The curve in the sky where the RT32's secondary mirror lets go, and the step beyond it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pyport.angles import DEG, Array


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
    east = 65 + 7 * np.cos(az_south / 2)
    west = 55 + 15 * ((az_south / DEG - 95) / 90) ** 2
    return np.where(az_south <= 0, east, west) * DEG


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
    altitude = np.asarray(altitude, dtype=float)
    above = (altitude > 0) & (altitude >= jump_altitude(az_south))
    return above | (altitude < 0)
