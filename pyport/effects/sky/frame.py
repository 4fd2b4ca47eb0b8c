"""The sky as it turns over the site: directions, hour angles, the Sun, the Earth's orientation.

Vectors on the ground have the components north, east and up. Effects are small
and go by slopes: half a second of UT1 turns none of them by more than 1e-4 of
itself, a minute of TT by far less, so neither UT1-UTC nor leap seconds enter
unless they are the effect.
"""

from __future__ import annotations

import bisect
import functools
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, Array, wrap
from pyport.effects.base import Circumstances, MissingColumn

#: The Unix epoch as a Julian date, and TT - UTC since 1999 to 5 s.
UNIX_EPOCH_JD = 2440587.5
TT_MINUS_UTC_DAYS = 67.0 / 86400

#: Speed of the sky along the hour angle [rad/s].
SIDEREAL = 15.041067 * ARCSEC

#: Speed of light [au/day].
LIGHT_AU_PER_DAY = 173.1446326847


#: Years that ERFA's ephemeris is good for, in days since the Unix epoch.
CENTURIES = -25567.0, 47482.0


def days(at: Circumstances, later_s: float = 0.0) -> Array:
    """Return UTC [days since the Unix epoch], the mean of all where unknown: see `timed`."""
    utc = (at.numbers("time") + later_s) / 86400
    if np.nanmin(utc) < CENTURIES[0] or np.nanmax(utc) > CENTURIES[1]:
        raise MissingColumn("dates between 1900 and 2100")
    return np.where(np.isfinite(utc), utc, np.nanmean(utc))


def timed(at: Circumstances, *values: Array) -> tuple[Array, ...]:
    """Return values, shape (n,), with NaN where no time is known."""
    known = np.isfinite(at.numbers("time"))
    return tuple(np.where(known, one, np.nan) for one in values)


def axes(at: Circumstances) -> tuple[Array, Array, Array]:
    """Return unit vectors across, along elevation, and of the direction itself, (n, 3) each."""
    sin_a, cos_a, sin_e, cos_e = np.sin(at.az), np.cos(at.az), np.sin(at.el), np.cos(at.el)
    across = np.stack([-sin_a, cos_a, np.zeros_like(sin_a)], axis=1)
    along = np.stack([-sin_e * cos_a, -sin_e * sin_a, cos_e], axis=1)
    return across, along, np.stack([cos_e * cos_a, cos_e * sin_a, sin_e], axis=1)


def project(at: Circumstances, shift: Array) -> tuple[Array, Array]:
    """Return (x, y) of a small displacement on the ground, shape (n, 3), at the rows' times."""
    across, along, _ = axes(at)
    x, y = timed(at, np.sum(across * shift, axis=1), np.sum(along * shift, axis=1))
    return x, y


def turned(at: Circumstances, matrix: Array) -> tuple[Array, Array]:
    """Return (x, y) of turning the Earth-fixed sky by matrices of shape (n, 3, 3).

    As offsets are: differences of the mount's angles, the first one's times the cosine of the
    second. Precession of half a century differs from its tangent by 5 arcsec at 45 deg.
    """
    ground = to_ground(at)
    direction = axes(at)[2]
    there = rotated(np.einsum("nij,nj->ni", matrix, rotated(direction, ground.T)), ground)
    (first, second), (new_first, new_second) = (
        at.mount.angles(np.arctan2(east, north), np.arctan2(up, np.hypot(north, east)), at.frame)
        for north, east, up in (direction.T, there.T)
    )
    # Beyond the zenith the direction is that of the opposite azimuth.
    sign = np.where(np.cos(at.el) < 0, -1.0, 1.0)
    x, y = sign * wrap(new_first - first) * np.cos(second), sign * (new_second - second)
    across, along = timed(at, *at.along_sky(x, y))
    return across, along


def to_ground(at: Circumstances) -> Array:
    """Return the matrix from Earth-fixed axes to north, east, up, shape (3, 3)."""
    phi, lam = at.latitude(), at.longitude()
    return np.array(
        [
            [-np.sin(phi) * np.cos(lam), -np.sin(phi) * np.sin(lam), np.cos(phi)],
            [-np.sin(lam), np.cos(lam), 0.0],
            [np.cos(phi) * np.cos(lam), np.cos(phi) * np.sin(lam), np.sin(phi)],
        ]
    )


def rotated(vector: Array, matrix: Array) -> Array:
    """Return vectors, shape (n, 3), turned by a matrix.

    Not by matrix products, whose last digit depends on how many vectors there are.
    """
    return np.sum(vector[:, None, :] * matrix, axis=2)


def from_sky(at: Circumstances, vector: Array, later_s: float = 0.0) -> Array:
    """Return celestial (J2000) vectors, shape (n, 3), on the ground at the time of each row."""
    import erfa

    utc = days(at, later_s)
    pole = _day_by_day("pole", utc)
    earth = erfa.c2tcio(pole, erfa.era00(UNIX_EPOCH_JD, utc), np.eye(3))
    return rotated(np.einsum("nij,nj->ni", earth, vector), to_ground(at))


def earth_velocity(at: Circumstances) -> Array:
    """Return the Earth's barycentric velocity over that of light, celestial axes, shape (n, 3)."""
    return _day_by_day("velocity", days(at)) / LIGHT_AU_PER_DAY


def sun(at: Circumstances, lag_s: float = 0.0) -> tuple[Array, Array]:
    """Return azimuth and elevation of the Sun [rad] as they were `lag_s` seconds ago.

    To a minute of arc: what a structure feels.
    """
    earth = _day_by_day("place", days(at, -lag_s))
    north, east, up = from_sky(at, -earth, -lag_s).T
    azimuth, elevation = timed(at, np.arctan2(east, north), np.arctan2(up, np.hypot(north, east)))
    return azimuth, elevation


def sun_seen(at: Circumstances) -> tuple[Array, Array]:
    """Return azimuth and elevation of the Sun [rad], as recorded where both were, else computed."""
    if "sun_az" in at and "sun_el" in at:
        return at.numbers("sun_az"), at.numbers("sun_el")
    return sun(at)


def _day_by_day(what: str, utc: Array) -> Array:
    """Return vectors or matrices (n, 3, ...) of the Earth's way, interpolated between midnights.

    The orbit bends by 1 deg a day, so that a chord misses it by 4e-5 of itself at most; the pole
    nods by a hundredth of a second of arc beside its chord.
    """
    midnight, row = np.unique(np.floor(utc), return_inverse=True)
    before, after = (_at_midnight(what, tuple(midnight + day))[row] for day in (0, 1))
    phase = (utc - midnight[row]).reshape(-1, *[1] * (before.ndim - 1))
    return np.asarray(before + phase * (after - before))


@functools.lru_cache(maxsize=16)
def _at_midnight(what: str, midnights: tuple[float, ...]) -> Array:
    """Return the Earth's velocity, its place, or the matrix of its pole, at some UTC days."""
    import erfa

    tt = np.array(midnights) + TT_MINUS_UTC_DAYS
    if what == "velocity":
        found = erfa.epv00(UNIX_EPOCH_JD, tt)[1]["v"]
    elif what == "place":
        found = erfa.plan94(UNIX_EPOCH_JD, tt, 3)["p"]
    else:
        found = erfa.c2i00b(UNIX_EPOCH_JD, tt)
    found.setflags(write=False)
    return np.asarray(found)


def hour_angle_shift(at: Circumstances) -> tuple[Array, Array]:
    """Return (x, y) of one radian added to the hour angle.

    Per second of time it is the speed of the sidereal sky across the axes; its
    length is cos Dec.
    """
    phi = at.latitude()
    x = np.sin(phi) * np.cos(at.el) - np.cos(phi) * np.sin(at.el) * np.cos(at.az)
    return x, np.cos(phi) * np.sin(at.az)


def hour_angle(at: Circumstances) -> Array:
    """Return the hour angle pointed at [rad, positive west]."""
    phi = at.latitude()
    toward_equator = np.cos(phi) * np.sin(at.el) - np.sin(phi) * np.cos(at.el) * np.cos(at.az)
    return np.arctan2(-np.cos(at.el) * np.sin(at.az), toward_equator)


#: The Unix epoch as a modified Julian date.
_UNIX_EPOCH_MJD = 40587.0


def pole(at: Circumstances) -> tuple[Array, Array]:
    """Return the pole's coordinates x_p, y_p [arcsec] at the time of each row."""
    time, row, series = _around(at)
    x_p, y_p = (np.interp(time, series[:, 0], series[:, k])[row] for k in (1, 2))
    return x_p, y_p


def ut1_minus_utc(at: Circumstances) -> Array:
    """Return UT1-UTC [s] at the time of each row."""
    time, row, series = _around(at)
    # Between two days of a leap second UT1 runs on smoothly: unwrap it before interpolating.
    smooth = np.unwrap(series[:, 3], period=1.0)
    value = np.interp(time, series[:, 0], smooth)
    day = np.searchsorted(series[:, 0], time, side="right") - 1
    return timed(at, (value - smooth[day] + series[day, 3])[row])[0]


def _around(at: Circumstances) -> tuple[Array, NDArray[np.intp], Array]:
    """Return distinct times [MJD], which is each row's, and the days of the series around them.

    Raises `MissingColumn`: no times, or times that the series does not cover.
    """
    time, row = np.unique(days(at) + _UNIX_EPOCH_MJD, return_inverse=True)
    every = _days_of_series()
    if time[0] < _mjd(every[0]) or time[-1] >= _mjd(every[-1]):
        raise MissingColumn("Earth orientation at these dates")
    first, last = (bisect.bisect_left(every, one, key=_mjd) for one in time[[0, -1]].tolist())
    return time, row, np.loadtxt(every[max(first - 1, 0) : last + 2], usecols=(4, 5, 6, 7))


@functools.cache
def _days_of_series() -> list[str]:
    """Read the C04 series that comes with astropy, MJD, x_p, y_p [arcsec], UT1-UTC [s], as lines.

    It is read once: the file does not change while the program runs.
    """
    from astropy_iers_data import IERS_B_FILE

    lines = Path(IERS_B_FILE).read_text(encoding="ascii").splitlines()
    return [line for line in lines if line[0] != "#"]


def _mjd(day: str) -> float:
    return float(day.split(maxsplit=5)[4])
