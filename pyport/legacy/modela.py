"""Subroutine ModelA: the approximate form, REAL*4 throughout. Lines are those of modela.f."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyport.legacy.hjump import hjump
from pyport.legacy.intrinsics import amod, cos, sign, sin, tan

PI = np.float32(3.141593)  # modela.f:8, REAL*4
TURN = np.float32(360)  # modela.f:18-19


def modela(
    az: np.float32, alt: np.float32, p: Sequence[np.float32]
) -> tuple[np.float32, np.float32]:
    """Return the offsets (dAz, dAlt) [deg] of the approximate model.

    Parameters
    ----------
    az, alt
        Azimuth from South through West and altitude [rad], REAL*4 numbers.
    p
        The twelve parameters [deg], ``p[0]`` being the Fortran's ``p(1)``, REAL*4 numbers.
    """
    p1, p2, p3, p4, p5, p6, p7, p8, p9, p10, p11, p12 = p
    with np.errstate(all="ignore"):
        t = tan(alt)  # modela.f:10
        daz = (
            p1  # modela.f:11
            + p3 * t  # modela.f:12
            + p4 / cos(alt)  # modela.f:13
            + p5 * sin(az) * t  # modela.f:14
            - p6 * cos(az) * t  # modela.f:15
            + p9 * sin(2 * az)  # modela.f:16
            + p10 * cos(2 * az)  # modela.f:17
        )
        daz = amod(daz, TURN)  # modela.f:18
        if abs(daz) > 180:  # modela.f:19
            daz = daz - sign(TURN, daz)

        a = az  # modela.f:21
        if alt > PI / 2:  # modela.f:22
            a = PI + a
        dalt = (
            p2  # modela.f:23
            + p5 * cos(a)  # modela.f:24
            + p6 * sin(a)  # modela.f:25
            + p7 * cos(alt)  # modela.f:26
            + p8 * sin(alt)  # modela.f:27
            + p11 * sin(2 * a)  # modela.f:28
        )
        if hjump(az, alt) > 0:  # modela.f:29
            dalt = dalt + p12
    return daz, dalt
