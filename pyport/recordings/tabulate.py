"""From recordings back to columns, under the contract's names and in its units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG
from pyport.columns import AXES, COLUMNS, SET_ASIDE, TIME
from pyport.recordings.mounted import names_of
from pyport.recordings.schema import Recordings

#: Columns of the program -> the contract's name and the radians (or s) of one of its units.
_UNITS = {
    **{name: (f"{name}_deg", DEG) for name in AXES},
    **{one.name: (one.written, one.scale) for one in COLUMNS if one.spoken and one.written},
}


@dataclass(frozen=True)
class Table:
    """What a file of recordings holds: header keys, and columns of numbers or text."""

    meta: dict[str, str]
    columns: dict[str, NDArray[Any]]


def tabulate(recordings: Recordings) -> Table:
    """Return the columns that a file of these recordings has, excluded rows at the end."""
    at = recordings.at
    columns: dict[str, NDArray[Any]] = {"az_deg": at.az / DEG, "el_deg": at.el / DEG}
    names = names_of(at.mount)
    offsets = {
        f"{names.across}_deg": recordings.x,
        f"{names.along}_deg": recordings.y,
        f"{names.sigmas[1]}_deg": recordings.sigma_x,
        f"{names.sigmas[2]}_deg": recordings.sigma_y,
    }
    for name, values in offsets.items():
        if name.startswith("d_") or np.isfinite(values).any():
            columns[name] = values / DEG
    for name, values in at.columns.items():
        if name == "time":
            columns[TIME] = iso_8601(values)
        else:
            label, unit = _UNITS.get(name, (name, 1.0))
            columns[label] = values if values.dtype.kind == "U" else values / unit
    if recordings.set_aside:
        columns = {name: _lengthen(v, len(recordings.set_aside)) for name, v in columns.items()}
        reasons = [aside.reason for aside in recordings.set_aside]
        columns[SET_ASIDE] = np.array([""] * len(recordings) + reasons, np.str_)
    return Table(_meta(recordings), columns)


def _meta(recordings: Recordings) -> dict[str, str]:
    """Return the header keys, with the azimuth's zero as it is written."""
    meta = {k: v for k, v in recordings.meta.items() if k != "azimuth_zero"}
    site = recordings.at.site
    if site is not None and "latitude_deg" not in meta:
        meta["latitude_deg"] = f"{site.latitude / DEG:.15g}"
        if site.longitude is not None:
            meta["longitude_deg"] = f"{site.longitude / DEG:.15g}"
        meta["height_m"] = f"{site.height_m:.15g}"
    return meta


def iso_8601(seconds: NDArray[np.float64]) -> NDArray[np.str_]:
    """Return seconds since 1970 as ISO 8601 in UTC to the microsecond, "" for NaN."""
    micro = np.round(np.nan_to_num(seconds) * 1e6).astype("datetime64[us]")
    return np.where(np.isnan(seconds), "", np.datetime_as_string(micro, timezone="UTC"))


def _lengthen(values: NDArray[Any], by: int) -> NDArray[Any]:
    """Return a column with blank cells added."""
    blank = np.full(by, "" if values.dtype.kind == "U" else np.nan)
    return np.concatenate([values, blank])
