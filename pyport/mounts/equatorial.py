"""Equatorial mounts: the first axis points at the celestial pole, and turns with the hour angle.

The hour angle is zero on the meridian and grows toward the west; the declination grows toward
the north pole, in the south too, where that pole is below the horizon.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pyport.angles import DEG, Array
from pyport.mounts.base import Axis, Mount


def frame(latitude: float) -> Array:
    """Return the meridian point of the equator, the west point and the pole."""
    sine, cosine = np.sin(latitude), np.cos(latitude)
    return np.array([[-sine, 0.0, cosine], [0.0, -1.0, 0.0], [cosine, 0.0, sine]])


EQUATORIAL = Mount(
    id="equatorial",
    sentence="an equatorial mount",
    first=Axis("hour angle", "H", "hour_angle", "d_ha", -180 * DEG, 180 * DEG),
    second=Axis("declination", "D", "dec", "d_dec", -90 * DEG, 90 * DEG),
    across="cross-declination",
    across_column="d_xha",
    frame=frame,
    model="equatorial",
    needs_latitude=True,
    blind_deg=0.5,
    words={
        "azimuth axis": "polar axis",
        "azimuth": "hour angle",
        "elevations": "declinations",
        "elevation": "declination",
        "tilt north": "polar tilt meridian",
        "tilt east": "polar tilt west",
        "epoch tilt": "epoch tilt",
        "tilt": "polar axis",
    },
)
FORK = replace(EQUATORIAL, id="fork", sentence="an equatorial fork mount")
HORSESHOE = replace(EQUATORIAL, id="horseshoe", sentence="an equatorial horseshoe mount")
GERMAN = replace(EQUATORIAL, id="german", sentence="a German equatorial mount", turns_over=True)

MOUNTS = (EQUATORIAL, FORK, HORSESHOE, GERMAN)
