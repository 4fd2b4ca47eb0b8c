"""The frame of the sky turned under the telescope: wrong site coordinates, wrong clock."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.effects.base import Circumstances, Coefficient, Effect, stack

_SMART = "Smart, Textbook on Spherical Astronomy, ch. II: differentials of az and el"


def _hour_angle_shift(at: Circumstances) -> tuple[Array, Array]:
    """Return (x, y) of one radian added to the hour angle."""
    phi = at.latitude()
    x = np.sin(phi) * np.cos(at.el) - np.cos(phi) * np.sin(at.el) * np.cos(at.az)
    return x, np.cos(phi) * np.sin(at.az)


def site_latitude(at: Circumstances) -> tuple[Array, Array]:
    """Return the offset for each radian of true minus assumed latitude: a lean toward north."""
    return stack(at, (np.sin(at.el) * np.sin(at.az), np.cos(at.az)))


def site_longitude(at: Circumstances) -> tuple[Array, Array]:
    """Return the offset for each radian of true minus assumed longitude, east positive."""
    return stack(at, _hour_angle_shift(at))


def clock(at: Circumstances) -> tuple[Array, Array]:
    """Return the offset for each radian of true minus assumed hour angle."""
    return stack(at, _hour_angle_shift(at))


EFFECTS = (
    Effect(
        "site_latitude",
        "the latitude used for the site is wrong",
        _SMART,
        (Coefficient("latitude_error"),),
        site_latitude,
    ),
    Effect(
        "site_longitude",
        "the longitude used for the site is wrong",
        _SMART,
        (Coefficient("longitude_error"),),
        site_longitude,
    ),
    Effect(
        "clock",
        "the clock, or UT1-UTC, is wrong: every hour angle is shifted",
        _SMART,
        (Coefficient("clock_error", "s", 15 * np.pi / 648000),),
        clock,
        common="array",
    ),
)
