"""p1..p12 by name, for azimuths counted from where the mount leans."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Leaning:
    """p1..p12 [rad] by name, and what follows from them for azimuths counted from `toward`."""

    az0: float
    alt0: float
    sigma: float
    beta: float
    lean: float
    upright: float
    toward: float
    #: How far from its own zero the tilted mount sees the south point.
    south: float
    sag: float
    sag_sine: float
    jump: float
    #: What sin(2 Az) and cos(2 Az) add to the offsets in azimuth and in altitude.
    in_az: tuple[float, float]
    in_alt: tuple[float, float]

    @classmethod
    def of(cls, p: ArrayLike, *, exact: bool) -> Leaning:
        """Return them for either form."""
        # an infinite angle has no sine
        given = [one if math.isfinite(one) else math.nan for one in map(float, np.asarray(p))]
        az0, alt0, sigma, beta, xi, zeta, sag, sag_sine, sin_2a, cos_2a, nod, jump = given
        south, west = (math.sin(xi), math.sin(zeta)) if exact else (xi, zeta)
        toward = math.atan2(west, south)
        sine, cosine = math.sin(2 * toward), math.cos(2 * toward)
        in_az = sin_2a * cosine - cos_2a * sine, sin_2a * sine + cos_2a * cosine
        in_alt = nod * cosine, nod * sine
        lean = math.hypot(south, west)
        upright = math.sqrt(max(0.0, 1 - lean**2))
        zero = 0.0
        if exact:
            sine, cosine = math.sin(toward), math.cos(toward)
            zero = math.atan2(sine * cosine * (1 - upright), cosine**2 * upright + sine**2)
        return cls(
            az0, alt0, sigma, beta, lean, upright, toward, zero, sag, sag_sine, jump, in_az, in_alt
        )
