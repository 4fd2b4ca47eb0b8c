"""The terms of the models that are examined, by formulae of the examiner's.

Offsets are encoder minus true, across (times cos E) and along elevation; azimuth A from north
through east, radians. Himwich, Mark IV Field System documentation, Pointing Model (1993); Lal,
Ishwara-Chandra & Rao, The GMRT Antenna Pointing II (2003), section 4 (hour angle).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Coefficients of the classical model of an alt-azimuth mount, in the order of its columns.
ALTAZ = (
    *("azimuth_zero", "elevation_zero", "collimation", "skew"),
    *("tilt_north", "tilt_east", "sag_cosine"),
)
#: Coefficients of a wave in hour angle along elevation.
HOUR_ANGLE = ("elevation_zero", "hour_angle_cosine", "hour_angle_sine")


def lean(az: Array, el: Array, toward: float = 0.0) -> tuple[Array, Array]:
    """Return what an azimuth axis that leans by one toward an azimuth does."""
    return np.sin(el) * np.sin(az - toward), np.cos(az - toward)


def both(across: Array | float, along: Array | float, n: int) -> Array:
    """Return offsets of both axes side by side, shape (n, 2)."""
    return np.stack([np.broadcast_to(one, n) for one in (across, along)], axis=1)


def altaz(az: Array, el: Array) -> Array:
    """Return the columns of the classical model, shape (n, 2, 7)."""
    columns: list[tuple[Array | float, Array | float]] = [
        (np.cos(el), 0.0),
        (0.0, 1.0),
        (1.0, 0.0),
        (np.sin(el), 0.0),
        lean(az, el),
        lean(az, el, np.pi / 2),
        (0.0, np.cos(el)),
    ]
    return np.stack([both(*one, len(el)) for one in columns], axis=2)


def hour_angle(angle: Array) -> Array:
    """Return the columns of a wave in hour angle [rad], shape (n, 2, 3)."""
    columns = [(0.0, np.ones(len(angle))), (0.0, np.cos(angle)), (0.0, np.sin(angle))]
    return np.stack([both(*one, len(angle)) for one in columns], axis=2)
