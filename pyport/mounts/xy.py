"""X-Y mounts: the first axis lies in the horizon, so that they follow a source through the zenith.

Both angles are zero at the zenith. With the first axis north and south X grows toward the east
and Y toward the north; with it east and west X grows toward the north and Y toward the east. The
keyholes are where the first axis meets the horizon.
"""

from __future__ import annotations

import numpy as np

from pyport.angles import DEG, Array
from pyport.mounts.base import Axis, Mount

UP, NORTH, EAST = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def _mount(name: str, sentence: str, frame: Array) -> Mount:
    return Mount(
        id=name,
        sentence=sentence,
        first=Axis("X", "X", "x", "d_x", -90 * DEG, 90 * DEG),
        second=Axis("Y", "Y", "y", "d_y", -90 * DEG, 90 * DEG),
        across="cross-Y",
        across_column="d_xx",
        frame=lambda _: frame,
        model="xy",
        blind_deg=5.0,
        words={
            "azimuth": "X",
            "elevations": "Y",
            "elevation": "Y",
            "tilt north": "x axis tilt up",
            "tilt east": "x axis tilt sideways",
            "epoch tilt": "epoch tilt",
            "tilt": "x axis tilt",
        },
    )


XY_NS = _mount(
    "xy-ns",
    "an X-Y mount with its X axis north and south",
    np.array([UP, EAST, NORTH]),
)
XY_EW = _mount(
    "xy-ew",
    "an X-Y mount with its X axis east and west",
    np.array([UP, NORTH, EAST]),
)

MOUNTS = (XY_NS, XY_EW)
