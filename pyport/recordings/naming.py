"""The columns of recordings under the contract's names, in the units that those tell."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, RADIANS_PER
from pyport.arguments import SLIP, nearest
from pyport.columns import (
    COLUMNS,
    DAY,
    DIRECTIONS,
    HOUR_OF_DAY,
    LABEL,
    SCAN_RATE,
    SCAN_RATE_UNIT,
    SPELLED,
    TEXT,
    TIME,
    angle_of,
)
from pyport.effects import MissingColumn, Site
from pyport.effects.mounts import MOUNT
from pyport.errors import BadInput
from pyport.recordings.mounted import OFFSETS, axes_of, names_of
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
    if name == TIME:
        return at.columns.get("time")
    if name == SCAN_RATE:
        return at.columns["scan_rate"] / SCAN_RATE_UNIT if "scan_rate" in at else None
    return at.columns.get(name) if name not in SPELLED else None


def _angle(recordings: Recordings, quantity: str) -> NDArray[np.float64] | None:
    """Return an angle in radians."""
    at = recordings.at
    named = names_of(at.mount)
    own = {
        "az": at.az,
        "el": at.el,
        named.across: recordings.x,
        named.along: recordings.y,
        named.sigmas[1]: recordings.sigma_x,
        named.sigmas[2]: recordings.sigma_y,
    }
    if quantity in own:
        return own[quantity]
    if quantity == "d_zd" and "d_el" in own:
        return -recordings.y
    if quantity in {named.first, named.sigmas[0]}:
        across = recordings.x if quantity == named.first else recordings.sigma_x
        return across / np.cos(axes_of(at)[1])
    if quantity in DIRECTIONS and quantity in at:
        return at.column(quantity)
    if quantity in {"sun_az", "sun_el"}:
        return _sun(recordings, quantity)
    return None


def _sun(recordings: Recordings, quantity: str) -> NDArray[np.float64] | None:
    """Return the Sun's azimuth or elevation at the rows' times, None where they are unknown."""
    from pyport.effects.sky.frame import sun

    try:
        azimuth, elevation = sun(recordings.at)
    except MissingColumn:
        return None
    return azimuth if quantity == "sun_az" else elevation


def names(recordings: Recordings) -> list[str]:
    """Return the names that `column` knows here, angles in degrees."""
    kept = [SPELLED.get(name, name) for name in recordings.at.columns]
    named = names_of(recordings.at.mount)
    own = (named.across, named.along, *named.sigmas[1:])
    found = ["az_deg", "el_deg", *(f"{one}_deg" for one in own), *kept]
    if "sun_el_deg" not in found and column(recordings, "sun_el_deg") is not None:
        found += ["sun_az_deg", "sun_el_deg"]
    return [name for name in found if name not in {DAY, HOUR_OF_DAY}]


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
#: Words for keys of which others that are spelled nearly so are slips: none that are short, or that
#: comments on a site use for something else (`elevation_limit`, `altitude`).
_SPELLED_OUT = {
    **dict.fromkeys(
        ("latitude_deg", "latitude", "latitude_degrees", "latitude_north", "site_latitude"),
        "latitude_deg",
    ),
    **dict.fromkeys(
        ("longitude_deg", "longitude", "longitude_degrees", "east_longitude", "site_longitude"),
        "longitude_deg",
    ),
    **dict.fromkeys(("azimuth_zero", "zero_azimuth"), "azimuth_zero"),
    **dict.fromkeys(("highest_el_deg", "highest_el", "highest_elevation_deg"), "highest_el_deg"),
    **{one: one for one in ("largest_offset_deg", "bookkeeping")},
}
_SOMETHING_ELSE = frozenset({"altitude", "altitude_deg", "attitude"})
#: Longer ones are sentences.
LONGEST_KEY = 40
#: What a value says of azimuth's zero, whatever its key says of azimuth.
_ZERO = re.compile(r"(\w+ )?(from )?(the )?(north|south)( (through|over|via|to|towards) \w+)?")


def key_of(words: str) -> str:
    """Return a header key in which blanks or hyphens may stand for underscores."""
    return re.sub(r"[\s-]+", "_", words.strip())


def is_key(key: str, value: str) -> bool:
    """Tell whether a header key is one of the contract's, or nearly one."""
    known = {*KEYS, *_KEY, MOUNT, "bookkeeping"}
    return key.lower() in known or key_meant(key, value) is not None


def as_keys(meta: Mapping[str, str]) -> dict[str, str]:
    """Return header keys, those of the contract without blanks."""
    return {
        key_of(key) if is_key(key_of(key), value) else key: value for key, value in meta.items()
    }


def key_meant(key: str, value: str) -> str | None:
    """Return the contract's key that another one is a slip of, None for none."""
    small = key_of(key).lower()
    if len(small) > LONGEST_KEY or small in {*KEYS, *_SOMETHING_ELSE, "bookkeeping"}:
        return None
    if small.startswith("az"):
        zero = _ZERO.fullmatch(" ".join(value.lower().split()))
        return "azimuth_zero" if zero else None
    near = nearest(small, _SPELLED_OUT, SLIP)
    return None if near is None else _SPELLED_OUT[near]


def comment(line: str) -> tuple[str, str] | None:
    """Return the key and the value of a `# key: value` line, None for any other comment.

    Blanks in a key, and an equals sign in place of the colon, are understood of the contract's keys
    and of what is nearly one.
    """
    text = line.lstrip("#")
    for words, sign, value in (text.partition("="), text.partition(":")):
        key = key_of(words)
        if sign and key and is_key(key, value.strip()):
            return key, value.strip()
    key, colon, value = (part.strip() for part in text.partition(":"))
    return (key, value) if colon and key and " " not in key else None


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
    if key != name and (key == TIME or angle_of(key) is not None):
        return key
    return TIME if key in _TIMES else None


#: Conditions: under a name that is not known such a column is kept, as any other is.
_KEPT = frozenset(one.spelled for one in COLUMNS if one.spoken or one.kind == LABEL)


def _is_kept(name: str) -> bool:
    angle = angle_of(name)
    return name in _KEPT or (angle is not None and angle[0] in DIRECTIONS)


def refuse_columns(names: Iterable[str]) -> None:
    """Refuse a column of places, offsets or times whose name is nearly one of the contract's.

    An offset in a unit that is none, and in no other, would be lost.

    Raises `BadInput`: with the right name, and how to read the column under it.
    """
    there = dict.fromkeys(names)
    angles = {one[0] for one in map(angle_of, there) if one is not None}
    of_x_and_y = bool(angles & {"x", "y", "d_y", "d_xx"})
    for name in there:
        if of_x_and_y and angle_of(name) is not None:
            continue
        offset, _, unit = name.rpartition("_")
        if offset in OFFSETS - angles and unit.isalpha() and unit not in RADIANS_PER:
            wanted = ", ".join(one for one in RADIANS_PER if one != "h")
            raise BadInput(f"column {name!r}: {unit!r} is no unit, expected one of {wanted}")
        right = meant(name)
        if right is None or right in there or _is_kept(right):
            continue
        part = _TIMES.get(name.lower(), "")
        way = f"--columns '{right}={name}{f'|{part}' if part else ''}, ...' reads it"
        expected = "time_utc in ISO 8601" if right == TIME else right
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


def refuse_slips(keys: Mapping[str, str], how: str) -> None:
    """Refuse a header key that is a slip of the contract's; `how` says where it was given.

    Raises `BadInput`: with the right key.
    """
    for key, value in keys.items():
        right = key_meant(key, value)
        if right is not None:
            raise BadInput(f"{how}{key!r} is no key, did you mean {right!r}?")


#: Keys of a site, and how large each may be.
SITE = {"latitude_deg": 90.0, "longitude_deg": 360.0, "height_m": 1e5}

#: What makes an error of a message and, by name, the key that is wrong.
Wrong = Callable[..., BadInput]


def site_of(
    keys: Mapping[str, str], wrong: Wrong = lambda message, **_: BadInput(message)
) -> Site | None:
    """Return the site that keys tell, None where they tell no latitude.

    Raises `BadInput`: one of its numbers is none, or too large.
    """
    latitude, longitude, height = (number_of(keys, *one, wrong) for one in SITE.items())
    if latitude is None:
        return None
    east = None if longitude is None else longitude * DEG
    return Site(latitude * DEG, east, 0.0 if height is None else height)


def number_of(keys: Mapping[str, str], key: str, largest: float, wrong: Wrong) -> float | None:
    """Return the number under a key, None where the key is not there.

    Raises `BadInput`: it is none, or larger than the `largest`.
    """
    if key not in keys:
        return None
    try:
        value = float(keys[key])
    except ValueError:
        value = np.nan
    if not abs(value) <= largest:
        expected = f"a number between {-largest:g} and {largest:g}"
        raise wrong(f"{key} is {keys[key]!r}, expected {expected}", key=key)
    return value
