"""Drives and scans: what depends on the way that the telescope moves."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.effects.base import Circumstances, Coefficient, Effect, stack

_GMRT = "Lal, Ishwara-Chandra & Rao, The GMRT Antenna Pointing II (2003), sections 1 and 3"


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


def _timing(name: str, cosine_of_el: bool) -> Effect:  # noqa: FBT001 - private
    def basis(at: Circumstances) -> tuple[Array, Array]:
        along_az, along_el = _scanned(at)
        rate = np.nan_to_num(np.asarray(at.column("scan_rate"), float))
        on_sky = np.cos(at.el) if cosine_of_el else 1.0
        return stack(at, (along_az * rate * on_sky, along_el * rate))

    return Effect(
        "scan_timing",
        "the time tag of the scan is wrong",
        _GMRT,
        (Coefficient("time_tag", "s", 1.0),),
        basis,
        common="session",
        variant=name,
        profile=_timings,
    )


def _timings(at: Circumstances) -> tuple[Effect, ...]:
    """Return scan_timing for a rate of the axis and, where azimuth was scanned, of the sky."""
    variants: tuple[Effect, ...] = (_timing("rate of the axis", cosine_of_el=True),)
    if np.any(_scanned(at)[0]):
        variants += (_timing("rate on the sky", cosine_of_el=False),)
    return variants


EFFECTS = (
    Effect(
        "scan_direction",
        "forward and reverse scans disagree (backlash seen by scanning)",
        _GMRT,
        (Coefficient("scan_direction_az"), Coefficient("scan_direction_el")),
        scan_direction,
    ),
    _timing("rate of the axis", cosine_of_el=True),
)
