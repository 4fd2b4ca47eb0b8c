"""The program that wrote the 3model table, as far as its printed digits betray it.

It called the exact form with azimuth brought into [-180, 180] deg, in the routine's
mixture of REAL*4 and REAL*8, took the tilt in plunge in its own way, and added a
refraction computed in REAL*4. `docs/steering-table.md` has the reasoning. Scalar, with
the C library's functions, so that the same bytes come out everywhere. Azimuth is counted
from south through west, offsets are in degrees.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pyport.angles import DEG, Array
from pyport.legacy import hjump
from pyport.legacy.intrinsics import (
    cos,
    dasin,
    datan2,
    dcos,
    dmod,
    dsign,
    dsin,
    dsqrt,
    sin,
    tan,
)
from pyport.pointing.exact import tilted

real4 = np.float32

#: Degrees in a radian, cut short, as the program's refraction has it.
SHORT_RADIAN = real4(57.29)


def tilted_over_the_shoulder(
    az_south: Array, altitude: Array, xi: float, zeta: float
) -> tuple[Array, Array]:
    """Return what :func:`pyport.pointing.exact.tilted` does, with the program's way in plunge.

    Beyond the zenith it takes the tilt at 180 deg - altitude with its sign turned, and
    adds the changes that this makes. Model turns the sign too, but mirrors the change of
    altitude: both agree to first order, not in the second.
    """
    plunging = np.cos(altitude) < 0
    facing = np.where(plunging, math.pi - altitude, altitude)
    ahead = tilted(az_south, facing, xi, zeta)
    behind = tilted(az_south, facing, -xi, -zeta)
    turn, reads = np.where(plunging, behind, ahead)
    return turn, altitude + (reads - facing)


def wrapped_deg(az_deg: float) -> float:
    """Return azimuth brought into [-180, 180] deg; both ends stay what they are."""
    return az_deg - math.copysign(360, az_deg) if abs(az_deg) > 180 else az_deg


def exact4(
    az4: np.float32, alt4: np.float32, p: Sequence[np.float32]
) -> tuple[np.float32, np.float32]:
    """Return (dAz, dAlt) [deg] of the exact form; short of the zenith Model's, bit for bit.

    Parameters
    ----------
    az4, alt4
        Azimuth and altitude [rad], REAL*4.
    p
        p1..p12 [deg], REAL*4.
    """
    az, alt = float(az4), float(alt4)
    sigma, beta, xi, zeta = (float(one) * math.pi / 180 for one in p[2:6])
    sh, ch = dsin(alt), dcos(alt)

    # Tilt; in plunge at 180 deg - altitude with its sign turned, and the change added
    facing = abs(ch)
    se = dsign(dsqrt(dsin(xi) * dsin(xi) + dsin(zeta) * dsin(zeta)), ch)
    ce = dsqrt(1 - se * se)
    toward = datan2(dsin(zeta), dsin(xi))
    turn = datan2(facing * dsin(toward - az), sh * se - facing * ce * dcos(toward - az)) - datan2(
        dsin(toward), -ce * dcos(toward)
    )
    turn -= az
    ht = dasin(ce * sh + se * facing * dcos(toward - az))
    if ch < 0:
        ht += 2 * alt - math.pi

    # Skew and box
    across = (dsin(sigma) * dsin(ht) + dsin(beta)) / (dcos(ht) * dcos(sigma))
    arc = float(real4(dasin(min(1.0, max(-1.0, across)))))
    hb = datan2(dsin(ht) * dcos(sigma) + dcos(ht) * dsin(sigma) * dsin(arc), dcos(ht) * dcos(arc))

    sine, cosine = sin(2 * az4), cos(2 * az4)
    # near 360 deg a REAL*4 has steps of 2**-15 deg: the grid that the offsets stand on
    # wherever the two angles of the tilt lie a turn apart
    d_az = real4(
        dmod((arc + turn) * 180 / math.pi, 360.0)
        + float(p[0])
        + float(p[8] * sine)
        + float(p[9] * cosine)
    )
    if abs(d_az) > 180:
        d_az = real4(float(d_az) - dsign(360.0, float(d_az)))
    d_alt = real4(
        (hb - alt) * 180 / math.pi
        + float(p[1])
        + float(p[6]) * ch
        + float(p[7]) * sh
        + float(p[10] * sine)
    )
    if hjump(az4, alt4) > 0:
        d_alt += p[11]
    return d_az, d_alt


def refraction4(zd_deg: float) -> np.float32:
    """Return R(z) [deg] in REAL*4, signed as Fortran's SIGN does it.

    The formula is that of `rt32-table` in :mod:`pyport.effects.refraction`.
    """
    h = real4((90 - abs(zd_deg)) * DEG) * SHORT_RADIAN
    first = 1 / tan((h + real4(7.31) / (h + real4(4.4))) / SHORT_RADIAN)
    h += first / 60
    second = 1 / tan((h + real4(7.31) / (h + real4(4.4))) / SHORT_RADIAN)
    wave = real4(0.06) * sin((real4(14.7) * first + 13) / SHORT_RADIAN)
    return real4(np.copysign((second - wave) / 60, zd_deg))
