"""What a, b and d say of an antenna's latitude and longitude.

With sin E = sin(phi) sin(dec) + cos(phi) cos(dec) cos(h), an antenna that
stands dphi further north and dh further on in hour angle sees

    cos E dE = dphi cos(phi) sin(dec) - dphi sin(phi) cos(dec) cos h
               - dh cos(phi) cos(dec) sin h

so in a + b cos(h + d)

    a       =  dphi cos(phi) sin(dec)
    b cos d = -dphi sin(phi) cos(dec)
    b sin d =  dh cos(phi) cos(dec)

The paper prints the same a, b and its square root, but d = atan of (the
latitude's part / the hour angle's part): the reciprocal, without the sign.
That is the d of a sine, b sin(h + d), turned round; taken at its word it gives
away the latitude for the longitude.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pyport.angles import HOUR, Array
from pyport.recordings import sky


@dataclass(frozen=True)
class Wave:
    """The coefficients of a + b cos(h + d) for cos E times the elevation offset [rad]."""

    a: float
    b: float
    d: float

    def __call__(self, hour_angle: Array) -> Array:
        """Return a + b cos(h + d)."""
        return self.a + self.b * np.cos(hour_angle + self.d)


def wave_of_place(north: float, on: float, dec: float, latitude: float) -> Wave:
    """Return the curve of an antenna `north` further north and `on` further on in hour angle."""
    cosine = -north * np.sin(latitude) * np.cos(dec)
    minus_sine = on * np.cos(latitude) * np.cos(dec)
    a = north * np.cos(latitude) * np.sin(dec)
    return Wave(
        float(a), float(np.hypot(cosine, minus_sine)), float(np.arctan2(minus_sine, cosine))
    )


def wave_as_printed(north: float, on: float, dec: float, latitude: float) -> Wave:
    """Return the same by the paper's own formulae, to show that they differ."""
    of_latitude = np.sin(latitude) * np.cos(dec) * north
    of_hour_angle = np.cos(latitude) * np.cos(dec) * on
    a = np.cos(latitude) * np.sin(dec) * north
    d = np.arctan(of_latitude / of_hour_angle)
    return Wave(float(a), float(np.hypot(of_latitude, of_hour_angle)), float(d))


def further_on(sine: tuple[float, float], dec: float, latitude: float) -> tuple[float, float]:
    """Return how far on in hour angle an antenna stands, with its sigma [rad].

    From the odd part of its curve for cos E times the offset, -b sin d: what
    the encoder's zero adds (cos E, even in hour angle) does not reach it.
    """
    size = np.cos(latitude) * np.cos(dec)
    return float(-sine[0] / size), float(sine[1] / size)


def further_north_twice(
    a: float, cosine: float, dec: float, latitude: float
) -> tuple[float, float]:
    """Return the northward displacement [rad] by a, and by b cos d.

    They should be the same. In the tables they are not, as a also holds the
    encoder's zero; the paper's a, b and d have one number too many for a place.
    """
    return (
        float(a / (np.cos(latitude) * np.sin(dec))),
        float(-cosine / (np.sin(latitude) * np.cos(dec))),
    )


def wave_fitted_to_place(
    north: float, on: float, dec: float, latitude: float, hours: tuple[float, float]
) -> Wave:
    """Return the plain form (dE, no cos E) fitted to a displaced antenna over some hours.

    dE of a displaced antenna is no cosine of hour angle. So a, b and d depend
    on the hour angles that they are fitted over, most for the ends of the arms.
    """
    hour_angle = np.linspace(*hours, 60) * HOUR
    _, computed = sky.horizon(hour_angle, np.full(60, dec), latitude)
    _, seen = sky.horizon(hour_angle + on, np.full(60, dec), latitude + north)
    columns = np.stack([np.ones(60), np.cos(hour_angle), np.sin(hour_angle)], axis=1)
    a, cosine, sine = np.linalg.lstsq(columns, seen - computed, rcond=None)[0]
    return Wave(float(a), -float(np.hypot(cosine, sine)), float(np.arctan2(sine, -cosine)))
