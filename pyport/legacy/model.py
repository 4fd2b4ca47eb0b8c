"""Subroutine Model: the exact form. Line numbers are those of the patched model.f.

Model computes in REAL*8, but its arguments, its two results and `p` are REAL*4: what it stores in
`dAz` on the way is rounded there and then, and a product of two REAL*4 is a REAL*4 product before
it joins a REAL*8 sum. A REAL*8 is a Python float below; `real4` marks each rounding to REAL*4.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyport.legacy.hjump import hjump
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
)

PI = 3.141592653589793  # model.f:10, REAL*8

real4 = np.float32


def model(
    az: np.float32, alt: np.float32, p: Sequence[np.float32]
) -> tuple[np.float32, np.float32]:
    """Return the offsets (dAz, dAlt) [deg] of the exact model.

    Parameters
    ----------
    az, alt
        Azimuth from South through West and altitude [rad], REAL*4 numbers.
    p
        The twelve parameters [deg], ``p[0]`` being the Fortran's ``p(1)``, REAL*4 numbers.
    """
    with np.errstate(all="ignore"):
        return _model(az, alt, p)


def _arcsin(arg: float) -> float:
    """Return the arcsine of an argument brought into [-1, 1]; model.f:11, a statement function."""
    # gfortran's DMAX1 and DMIN1 return their constant when the other is NaN.
    return dasin(min(1.0, max(-1.0, arg)))


def _model(
    az4: np.float32, alt4: np.float32, p: Sequence[np.float32]
) -> tuple[np.float32, np.float32]:
    """Compute with the types named: `az4` is the REAL*4 argument, `az` its exact REAL*8 value."""
    az, alt = float(az4), float(alt4)
    xi = float(p[4]) * PI / 180  # model.f:12, tilt out
    zeta = float(p[5]) * PI / 180  # model.f:13, tilt over
    sigma = float(p[2]) * PI / 180  # model.f:14, skew
    beta = float(p[3]) * PI / 180  # model.f:15, beam (box) offset
    sh = dsin(alt)  # model.f:16
    ch = dcos(alt)  # model.f:17

    # Tilt
    se = dsign(dsqrt(dsin(xi) * dsin(xi) + dsin(zeta) * dsin(zeta)), ch)  # model.f:20
    ce = dsqrt(1 - se * se)  # model.f:21
    alfa = datan2(dsin(zeta), dsin(xi))  # model.f:22
    at = datan2(
        ch * dsin(alfa - az),
        sh * se - ch * ce * dcos(alfa - az),
    ) - datan2(dsin(alfa), -ce * dcos(alfa))  # model.f:23-24
    ht = dasin(ce * sh + se * ch * dcos(alfa - az))  # model.f:25
    at_az = at - az  # model.f:26
    if ch < 0:  # model.f:27
        at_az = PI - at_az  # model.f:28
        ht = PI - ht  # model.f:29

    # Skew and box offset together (good also for hT > pi/2)
    arc = _arcsin((dsin(sigma) * dsin(ht) + dsin(beta)) / (dcos(ht) * dcos(sigma)))  # model.f:33-34
    daz = float(real4(arc))
    hb = datan2(
        dsin(ht) * dcos(sigma) + dcos(ht) * dsin(sigma) * dsin(daz),
        dcos(ht) * dcos(daz),
    )  # model.f:35-36

    twice = 2 * az4
    daz4 = real4(
        dmod((daz + at_az) * 180 / PI, 360.0)  # model.f:38
        + float(p[0])  # model.f:39
        + float(p[8] * sin(twice))  # model.f:40
        + float(p[9] * cos(twice))  # model.f:41
    )
    if abs(daz4) > 180:  # model.f:42
        daz4 = real4(float(daz4) - dsign(360.0, float(daz4)))

    dalt4 = real4(
        (hb - alt) * 180 / PI  # model.f:44
        + float(p[1])  # model.f:45
        + float(p[6]) * ch  # model.f:46
        + float(p[7]) * sh  # model.f:47
        + float(p[10] * sin(twice))  # model.f:48
    )
    if hjump(az4, alt4) > 0:  # model.f:49
        dalt4 = dalt4 + p[11]
    return daz4, dalt4
