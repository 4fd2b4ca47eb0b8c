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


def decimals(size: float, most: int, digits: int = 2) -> int:
    """Return so many decimals, at most so many, that a size, such as an error, has two digits."""
    return max(0, min(most, digits - 1 - math.floor(math.log10(size)))) if size > 0 else 3


def wrap(angle: ArrayLike) -> Array:
    """Return angles [rad] brought into [-pi, pi)."""
    return (np.asarray(angle, dtype=float) + math.pi) % (2 * math.pi) - math.pi


def cosine_between(az: ArrayLike, el: ArrayLike, other_az: Array, other_el: Array) -> Array:
    """Return the cosines of the angles between directions and others [rad], shapes broadcast."""
    cosine = np.sin(el) * np.sin(other_el)
    return np.asarray(cosine + np.cos(el) * np.cos(other_el) * np.cos(np.subtract(other_az, az)))


def separation(az: ArrayLike, el: ArrayLike, other_az: Array, other_el: Array) -> Array:
    """Return the angles between directions and others [rad], shapes broadcast."""
    return np.arccos(np.clip(cosine_between(az, el, other_az, other_el), -1.0, 1.0))
