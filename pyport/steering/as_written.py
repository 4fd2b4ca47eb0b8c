"""The program that wrote the 3model table, as far as its printed digits betray it.

It called the exact form with azimuth brought into [-180, 180] deg, in the routine's
mixture of REAL*4 and REAL*8, took the tilt in plunge in its own way, and added a
refraction computed in REAL*4. `docs/steering-table.md` has the reasoning. Functions are
the C library's, called number by number, so that the same bytes come out everywhere.
Azimuth is counted from south through west, offsets are in degrees.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pyport.angles import DEG, Array
from pyport.legacy import hjump
from pyport.legacy.hjump import PI
from pyport.legacy.intrinsics import (
    cos,
    datan2,
    dcos,
    dsin,
    dsqrt,
    or_nan,
    sin,
    tan,
)

real4 = np.float32
Array4 = NDArray[np.float32]

#: Degrees in a radian, cut short, as the program's refraction has it.
SHORT_RADIAN = real4(57.29)


def wrapped_deg(az_deg: float) -> float:
    """Return azimuth brought into [-180, 180] deg; both ends stay what they are."""
    return az_deg - math.copysign(360, az_deg) if abs(az_deg) > 180 else az_deg


def exact4(az4: ArrayLike, alt4: ArrayLike, p: Sequence[np.float32]) -> tuple[Array4, Array4]:
    """Return (dAz, dAlt) [deg] of the exact form; short of the zenith Model's, bit for bit.

    `az4`, `alt4`: azimuth and altitude [rad], REAL*4, of shapes that broadcast: what depends on one
      of them alone is computed as often as that one has elements.
    `p`: p1..p12 [deg], REAL*4.
    """
    az4, alt4 = np.asarray(az4, real4), np.asarray(alt4, real4)
    az, alt = az4.astype(float), alt4.astype(float)
    sigma, beta, xi, zeta = (float(one) * math.pi / 180 for one in p[2:6])
    sh, ch = each(math.sin, alt), each(math.cos, alt)

    # Tilt; in plunge at 180 deg - altitude with its sign turned, and the change added
    facing = np.abs(ch)
    se = np.copysign(dsqrt(dsin(xi) * dsin(xi) + dsin(zeta) * dsin(zeta)), ch)
    ce = np.sqrt(1 - se * se)
    toward = datan2(dsin(zeta), dsin(xi))
    sin_off, cos_off = each(math.sin, toward - az), each(math.cos, toward - az)
    turn = each(math.atan2, facing * sin_off, sh * se - facing * ce * cos_off) - each(
        math.atan2, dsin(toward), -ce * dcos(toward)
    )
    turn -= az
    ht = each(math.asin, ce * sh + se * facing * cos_off)
    ht = np.where(ch < 0, ht + (2 * alt - math.pi), ht)

    # Skew and box
    sin_ht, cos_ht = each(math.sin, ht), each(math.cos, ht)
    across = (dsin(sigma) * sin_ht + dsin(beta)) / (cos_ht * dcos(sigma))
    arc = each(math.asin, np.fmin(1.0, np.fmax(-1.0, across))).astype(real4).astype(float)
    sin_arc, cos_arc = each(math.sin, arc), each(math.cos, arc)
    hb = each(math.atan2, sin_ht * dcos(sigma) + cos_ht * dsin(sigma) * sin_arc, cos_ht * cos_arc)

    sine, cosine = each4(sin, 2 * az4), each4(cos, 2 * az4)
    # near 360 deg a REAL*4 has steps of 2**-15 deg: the grid that the offsets stand on
    # wherever the two angles of the tilt lie a turn apart
    d_az = (
        np.fmod((arc + turn) * 180 / math.pi, 360.0)
        + float(p[0])
        + (p[8] * sine).astype(float)
        + (p[9] * cosine).astype(float)
    ).astype(real4)
    wide = np.abs(d_az) > 180
    d_az = np.where(wide, (d_az - np.copysign(360.0, d_az)).astype(real4), d_az)
    d_alt = (
        (hb - alt) * 180 / math.pi
        + float(p[1])
        + float(p[6]) * ch
        + float(p[7]) * sh
        + (p[10] * sine).astype(float)
    ).astype(real4)
    return d_az[()], np.where(jumped4(az4, alt4), d_alt + p[11], d_alt)[()]


def jumped4(az4: Array4, alt4: Array4) -> NDArray[np.bool_]:
    """Tell where the step is added, as routine Hjump answers, shapes as for `exact4`."""
    # below the horizon Hjump returns the altitude of the jump [deg]
    curve = each4(lambda az: hjump(az, real4(-1)), az4)
    height = alt4 * 180 / PI
    return np.where(alt4 < 0, curve > 0, (alt4 > 0) & (curve <= height))


def each(function: Callable[..., float], *x: ArrayLike) -> Array:
    """Return a function of `math` for each element of arrays that broadcast, as Fortran has it."""
    parts = np.broadcast_arrays(*(np.asarray(one, float) for one in x))
    numbers = [one.ravel().tolist() for one in parts]
    try:
        values = list(map(function, *numbers))
    except ValueError:
        values = list(map(or_nan(function), *numbers))
    return np.array(values).reshape(parts[0].shape)


def each4(function: Callable[[np.float32], np.float32], x: Array4) -> Array4:
    """Return a function of REAL*4 numbers for each element."""
    return np.array([function(one) for one in x.ravel()], real4).reshape(x.shape)


def refraction4(zd_deg: float) -> np.float32:
    """Return R(z) [deg] in REAL*4, signed as Fortran's SIGN does it.

    The formula is that of `rt32-table` in :mod:`pyport.effects.sky.atmosphere`.
    """
    h = real4((90 - abs(zd_deg)) * DEG) * SHORT_RADIAN
    first = 1 / tan((h + real4(7.31) / (h + real4(4.4))) / SHORT_RADIAN)
    h += first / 60
    second = 1 / tan((h + real4(7.31) / (h + real4(4.4))) / SHORT_RADIAN)
    wave = real4(0.06) * sin((real4(14.7) * first + 13) / SHORT_RADIAN)
    return real4(np.copysign((second - wave) / 60, zd_deg))
