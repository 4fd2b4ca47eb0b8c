"""Between the two frames of a site: azimuth and elevation, hour angle and declination."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array, wrap


def horizon(hour_angle: Array, dec: Array, latitude: float) -> tuple[Array, Array]:
    """Return azimuth (from north through east, in [-pi, pi)) and elevation [rad].

    Hour angle is positive west; all angles in radians. ERFA's `hd2ae`.
    """
    import erfa

    with np.errstate(invalid="ignore"):  # a NaN stays one
        az, el = erfa.hd2ae(hour_angle, dec, latitude)
    return wrap(az), el


def equator(az: Array, el: Array, latitude: float) -> tuple[Array, Array]:
    """Return hour angle (positive west, in [-pi, pi)) and declination [rad]. ERFA's `ae2hd`."""
    import erfa

    with np.errstate(invalid="ignore"):
        hour_angle, dec = erfa.ae2hd(az, el, latitude)
    return wrap(hour_angle), dec


def hour_angle_at(el: Array, dec: float, latitude: float) -> Array:
    """Return how far from the meridian [rad, 0 to pi] a source is at an elevation [rad].

    NaN where it never gets there.
    """
    sine = np.sin(el) - np.sin(latitude) * np.sin(dec)
    cosine = sine / (np.cos(latitude) * np.cos(dec))
    return np.arccos(np.where(np.abs(cosine) <= 1, cosine, np.nan))
