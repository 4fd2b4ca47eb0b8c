"""The contract's columns: what each name means and in which unit it comes."""

from __future__ import annotations

from pyport.angles import ARCMIN, RADIANS_PER
from pyport.mounts import KINDS

#: Angles of the axes of mounts, and offsets from them.
AXES = frozenset(axis.column for mount in KINDS.values() for axis in mount.axes)
_OFFSETS = {
    name
    for mount in KINDS.values()
    for name in (mount.first.offset, mount.across_column, mount.second.offset)
}

#: Angles: each is a column `NAME_UNIT`, for instance `az_deg` or `d_el_arcmin`.
ANGLES = frozenset(
    {
        *AXES,
        *_OFFSETS,
        *(f"sigma_{one.removeprefix('d_')}" for one in _OFFSETS),
        *("d_zd", "hour_angle", "ra", "dec", "wind_az", "sun_az", "sun_el"),
    }
)
#: Short names of angles.
ALIASES = {"ha": "hour_angle"}

#: Angles that are also told in hours.
HOURLY = frozenset({"hour_angle", "ra"})

#: Numbers whose unit is a fixed part of their name.
NUMBERS = frozenset(
    {
        "scan_direction",
        "temperature_c",
        "pressure_hpa",
        "humidity_pct",
        "wind_speed_m_s",
        "frequency_mhz",
    }
)

#: Labels, kept as text even where they look like numbers.
LABELS = frozenset(
    {
        "antenna",
        "session",
        "receiver",
        "channel",
        "polarisation",
        "source",
        "scan_axis",
        "pier_side",
    }
)

TIME = "time_utc"
#: A day and an hour of it, which together are a time.
DAY, HOUR_OF_DAY = "date_utc", "ut_h"
SCAN_RATE = "scan_rate_arcmin_per_min"
SCAN_RATE_UNIT = ARCMIN / 60

#: Why a row is not to be used, blank where it is.
SET_ASIDE = "set_aside"

#: Names inside the program that a file cannot use without saying a unit.
RESERVED = {"time": TIME, "scan_rate": SCAN_RATE}


def angle_of(name: str) -> tuple[str, float] | None:
    """Return the angle that a column `NAME_UNIT` holds and the radians in one of its units.

    None where the name is no angle of the contract.
    """
    quantity, _, unit = name.rpartition("_")
    quantity = ALIASES.get(quantity, quantity)
    if quantity not in ANGLES or unit not in RADIANS_PER:
        return None
    if unit == "h" and quantity not in HOURLY:
        return None
    return quantity, RADIANS_PER[unit]
