"""Readers of the formats that the public recordings come in, the examiner's own.

Each returns columns as text under the program's names, and what the header says.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pyport.examiner.scores import Array

#: Columns as text, and what holds for all rows.
Read: TypeAlias = tuple[dict[str, NDArray[Any]], dict[str, float | str]]


def numbers(cells: NDArray[Any]) -> Array:
    """Return a column of text as numbers, NaN for blank."""
    return np.array([float(one) if str(one).strip() else np.nan for one in cells.tolist()])


def recordings(file: Path) -> Read:
    """Read recordings in the program's format."""
    lines = file.read_text(encoding="utf-8").splitlines()
    header = {}
    for line in lines:
        if match := re.match(r"#\s*([a-z_]+):\s*(.*)", line):
            header[match[1]] = match[2].strip()
    names, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    keys = {"latitude_deg", "longitude_deg", "height_m", "azimuth_zero", "telescope", "bookkeeping"}
    return (
        {name: np.array(cells) for name, cells in zip(names, zip(*rows, strict=True), strict=True)},
        {key: value for key, value in header.items() if key in keys},
    )


def _tpoint(file: Path) -> Read:
    """Read TPOINT's format 4 with : ALTAZ: azimuth, elevation, and those that were read [deg].

    Lines behind a `;` are excluded by the observers.
    """
    lines = file.read_text(encoding="utf-8").splitlines()[1:]
    stars, site = [], ""
    for line in lines:
        words = line.split(";")[0].split()
        if not words or line[0] in ":;!" or words[0] == "END":
            continue
        if not site:
            site = " ".join(words[:3])
            continue
        stars.append([float(one) for one in words[:4]])
    az, el, az_read, el_read = np.array(stars).T
    turn = (az_read - az + 180) % 360 - 180
    table = {"az_deg": az, "el_deg": el, "d_az_arcsec": 3600 * turn}
    table["d_el_arcsec"] = 3600 * (el_read - el)
    rounded = {name: np.char.mod("%.7f", cells) for name, cells in table.items()}
    return rounded, {"latitude_deg": _sexagesimal(site.split())}


def _tpoint_equatorial(file: Path) -> Read:
    """Read TPOINT's format 1: RA and Dec of the star and as observed, and the sidereal time.

    The star stands higher by the air's refraction, as the run's weather says: no telescope's
    reading knows of the air.
    """
    lines = [line.split() for line in file.read_text(encoding="utf-8").splitlines()[1:]]
    latitude, air, rows = None, 0.0, []
    for words in lines:
        if not words or words[0] in {":", "END"}:
            continue
        if latitude is None:
            latitude, air = _sexagesimal(words[:3]), _radio_refractivity(words)
            continue
        ra, ra_read = (15 * _sexagesimal(words[n : n + 3]) for n in (0, 6))
        dec, dec_read = (_sexagesimal(words[n : n + 3]) for n in (3, 9))
        lst = 15 * (float(words[12]) + float(words[13]) / 60)
        az, el = _horizontal(lst - ra, dec, latitude)
        true = (az, el + air / np.tan(np.radians(el + air / np.tan(np.radians(el)))))
        read_ = _horizontal(lst - ra_read, dec_read, latitude)
        turn = (read_[0] - true[0] + 180) % 360 - 180
        rows.append((*true, 3600 * turn, 3600 * (read_[1] - true[1])))
    names = ("az_deg", "el_deg", "d_az_arcsec", "d_el_arcsec")
    table = {
        name: np.array([f"{one:.6f}" for one in cells])
        for name, cells in zip(names, zip(*rows, strict=True), strict=True)
    }
    return table, {"latitude_deg": latitude or 0.0}


def _radio_refractivity(words: Sequence[str]) -> float:
    """Return (n - 1) of the air [deg] from a run's weather: Rueger 2002, Magnus for the vapour."""
    celsius, hpa, humidity = float(words[6]), float(words[7]), float(words[9])
    kelvin = celsius + 273.15
    vapour = humidity * 6.112 * np.exp(17.62 * celsius / (243.12 + celsius))
    n = 77.689 * (hpa - vapour) / kelvin + 71.295 * vapour / kelvin + 375463 * vapour / kelvin**2
    return float(np.degrees(n * 1e-6))


def _horizontal(hour_deg: float, dec_deg: float, latitude_deg: float) -> tuple[float, float]:
    hour, dec, phi = np.radians([hour_deg, dec_deg, latitude_deg])
    up = np.sin(phi) * np.sin(dec) + np.cos(phi) * np.cos(dec) * np.cos(hour)
    north = np.cos(phi) * np.sin(dec) - np.sin(phi) * np.cos(dec) * np.cos(hour)
    az = np.arctan2(-np.cos(dec) * np.sin(hour), north)
    return float(np.degrees(az) % 360), float(np.degrees(np.arcsin(up)))


def _sexagesimal(words: Sequence[str]) -> float:
    sign = -1.0 if words[0].startswith("-") else 1.0
    parts = [abs(float(one)) for one in words]
    return sign * sum(part / 60**n for n, part in enumerate(parts))


def _no_header(file: Path) -> Read:
    """Read a list without names: date, UT h, number, source, az, el, and offsets with errors."""
    rows = list(csv.reader(file.read_text(encoding="utf-8").splitlines()))
    columns = [np.array(cells) for cells in zip(*rows, strict=True)]
    hours = numbers(columns[1])
    time = columns[0].astype("datetime64[ms]") + (hours * 3.6e6).round().astype("timedelta64[ms]")
    names = ("az_deg", "el_deg", "d_xel_arcsec", "sigma_xel_arcsec", "d_el_arcsec")
    table = dict(zip((*names, "sigma_el_arcsec"), columns[4:10], strict=True))
    return table | {"time_utc": time.astype(str), "session": columns[0], "source": columns[3]}, {}


def _katpoint(file: Path) -> Read:
    """Read a dish's list of offsets: azimuth offsets are those of the coordinate [deg]."""
    lines = file.read_text(encoding="utf-8").splitlines()
    site = [one.strip() for one in lines[0].split(",")]
    rows = csv.DictReader(lines[1:], skipinitialspace=True)
    names = {
        "timestamp_ut": "time_utc",
        "target": "source",
        "azimuth": "az_deg",
        "elevation": "el_deg",
        "delta_azimuth": "d_az_deg",
        "delta_elevation": "d_el_deg",
    }
    found: dict[str, list[str]] = {name: [] for name in names.values()}
    for row in rows:
        for theirs, ours in names.items():
            found[ours].append(row[theirs].strip())
    found["time_utc"] = [one.replace(" ", "T") for one in found["time_utc"]]
    header = {"latitude_deg": _sexagesimal(site[1].split(":"))}
    header["longitude_deg"] = _sexagesimal(site[2].split(":"))
    return {name: np.array(cells) for name, cells in found.items()}, dict(header)


#: Format -> how it is read.
READERS: dict[str, Callable[[Path], Read]] = {
    "recordings": recordings,
    "shipped": recordings,
    "tpoint": _tpoint,
    "tpoint-equatorial": _tpoint_equatorial,
    "no-header": _no_header,
    "katpoint": _katpoint,
}
