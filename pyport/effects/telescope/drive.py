"""Drives and scans: what depends on the way that the telescope moves."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.effects.base import AXES, HELD, LASTING, Circumstances, Coefficient, Effect, stack
from pyport.effects.sky.frame import SIDEREAL, hour_angle_shift
from pyport.mounts import ALTAZ

_GMRT = "Lal, Ishwara-Chandra & Rao, The GMRT Antenna Pointing II (2003), sections 1 and 3"
#: What the rate of a scan along azimuth may be the rate of.
_OF_AXIS, _ON_SKY = "rate of the axis", "rate on the sky"
#: An axis that turns by less than this for a radian of the sky stands still.
STILL = 1e-9
_ALMA = "Mangum et al. 2006, PASP 118, 1257: backlash and servo errors of antenna drives"


def _scanned(at: Circumstances) -> tuple[Array, Array]:
    """Return the scan's direction where it went along azimuth, and where along elevation."""
    direction = np.nan_to_num(np.asarray(at.column("scan_direction"), float))
    if "scan_axis" not in at:
        return direction, direction
    axis = at.column("scan_axis")
    return direction * (axis == "az"), direction * (axis == "el")


def scan_direction(at: Circumstances) -> tuple[Array, Array]:
    """Return half the difference between forward and reverse scans, along the scanned axis."""
    along_az, along_el = _scanned(at)
    return stack(at, (along_az, 0), (0, along_el))


def _timing(variant: str) -> Effect:
    cosine_of_el = variant == _OF_AXIS

    def basis(at: Circumstances) -> tuple[Array, Array]:
        along_az, along_el = _scanned(at)
        rate = np.asarray(at.column("scan_rate"), float)
        on_sky = np.cos(at.el) if cosine_of_el else 1.0
        return stack(at, (along_az * rate * on_sky, along_el * rate))

    return Effect(
        "scan_timing",
        "the time tag of the scan is wrong",
        _GMRT,
        (Coefficient("time_tag", "s", 1.0),),
        basis,
        common="session",
        variant=variant,
        profile=_timings,
        acts_in=AXES,
        in_arrays=HELD,
        pattern="in opposite directions in forward and reverse scans, in proportion to their rate",
        needs=("scan_direction", "scan_rate_arcmin_per_min"),
        formula=("+-v tau cos E in scans along azimuth", "+-v tau in scans along elevation"),
        member={"variant": variant},
        make=_timing,
    )


def _timings(at: Circumstances) -> tuple[Effect, ...]:
    """Return scan_timing for a rate of the axis and, where azimuth was scanned, of the sky."""
    of_axis = _timing(_OF_AXIS)
    if not np.any(_scanned(at)[0]):
        return (of_axis,)
    return of_axis, _timing(_ON_SKY)


def _following(at: Circumstances) -> tuple[Array, Array]:
    """Return the way of the mount's axes that follow the sky, on the sky, per radian of it.

    An axis that the sky does not move stands still, whatever rounding says.
    """
    x, y = at.along_axes(*hour_angle_shift(at))
    return np.where(np.abs(x) > STILL, x, 0.0), np.where(np.abs(y) > STILL, y, 0.0)


def backlash_azimuth(at: Circumstances) -> tuple[Array, Array]:
    """Return b cos E sgn(dA/dt) across, for a telescope that follows the sky."""
    return stack(at, (at.onto_sky * np.sign(_following(at)[0]), 0))


def backlash_elevation(at: Circumstances) -> tuple[Array, Array]:
    """Return b sgn(dE/dt) along elevation, for a telescope that follows the sky.

    At any latitude what is east of the meridian rises.
    """
    if at.mount is ALTAZ:
        east = np.sin(at.az)
        return stack(at, (0, np.where(np.abs(east) > STILL, np.sign(east), 0.0)))
    return stack(at, (0, np.sign(_following(at)[1])))


def servo_lag_azimuth(at: Circumstances) -> tuple[Array, Array]:
    """Return tau dA/dt cos E across: the speed of the sky along azimuth."""
    return stack(at, (SIDEREAL * _following(at)[0], 0))


def servo_lag_elevation(at: Circumstances) -> tuple[Array, Array]:
    """Return tau dE/dt along elevation: the speed of the sky along elevation."""
    return stack(at, (0, SIDEREAL * _following(at)[1]))


EFFECTS = (
    Effect(
        "scan_direction",
        "the drive has play, as scanning sees it",
        _GMRT,
        (Coefficient("scan_direction_az"), Coefficient("scan_direction_el")),
        scan_direction,
        acts_in=AXES,
        in_arrays=LASTING,
        pattern="in opposite directions in forward and reverse scans",
        needs=("scan_direction",),
        formula=("+-b in scans along azimuth", "+-b in scans along elevation"),
    ),
    _timing(_OF_AXIS),
    Effect(
        "backlash_azimuth",
        "the azimuth drive has play",
        _ALMA,
        (Coefficient("backlash_azimuth"),),
        backlash_azimuth,
        pattern="in azimuth, with the sign of the motion in azimuth",
        needs=("latitude_deg",),
        formula=("b cos E sgn(dA/dt)", ""),
    ),
    Effect(
        "backlash_elevation",
        "the elevation drive has play",
        _ALMA,
        (Coefficient("backlash_elevation"),),
        backlash_elevation,
        pattern="in elevation, with opposite signs for rising and setting sources",
        formula=("", "b sgn(dE/dt)"),
    ),
    Effect(
        "servo_lag_azimuth",
        "the azimuth drive lags behind the moving sky",
        _ALMA,
        (Coefficient("servo_lag_azimuth", "s", 1.0),),
        servo_lag_azimuth,
        pattern="in azimuth, in proportion to the rate in azimuth",
        reversed="the azimuth drive runs ahead of the moving sky",
        needs=("latitude_deg",),
        formula=("tau dA/dt cos E", ""),
    ),
    Effect(
        "servo_lag_elevation",
        "the elevation drive lags behind the moving sky",
        _ALMA,
        (Coefficient("servo_lag_elevation", "s", 1.0),),
        servo_lag_elevation,
        pattern="in elevation, in proportion to the rate in elevation",
        reversed="the elevation drive runs ahead of the moving sky",
        needs=("latitude_deg",),
        formula=("", "tau dE/dt"),
    ),
)
