"""Where a source stands in the sky: every step from catalogue to horizon is ERFA's.

A steering program may leave steps out. The steps can be switched off one by
one, and what is left out is what its recordings will show.
"""

from __future__ import annotations

from dataclasses import dataclass

import erfa
import numpy as np

from pyport.angles import Array
from pyport.examiner.worlds.earth import Site, dynamical, julian_date, motion, orientation
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
