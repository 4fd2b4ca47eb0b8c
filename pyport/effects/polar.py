"""Equatorial mounts: what gravity does to forks and declination axes, and what a pier does."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.effects.base import (
    AXES,
    OVER,
    PIER_SIDE,
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    stack,
)

_TPOINT = "Wallace, TPOINT Telescope Pointing Analysis System, standard equatorial terms"
_MOUNTS = ("equatorial",)


def fork_flexure(at: Circumstances) -> tuple[Array, Array]:
    """Return -f cos H along declination: a fork hangs down, and its tube looks up at the pole."""
    return stack(at, (0, -np.cos(at.az)))


def declination_axis_flexure(at: Circumstances) -> tuple[Array, Array]:
    """Return d sin E across: the end of the declination axis that carries the tube hangs down."""
    where = at if at.sky is None else at.sky
    return stack(at, (np.sin(where.el), 0))


def pier_flip(at: Circumstances) -> tuple[Array, Array]:
    """Return zeros of both encoders that differ by twice this between the sides of the pier.

    One that changes sign with the side in the angles of the axes does not so on the sky: the
    declination axis then counts the other way.
    """
    side = np.where(at.column(PIER_SIDE) == OVER, -1.0, 1.0)
    if np.ptp(side) == 0:
        raise MissingColumn("both sides of the pier")
    return stack(at, (side * np.cos(at.el), 0), (0, side))


EFFECTS = (
    Effect(
        "fork_flexure",
        "the fork bends under the weight of the tube",
        _TPOINT,
        (Coefficient("fork_flexure"),),
        fork_flexure,
        formula=("", "-f cos H"),
        acts_in=AXES,
        mounts=_MOUNTS,
        pattern="in declination, with the cosine of hour angle",
    ),
    Effect(
        "declination_axis_flexure",
        "the declination axis bends under the weight of the tube",
        _TPOINT,
        (Coefficient("declination_axis_flexure"),),
        declination_axis_flexure,
        needs=("latitude_deg",),
        formula=("d sin E = d (sin phi sin D + cos phi cos D cos H)", ""),
        acts_in=AXES,
        mounts=_MOUNTS,
        pattern="in cross-declination, with the sine of elevation",
    ),
    Effect(
        "pier_flip",
        "the zeros of the encoders change when the mount turns over its pier",
        _TPOINT,
        (Coefficient("pier_flip_hour_angle"), Coefficient("pier_flip_declination")),
        pier_flip,
        needs=("pier_side",),
        formula=("+-a cos D", "b, the sign by the side of the pier"),
        acts_in=AXES,
        mounts=_MOUNTS,
        pattern="opposite in hour angle on the two sides of the pier, and a constant in "
        "declination that is the same on both",
    ),
)
