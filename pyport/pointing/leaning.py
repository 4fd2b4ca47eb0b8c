"""What the quick forms start from: p1..p12 as a leaning mount has them, and angles with sines."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pyport.angles import Array

#: A quarter turn, and what a double leaves of it. [rad]
_QUARTER, _QUARTER_LOW = np.pi / 2, 6.123233995736766e-17


@dataclass(frozen=True)
class Axis:
    """An angle and its sine and cosine, from one tangent of the half angle.

    Both come out within 4e-16: a tangent costs a fifth of a sine where the
    processor computes eight at a time. They are written to `room`, two arrays
    that are used again for the next block: fresh memory costs as much as the sums.
    """

    angle: Array
    sine: Array
    cosine: Array

    @classmethod
    def of(cls, angle: Array, origin: float = 0.0, room: Array | None = None) -> Axis:
        """Return an axis of angles [rad]; sines and cosines are those of angle - origin."""
        room = np.empty((2, *angle.shape)) if room is None else room
        np.subtract(angle, origin, out=room[0])
        return cls(angle, *_sine_and_cosine(*room))

    @classmethod
    def of_altitudes(cls, altitude: Array, room: Array | None = None) -> Axis:
        """Return an axis of altitudes [rad], whose cosines matter near the zenith.

        They come from the zenith distance, pi/2 taken to twice the digits.
        """
        room = np.empty((2, *altitude.shape)) if room is None else room
        np.subtract(_QUARTER, altitude, out=room[0])
        room[0] += _QUARTER_LOW
        cosine, sine = _sine_and_cosine(*room)
        return cls(altitude, sine, cosine)

    def __getitem__(self, rows: slice) -> Axis:
        """Return some rows of it."""
        return Axis(self.angle[rows], self.sine[rows], self.cosine[rows])


def _sine_and_cosine(angle: Array, cosine: Array) -> tuple[Array, Array]:
    """Write sines, to their own last digits, in the angles' place [rad], and cosines."""
    angle *= 0.5
    sine = np.tan(angle, out=angle)
    np.multiply(sine, sine, out=cosine)
    cosine += 1
    np.divide(2.0, cosine, out=cosine)
    sine *= cosine
    cosine -= 1
    return sine, cosine


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
