"""The columns of recordings under the contract's names, in the units that those tell."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.columns import (
    DAY,
    DIRECTIONS,
    HOUR_OF_DAY,
    SCAN_RATE,
    SCAN_RATE_UNIT,
    SPELLED,
    angle_of,
)
from pyport.effects import MissingColumn
from pyport.recordings.mounted import axes_of, names_of
from pyport.recordings.schema import Recordings


def column(recordings: Recordings, name: str) -> NDArray[Any] | None:
    """Return a column as numbers (NaN for unknown) or text, None where there is none.

    Angles may be asked for in any unit; the Sun's place is computed where the
    file does not tell it and times, latitude and longitude are known.
    """
    angle = angle_of(name)
    if angle is not None:
        values = _angle(recordings, angle[0])
        return None if values is None else values / angle[1]
    at = recordings.at
    if name == "time_utc":
        return at.columns.get("time")
    if name == SCAN_RATE:
        return at.columns["scan_rate"] / SCAN_RATE_UNIT if "scan_rate" in at else None
    return at.columns.get(name) if name not in SPELLED else None


def _angle(recordings: Recordings, quantity: str) -> NDArray[np.float64] | None:
    """Return an angle in radians."""
    at = recordings.at
    told = names_of(at.mount)
    own = {
        "az": at.az,
        "el": at.el,
        told.across: recordings.x,
        told.along: recordings.y,
        told.sigmas[1]: recordings.sigma_x,
        told.sigmas[2]: recordings.sigma_y,
    }
    if quantity in own:
        return own[quantity]
    if quantity == "d_zd" and "d_el" in own:
        return -recordings.y
    if quantity in {told.first, told.sigmas[0]}:
        across = recordings.x if quantity == told.first else recordings.sigma_x
        return across / np.cos(axes_of(at)[1])
    if quantity in DIRECTIONS and quantity in at:
        return at.column(quantity)
    if quantity in {"sun_az", "sun_el"}:
        return _sun(recordings, quantity)
    return None


def _sun(recordings: Recordings, quantity: str) -> NDArray[np.float64] | None:
    """Return the Sun's azimuth or elevation at the rows' times, None where they are unknown."""
    from pyport.effects.celestial import sun

    try:
        azimuth, elevation = sun(recordings.at)
    except MissingColumn:
        return None
    return azimuth if quantity == "sun_az" else elevation


def names(recordings: Recordings) -> list[str]:
    """Return the names that `column` knows here, angles in degrees."""
    kept = [SPELLED.get(name, name) for name in recordings.at.columns]
    told = names_of(recordings.at.mount)
    own = (told.across, told.along, *told.sigmas[1:])
    found = ["az_deg", "el_deg", *(f"{one}_deg" for one in own), *kept]
    if "sun_el_deg" not in found and column(recordings, "sun_el_deg") is not None:
        found += ["sun_az_deg", "sun_el_deg"]
    return [name for name in found if name not in {DAY, HOUR_OF_DAY}]
