"""Where a source stands in the sky: every step from catalogue to horizon is ERFA's.

A steering program may leave steps out. The steps can be switched off one by
one, and what is left out is what its recordings will show.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import erfa
import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, HOUR, Array
from pyport.examiner.worlds.earth import (
    EARTH_RADIUS_M,
    Site,
    dynamical,
    julian_date,
    motion,
    orientation,
)
from pyport.examiner.worlds.mount import Each

#: What lies between a catalogue position and an observed one.
STEPS = frozenset(
    {
        "precession",
        "nutation",
        "annual_aberration",
        "diurnal_aberration",
        "ut1",
        "polar_motion",
        "refraction",
    }
)

#: Any wavelength beyond this is radio to ERFA's refraction. [micrometre]
_RADIO_UM = 1e6


@dataclass(frozen=True)
class Air:
    """The air at the telescope; scalars or one value for each pointing.

    `bent` and `curved` multiply the two coefficients of refraction, `wet` the
    part that water vapour has in them: a steering program whose constants are
    wrong believes in an air that is not there.
    """

    pressure_hpa: Each
    temperature_c: Each
    humidity: Each
    bent: Each = 1.0
    curved: Each = 1.0
    wet: Each = 1.0

    def coefficients(self) -> tuple[Array, Array]:
        """Return A and B of dZ = A tan Z + B tan^3 Z [rad], by ERFA's refco."""
        moist = erfa.refco(self.pressure_hpa, self.temperature_c, self.humidity, _RADIO_UM)
        dry = erfa.refco(self.pressure_hpa, self.temperature_c, 0.0, _RADIO_UM)
        first, third = (d + self.wet * (m - d) for m, d in zip(moist, dry, strict=True))
        return first * self.bent, third * self.bent * self.curved


@dataclass(frozen=True)
class Place:
    """Positions in the horizon's frame [rad]: azimuth in [0, 2 pi), elevation, hour angle."""

    az: Array
    el: Array
    hour_angle: Array


def observed(
    ra: Array, dec: Array, time_s: Array, site: Site, air: Air, steps: frozenset[str] = STEPS
) -> Place:
    """Return where sources are seen.

    `ra`, `dec`: ICRS catalogue position [rad], shape (n,).
    `time_s`: UTC, seconds since 1970, shape (n,).
    `site`, `air`: where, and through what.
    `steps`: which of `STEPS` are taken; without precession, nutation is applied to the catalogue's
      own equinox; without UT1 the Earth turns by UTC.
    """
    utc, tt = julian_date(time_s), dynamical(time_s)
    dut1, pole_x, pole_y = orientation(time_s)
    ut1 = erfa.utcut1(*utc, dut1 if "ut1" in steps else np.zeros_like(dut1))
    if "polar_motion" not in steps:
        pole_x, pole_y = np.zeros_like(pole_x), np.zeros_like(pole_y)

    equator, sidereal = _equator(tt, ut1, steps)
    from_sun, barycentric = motion(time_s)
    if "annual_aberration" not in steps:
        barycentric["v"] = 0.0
    astrometry = erfa.apci(*tt, barycentric, from_sun, 0.0, 0.0, 0.0)
    astrometry["bpn"] = equator
    apparent_ra, apparent_dec = erfa.atciq(ra, dec, 0.0, 0.0, 0.0, 0.0, astrometry)

    bending = air.coefficients() if "refraction" in steps else (0.0, 0.0)
    local = erfa.apio(
        erfa.sp00(*tt), sidereal, site.longitude, site.latitude, site.height_m,
        pole_x, pole_y, *bending,
    )  # fmt: skip
    if "diurnal_aberration" not in steps:
        local["diurab"] = 0.0
    az, zenith_distance, hour_angle, _, _ = erfa.atioq(apparent_ra, apparent_dec, local)
    return Place(az, np.pi / 2 - zenith_distance, hour_angle)


def _equator(
    tt: tuple[Array, Array], ut1: tuple[Array, Array], steps: frozenset[str]
) -> tuple[Array, Array]:
    """Return the matrix from ICRS to the equator in use, (n, 3, 3), and its sidereal time [rad].

    The equinox is the origin, as it is in every steering program of the time:
    leaving precession out then also leaves it out of right ascension.
    """
    dpsi, _, obliquity, bias, precession, _, nutation, _ = erfa.pn00b(*tt)
    matrix = bias
    sidereal = erfa.gmst00(*ut1, *tt)
    if "precession" in steps:
        matrix = precession @ matrix
    if "nutation" in steps:
        matrix = nutation @ matrix
        sidereal = sidereal + erfa.ee00(*tt, obliquity, dpsi)
    return matrix, sidereal


def sun(time_s: Array) -> tuple[Array, Array]:
    """Return the Sun's ICRS right ascension and declination [rad] as seen from the Earth."""
    ra, dec = erfa.c2s(-motion(time_s)[0])
    return erfa.anp(ra), dec


def planet(number: int, time_s: Array) -> tuple[Array, Array]:
    """Return a planet's geocentric right ascension and declination [rad], by ERFA's plan94.

    `number` counts from Mercury, 1.
    """
    from_sun, _ = motion(time_s)
    ra, dec = erfa.c2s(erfa.plan94(*dynamical(time_s), number)["p"] - from_sun)
    return erfa.anp(ra), dec


@dataclass(frozen=True)
class Sources:
    """Names and ICRS positions [rad] of sources, to an arcsecond, shape (m,)."""

    name: NDArray[np.str_]
    ra: Array
    dec: Array


@cache
def sources() -> Sources:
    """Return the list in `sources.csv`: calibrators from 80 deg north to 80 deg south."""
    text = (files("pyport.examiner.worlds") / "sources.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    return Sources(
        np.array([row["name"] for row in rows]),
        np.array([float(row["ra_h"]) for row in rows]) * HOUR,
        np.array([float(row["dec_deg"]) for row in rows]) * DEG,
    )


_ZERO_C_K = 273.15
_LAPSE_K_M = 6.5e-3
_COLDEST_K = 216.65
#: Gravity over the gas constant of dry air. [K/m]
_GRAVITY_K_M = 9.80665 / 287.053
_VAPOUR_HEIGHT_M = 2000.0
_TOP_M = 80e3
_LAYERS = 160


def bending(el: Array, air: Air) -> Array:
    """Return how far the air lifts sources that stand at vacuum elevations, [rad], shape (n,).

    Good where rays meet the layers at an angle, some degrees above the horizon.
    """
    height = _TOP_M * np.linspace(0, 1, _LAYERS + 1) ** 2
    index = 1 + 1e-6 * refractivity(height, air)
    radius = EARTH_RADIUS_M + height
    lift = np.zeros_like(el)
    for _ in range(5):
        # n r sin z is the same all along the ray (Bouguer).
        ray = index[..., :1] * radius[0] * np.cos(el + lift)[:, None]
        sine = ray / (index * radius)
        tangent = sine / np.sqrt(1 - sine**2)
        middle = (tangent[:, 1:] + tangent[:, :-1]) / 2
        lift = np.sum(middle * -np.diff(np.log(index), axis=-1), axis=1)
    return lift


def refractivity(height_m: Array, air: Air) -> Array:
    """Return (n - 1) * 10^6 of air over the telescope, shape (n, heights).

    Constants of Rueger 2002, FIG XXII, "best average"; vapour pressure by Magnus.
    """
    ground_k, pressure, humidity = (
        np.atleast_1d(np.asarray(value, float))[:, None]
        for value in (air.temperature_c + _ZERO_C_K, air.pressure_hpa, air.humidity)
    )
    celsius = ground_k - _ZERO_C_K
    vapour = humidity * 6.112 * np.exp(17.62 * celsius / (243.12 + celsius))
    kelvin = np.maximum(ground_k - _LAPSE_K_M * height_m, _COLDEST_K)
    # Where the air stops cooling its pressure falls exponentially instead of as a power.
    bend_m = np.maximum(ground_k - _COLDEST_K, 0) / _LAPSE_K_M
    cooled = (kelvin / ground_k) ** (_GRAVITY_K_M / _LAPSE_K_M)
    thinned = np.exp(-_GRAVITY_K_M / _COLDEST_K * np.maximum(height_m - bend_m, 0))
    e = vapour * np.exp(-height_m / _VAPOUR_HEIGHT_M)
    dry = (pressure - vapour) * cooled * thinned
    return 77.6890 * dry / kelvin + 71.2952 * e / kelvin + 375463 * e / kelvin**2
