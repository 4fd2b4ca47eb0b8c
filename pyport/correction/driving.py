"""Where a mount is driven by offsets along its axes, and back to the sky from its readings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pyport.angles import ARCSEC, Array, wrap
from pyport.correction.directions import Pointing
from pyport.mounts import ALTAZ, Mount, turned

#: Offsets across and along the second axis [rad], shape (n,) each, at directions.
At = Callable[[Pointing], tuple[Array, Array]]
#: The mount is inverted to this [rad]: a millionth of an arcsecond.
SETTLED = 1e-6 * ARCSEC
#: Offsets change by a hundredth of the way at most, but near the zenith: a few turns settle it.
TURNS = 60


def driven(there: Pointing, mount: Mount, offsets: At) -> tuple[Array, Array]:
    """Return where a mount is driven for true directions, as a place on the sky [rad]."""
    x, y = offsets(there)
    latitude = there.site.latitude if there.site is not None else 0.0
    first, second = mount.angles(there.az, there.el, latitude)
    return mount.sky(first + turned(x, second), second + y, latitude)


def undone(there: Pointing, mount: Mount, offsets: At) -> tuple[Array, Array]:
    """Return the true directions of a mount's readings [rad], by fixed-point iteration."""
    az, el = there.az.copy(), there.el.copy()
    for _ in range(TURNS):
        seen_az, seen_el = driven(replace(there, az=az, el=el), mount, offsets)
        new_az, new_el = az + (there.az - seen_az), el + (there.el - seen_el)
        if mount is not ALTAZ:
            new_az = az + wrap(new_az - az)
        moved = np.hypot((new_az - az) * np.cos(el), new_el - el)
        az, el = new_az, new_el
        if not np.nanmax(moved, initial=0.0) > SETTLED:
            break
    over = el > np.pi / 2  # past the zenith: the same place from the other side
    return np.where(over, az + np.pi, az), np.where(over, np.pi - el, el)
