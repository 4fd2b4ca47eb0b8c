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


_YEAR_S = 365.2422 * _DAY_S
_HOTTEST_HOUR = 15.0
_HOTTEST_DAY = 205.0


def wander(rng: np.random.Generator, time_s: Array, memory_s: float) -> Array:
    """Return an Ornstein-Uhlenbeck process of unit rms at ascending times.

    `rng`: where the randomness comes from.
    `time_s`: times [s], ascending, shape (n,).
    `memory_s`: its correlation falls by e in this time [s].
    """
    kick = rng.standard_normal(len(time_s))
    kept = np.exp(-np.diff(time_s, prepend=time_s[:1]) / memory_s)
    value = np.empty(len(time_s))
    state = kick[0]
    for i, (keep, new) in enumerate(zip(kept, kick, strict=True)):
        state = keep * state + np.sqrt(1 - keep**2) * new
        value[i] = state
    return value


def weather(
    rng: np.random.Generator, time_s: Array, longitude: float, height_m: float, *, north: bool
) -> dict[str, Array]:
    """Return the weather columns of the contract for ascending times, shape (n,) each.

    `rng`: where the randomness comes from.
    `time_s`: UTC, seconds since 1970, ascending.
    `longitude`: east positive [rad]: what time of the day it is.
    `height_m`: how thin the air is.
    `north`: which half of the Earth it is, for the seasons.
    """
    local_hour = (time_s / 3600 + longitude * 12 / np.pi) % 24
    year_day = (time_s % _YEAR_S) / _DAY_S
    day = np.cos((local_hour - _HOTTEST_HOUR) * np.pi / 12)
    season = np.cos((year_day - _HOTTEST_DAY) * 2 * np.pi * _DAY_S / _YEAR_S)
    if not north:
        season = -season

    temperature = 12 + 9 * season + 6 * day + 3 * wander(rng, time_s, 2 * _DAY_S)
    humidity = 65 - 15 * day + 15 * wander(rng, time_s, 1.5 * _DAY_S)
    pressure = 1013 * np.exp(-height_m / 8400) + 8 * wander(rng, time_s, 2.5 * _DAY_S)
    gust = 3 * wander(rng, time_s, 6 * 3600.0), 3 * wander(rng, time_s, 6 * 3600.0)
    mean = 4 * rng.standard_normal(2)
    east, north = gust[0] + mean[0], gust[1] + mean[1]
    return {
        "temperature_c": temperature,
        "pressure_hpa": pressure,
        "humidity_pct": np.clip(humidity, 8, 100),
        "wind_speed_m_s": np.hypot(east, north),
        "wind_az_deg": np.degrees(np.arctan2(-east, -north)) % 360,
    }
