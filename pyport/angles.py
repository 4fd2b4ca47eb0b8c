"""Angles: radians inside the program, these factors at its edges."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
#: For each row the number of its group.
Codes = NDArray[np.intp]

DEG = math.pi / 180
ARCMIN = DEG / 60
ARCSEC = DEG / 3600
MDEG = DEG / 1000
HOUR = math.pi / 12

#: Radians in one unit, by the suffix that a column's name carries.
RADIANS_PER: dict[str, float] = {
    "deg": DEG,
    "arcmin": ARCMIN,
    "arcsec": ARCSEC,
    "mdeg": MDEG,
    "h": HOUR,
    "rad": 1.0,
}


#: Angles of this size and more are shown in arcminutes: as arcseconds they have three digits.
COARSE = 120 * ARCSEC


def handy(size: float) -> tuple[float, str]:
    """Return the unit [rad] in which angles of a size [rad] are shown, and its name."""
    return (ARCMIN, "arcmin") if size >= COARSE else (ARCSEC, "arcsec")


def wrap(angle: ArrayLike) -> Array:
    """Return angles [rad] brought into [-pi, pi)."""
    return (np.asarray(angle, dtype=float) + math.pi) % (2 * math.pi) - math.pi
