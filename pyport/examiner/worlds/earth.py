"""The Earth: where telescopes stand, how it turns, and the clock's seconds as Julian dates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import erfa
import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array
from pyport.examiner.worlds.mount import Each

#: Metres for each radian of arc on the ground.
EARTH_RADIUS_M = 6.371e6

_UNIX_EPOCH_JD = 2440587.5
_DAY_S = 86400.0


@dataclass(frozen=True)
class Site:
    """A place: geodetic latitude and longitude (east positive) [rad] and height [m].

    Scalars, or one value for each pointing.
    """

    latitude: Each
    longitude: Each
    height_m: Each

    def moved(self, latitude: Each, longitude: Each) -> Site:
        """Return the place moved north and east [rad]."""
        return Site(self.latitude + latitude, self.longitude + longitude, self.height_m)


def _site(latitude_deg: float, longitude_deg: float, height_m: float) -> Site:
    return Site(latitude_deg * DEG, longitude_deg * DEG, height_m)


#: Telescopes that cases stand at, by name.
SITES = {
    "rt32": _site(53.0955, 18.5640, 133.0),
    "gmrt": _site(19.0965, 74.0497, 588.0),
    "south": _site(-31.8679, 133.8098, 164.0),
}


def julian_date(time_s: Array) -> tuple[float, Array]:
    """Return the two parts of the UTC Julian date for seconds since 1970."""
    return _UNIX_EPOCH_JD, np.asarray(time_s, float) / _DAY_S


@cache
def _iers() -> Any:  # noqa: ANN401 - astropy's table
    """Return the IERS B bulletin that comes with astropy; nothing is fetched."""
    from astropy.utils import iers

    return iers.IERS_B.open(iers.IERS_B_FILE)


def orientation(time_s: Array) -> tuple[Array, Array, Array]:
    """Return UT1-UTC [s] and the pole's x and y [rad] at UTC seconds since 1970, from IERS B."""
    date = julian_date(time_s)
    pole_x, pole_y = _iers().pm_xy(*date)
    ut1 = _iers().ut1_utc(*date)
    return ut1.to_value("s"), pole_x.to_value("arcsec") * ARCSEC, pole_y.to_value("arcsec") * ARCSEC


def dynamical(time_s: Array) -> tuple[Array, Array]:
    """Return the two parts of the TT Julian date for UTC seconds since 1970."""
    return erfa.taitt(*erfa.utctai(*julian_date(time_s)))


def motion(time_s: Array) -> tuple[Array, NDArray[Any]]:
    """Return the Earth's place from the Sun [au], (n, 3), and its barycentric place and velocity.

    Between whole hours it is interpolated linearly: the velocity bends by two
    parts in 10^9 in an hour, the direction of the Sun by 0.01 arcsec.
    """
    hour = np.asarray(time_s, float) / 3600
    before = np.floor(hour)
    nodes, index = np.unique([before, before + 1], return_inverse=True)
    first, second = index.reshape(2, -1)
    sun, barycentre = erfa.epv00(*dynamical(nodes * 3600))
    share = (hour - before)[:, None]

    def between(values: Array) -> Array:
        return (1 - share) * values[first] + share * values[second]

    moving: NDArray[Any] = np.empty(len(hour), erfa.dt_pv)
    moving["p"], moving["v"] = between(barycentre["p"]), between(barycentre["v"])
    return between(sun["p"]), moving
