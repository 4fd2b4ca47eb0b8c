"""Between the two frames of a site: azimuth and elevation, hour angle and declination."""

from __future__ import annotations

from pyport.angles import Array, wrap


def horizon(hour_angle: Array, dec: Array, latitude: float) -> tuple[Array, Array]:
    """Return azimuth (from north through east, in [-pi, pi)) and elevation [rad].

    Hour angle is positive west; all angles in radians. ERFA's `hd2ae`.
    """
    import erfa

    az, el = erfa.hd2ae(hour_angle, dec, latitude)
    return wrap(az), el


def equator(az: Array, el: Array, latitude: float) -> tuple[Array, Array]:
    """Return hour angle (positive west, in [-pi, pi)) and declination [rad]. ERFA's `ae2hd`."""
    import erfa

    hour_angle, dec = erfa.ae2hd(az, el, latitude)
    return wrap(hour_angle), dec
