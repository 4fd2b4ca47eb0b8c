"""Alt-azimuth mounts: the first axis points up, azimuth is counted from north through east."""

from __future__ import annotations

from pyport.angles import DEG
from pyport.mounts.base import Axis, Mount

ALTAZ = Mount(
    id="altaz",
    sentence="an alt-azimuth mount",
    first=Axis("azimuth", "A", "az", "d_az", -720 * DEG, 720 * DEG),
    second=Axis("elevation", "E", "el", "d_el", 0.0, 90 * DEG),
    across="cross-elevation",
    across_column="d_xel",
    frame=None,
    model="altaz",
    blind_deg=0.5,
)

MOUNTS = (ALTAZ,)
