"""Names that are nearly the contract's: refused with the right one, never passed over."""

from __future__ import annotations

from collections.abc import Iterable

from pyport.columns import COLUMNS, LABEL, TEXT, angle_of
from pyport.errors import BadInput

#: Header keys of the contract.
KEYS = frozenset(
    {
        "latitude_deg",
        "longitude_deg",
        "height_m",
        "azimuth_zero",
        "telescope",
        "highest_el_deg",
        "largest_offset_deg",
    }
)
#: What other programs call them.
_KEY = {
    **dict.fromkeys(
        ("latitude", "lat", "lat_deg", "site_latitude", "phi", "phi_deg"), "latitude_deg"
    ),
    **dict.fromkeys(("longitude", "lon", "long", "lon_deg", "east_longitude"), "longitude_deg"),
    **dict.fromkeys(("height", "altitude_m", "elevation_m", "site_height"), "height_m"),
    **dict.fromkeys(("az_zero", "azimuth_origin", "zero_azimuth", "azimuth_from"), "azimuth_zero"),
    **dict.fromkeys(("highest_elevation_deg", "max_el_deg", "highest_el"), "highest_el_deg"),
}
#: What other programs call columns, and what is expected.
_COLUMN = {
    f"{theirs}{unit}": f"{one.name}{unit}" if unit else one.spelled
    for one in COLUMNS
    if one.kind != TEXT
    for theirs in one.also
    for unit in (("_deg", "_arcmin", "_arcsec", "_mdeg") if one.name.startswith("d_") else ("",))
}
#: Other counts of time, and how a map reads them.
_TIMES = {
    **dict.fromkeys(("time_mjd", "mjd", "mjd_utc", "time_mjd_utc"), "mjd"),
    **dict.fromkeys(("time_jd", "jd", "jd_utc", "time_jd_utc"), "jd"),
    **dict.fromkeys(("time_unix", "time_s", "unix_time", "timestamp"), "unix"),
    **{theirs: "" for one in COLUMNS if one.kind == TEXT for theirs in one.also},
}


def meant(name: str) -> str | None:
    """Return the contract's name that a column's is nearly, None for none."""
    key = name.lower()
    if key in _COLUMN:
        return _COLUMN[key]
    return "time_utc" if key in _TIMES else None


#: Conditions: under a name that is not known such a column is kept, as any other is.
_KEPT = frozenset(one.spelled for one in COLUMNS if one.spoken or one.kind == LABEL)


def refuse_columns(names: Iterable[str]) -> None:
    """Refuse a column of places, offsets or times whose name is nearly one of the contract's.

    Raises `BadInput`: with the right name, and how to read the column under it.
    """
    there = set(names)
    angles = {one[0] for one in map(angle_of, there) if one is not None}
    of_x_and_y = bool(angles & {"x", "y", "d_y", "d_xx"})
    for name in there:
        if of_x_and_y and angle_of(name) is not None:
            continue
        right = meant(name)
        if right is None or right in there or right in _KEPT:
            continue
        part = _TIMES.get(name.lower(), "")
        way = f"--columns '{right}={name}{f'|{part}' if part else ''}, ...' reads it"
        expected = "time_utc in ISO 8601" if right == "time_utc" else right
        raise BadInput(f"column {name!r} is not known, did you mean {expected}? {way}")


def refuse_keys(keys: Iterable[str], how: str) -> None:
    """Refuse a header key that is nearly one of the contract's; `how` says where it was given.

    Raises `BadInput`: with the right key.
    """
    for key in keys:
        right = _KEY.get(key.lower())
        if right is not None:
            raise BadInput(f"{how}{key!r} is no key, did you mean {right!r}?")
        if key not in KEYS and key.lower() in KEYS:
            raise BadInput(f"{how}{key!r} is no key, did you mean {key.lower()!r}?")
