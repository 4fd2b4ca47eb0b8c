"""Function Hjump: the observed jump in the altitude offsets.

Line numbers are those of the patched hjump.f. REAL*4 throughout: an integer constant takes the kind
of its partner, in Fortran as in NumPy.
"""

from __future__ import annotations

import numpy as np

from pyport.legacy.intrinsics import cos

PI = np.float32(3.141593)  # hjump.f:4, REAL*4


def hjump(az: np.float32, alt: np.float32) -> np.float32:
    """Return 1 above the jump, else 0; for a negative altitude that of the jump [deg].

    Parameters
    ----------
    az, alt
        Azimuth from South through West and altitude [rad], REAL*4 numbers.
    """
    with np.errstate(all="ignore"):
        jump = np.float32(0)  # hjump.f:5
        a = az * 180 / PI  # hjump.f:6
        h = alt * 180 / PI  # hjump.f:7
        if a <= 0:  # hjump.f:8
            hj = 65 + 7 * cos(az / 2)  # hjump.f:9
        else:
            ratio = (a - 95) / 90
            hj = 55 + ratio * ratio * 15  # hjump.f:11
    if alt > 0 and hj <= h:  # hjump.f:13
        jump = np.float32(1)
    if alt < 0:  # hjump.f:14
        jump = hj
    return jump
