"""The frame of the sky turned under the telescope: wrong site coordinates, wrong clock."""

from __future__ import annotations

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.effects.base import (
    HELD,
    SKY,
    Basis,
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    stack,
)
from pyport.effects.sky.frame import SIDEREAL, hour_angle_shift, ut1_minus_utc

_SMART = "Smart, Textbook on Spherical Astronomy, ch. II: differentials of az and el"
#: UT1-UTC is distinguished from a constant error where it scatters by this share of itself.
CHANGED = 0.3
_CONSTANT, _OMITTED_UT1 = "constant", "UT1-UTC left out"


def site_latitude(at: Circumstances) -> tuple[Array, Array]:
    """Return the offset for each radian of true minus assumed latitude: a lean toward north."""
    return stack(at, (np.sin(at.el) * np.sin(at.az), np.cos(at.az)))


def site_longitude(at: Circumstances) -> tuple[Array, Array]:
    """Return the offset for each radian of true minus assumed longitude, east positive."""
    return stack(at, hour_angle_shift(at))


def hour_angle_turned(at: Circumstances) -> tuple[Array, Array]:
    """Return the offset for each radian of true minus assumed hour angle."""
    return stack(at, hour_angle_shift(at))


def _omitted_ut1(at: Circumstances) -> tuple[Array, Array]:
    """Return the offset of a clock that keeps UTC for UT1, as the Earth really turned."""
    seconds = ut1_minus_utc(at)
    x, y = hour_angle_shift(at)
    return stack(at, (seconds * x, seconds * y))


def _clock(variant: str) -> Effect:
    """Return an error of the clock: the same at all times, or that of UT1-UTC left out."""
    basis: Basis = hour_angle_turned
    coefficient = Coefficient("clock_error", "s", 15 * ARCSEC)
    if variant == _OMITTED_UT1:
        basis, coefficient = _omitted_ut1, Coefficient("share_of_ut1_utc", "", SIDEREAL, 1.0)
    return Effect(
        "clock",
        "the clock, or UT1-UTC, is wrong",
        _SMART,
        (coefficient,),
        basis,
        common="array",
        variant=variant,
        profile=_clocks,
        acts_in=SKY,
        in_arrays=HELD,
        pattern="along the hour angle, in both axes",
        needs=("latitude_deg",),
        formula=("d (sin phi cos E - cos phi sin E cos A)", "d cos phi sin A"),
        member={"variant": variant},
        make=_clock,
    )


def _clocks(at: Circumstances) -> tuple[Effect, ...]:
    """Return a constant error and, where it changed enough to show, UT1-UTC left out."""
    constant = _clock(_CONSTANT)
    try:
        seconds = ut1_minus_utc(at)
    except MissingColumn:
        return (constant,)
    if np.nanstd(seconds) < CHANGED * np.sqrt(np.nanmean(seconds**2)):
        return (constant,)
    return constant, _clock(_OMITTED_UT1)


EFFECTS = (
    Effect(
        "site_latitude",
        "the latitude used for the site is wrong",
        _SMART,
        (Coefficient("latitude_error"),),
        site_latitude,
        acts_in=SKY,
        mounts=("altaz", "xy"),
        in_arrays=HELD,
        pattern="as a lean toward north or south, in both axes",
        formula=("d sin E sin A", "d cos A"),
    ),
    Effect(
        "site_longitude",
        "the longitude used for the site is wrong",
        _SMART,
        (Coefficient("longitude_error"),),
        site_longitude,
        acts_in=SKY,
        in_arrays=HELD,
        pattern="along the hour angle, in both axes",
        needs=("latitude_deg",),
        formula=("d (sin phi cos E - cos phi sin E cos A)", "d cos phi sin A"),
    ),
    _clock(_CONSTANT),
)
