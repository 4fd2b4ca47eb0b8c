"""Names that are nearly the contract's: refused with the right one, never passed over."""

from __future__ import annotations

from collections.abc import Iterable

from pyport.errors import BadInput
from pyport.recordings.columns import angle_of

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
    **dict.fromkeys(("azimuth", "azimuth_deg", "az_true_deg"), "az_deg"),
    **dict.fromkeys(
        ("elevation", "elevation_deg", "alt", "alt_deg", "altitude", "altitude_deg", "el_true_deg"),
        "el_deg",
    ),
    **{
        f"{name}_{unit}": f"d_{ours}_{unit}"
        for unit in ("deg", "arcmin", "arcsec", "mdeg")
        for ours, names in {
            "xel": ("dxel", "d_x", "d_cross_el", "d_xelev", "delta_xel"),
            "az": ("daz", "d_azimuth", "d_azim", "delta_az"),
            "el": ("d_alt", "dalt", "del", "d_elevation", "d_elev", "delta_el", "delta_alt"),
            "zd": ("dzd", "d_za", "d_zenith_distance", "delta_zd"),
        }.items()
        for name in names
    },
    **dict.fromkeys(
        ("temperature", "temp_c", "temperature_deg_c", "air_temperature_c"), "temperature_c"
    ),
    **dict.fromkeys(("pressure", "pressure_mbar", "pressure_mb"), "pressure_hpa"),
    **dict.fromkeys(("humidity", "humidity_percent", "relative_humidity_pct"), "humidity_pct"),
    **dict.fromkeys(("wind_speed", "wind_m_s", "wind_speed_ms"), "wind_speed_m_s"),
    **dict.fromkeys(("wind_direction_deg", "wind_dir_deg", "wind_azimuth_deg"), "wind_az_deg"),
    **dict.fromkeys(("frequency", "freq_mhz"), "frequency_mhz"),
    **dict.fromkeys(("polarization", "pol"), "polarisation"),
}
#: Other counts of time, and how a map reads them.
_TIMES = {
    **dict.fromkeys(("time_mjd", "mjd", "mjd_utc", "time_mjd_utc"), "mjd"),
    **dict.fromkeys(("time_jd", "jd", "jd_utc", "time_jd_utc"), "jd"),
    **dict.fromkeys(("time_unix", "time_s", "unix_time", "timestamp"), "unix"),
    **dict.fromkeys(("utc", "time_iso", "time_ut", "datetime_utc", "date_obs"), ""),
}


def meant(name: str) -> str | None:
    """Return the contract's name that a column's is nearly, None for none."""
    key = name.lower()
    if key in _COLUMN:
        return _COLUMN[key]
    return "time_utc" if key in _TIMES else None


#: Conditions: under a name that is not known such a column is kept, as any other is.
_KEPT = frozenset(
    {
        *("temperature_c", "pressure_hpa", "humidity_pct", "wind_speed_m_s", "wind_az_deg"),
        *("frequency_mhz", "polarisation"),
    }
)


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
