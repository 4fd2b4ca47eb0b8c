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


def wrap(angle: ArrayLike) -> Array:
    """Return angles [rad] brought into [-pi, pi)."""
    return (np.asarray(angle, dtype=float) + math.pi) % (2 * math.pi) - math.pi
