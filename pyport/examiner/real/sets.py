"""The sets of public recordings: read by readers of the examiner's own, as arrays and tables."""

from __future__ import annotations

import csv
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.examiner import program, terms
from pyport.examiner.terms import Array

#: Recordings further apart than this are of different nights, where none says which. [h]
NIGHT_H = 6.0
_ARCSEC = {"deg": 3600.0, "arcmin": 60.0, "arcsec": 1.0}


@dataclass(frozen=True)
class Recordings:
    """n pointings of a set, as the examiner reads them, and what it asks of them.

    Attributes
    ----------
    name, source
        What the set is called, and where it is from.
    table, header
        The recordings as the program is given them.
    az, el, x, y
        Azimuth from north and elevation [rad], offsets across and along [arcsec], NaN for none.
    night
        Labels: the sessions, or nights by gaps in time; one where neither is known.
    group
        Which rows share coefficients: an antenna in a session, or all, "".
    model
        The model that is fitted, in the program's name.
    hour_angle
        Where the model is a wave in it [rad].
    file
        The file as it was published; None where the set is no single one.
    facts
        What was published of the set, and how it is looked for.
    public
        Whether it is another telescope's: subsets of a few rows are drawn of those.
    """

    name: str
    table: dict[str, Any]
    header: dict[str, float | str]
    az: Array
    el: Array
    x: Array
    y: Array
    night: NDArray[Any]
    group: NDArray[Any]
    model: str = "altaz"
    hour_angle: Array | None = None
    file: Path | None = None
    facts: tuple[dict[str, Any], ...] = ()
    public: bool = True
    source: str = ""
    step_arcsec: float = 0.0
    said: dict[str, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        """Return n."""
        return len(self.el)

    @property
    def names(self) -> tuple[str, ...]:
        """Return the coefficients of the model."""
        return terms.ALTAZ if self.hour_angle is None else terms.HOUR_ANGLE

    def columns(self) -> Array:
        """Return the columns of the model, shape (n, 2, k)."""
        if self.hour_angle is None:
            return terms.altaz(self.az, self.el)
        return terms.hour_angle(self.hour_angle)

    def offsets(self) -> Array:
        """Return the offsets [arcsec], shape (n, 2)."""
        return np.stack([self.x, self.y], axis=1)

    def take(self, rows: NDArray[Any]) -> Recordings:
        """Return some of the rows."""
        return replace(
            self,
            table={name: np.asarray(cells)[rows] for name, cells in self.table.items()},
            **{name: getattr(self, name)[rows] for name in ("az", "el", "x", "y")},
            night=self.night[rows],
            group=self.group[rows],
            hour_angle=None if self.hour_angle is None else self.hour_angle[rows],
            file=None,
        )


def catalogue() -> list[dict[str, Any]]:
    """Return what is known of every set, from the table of published facts."""
    text = (Path(__file__).parent / "published.toml").read_text(encoding="utf-8")
    found: list[dict[str, Any]] = tomllib.loads(text)["set"]
    return found


def read(entry: dict[str, Any], data: Path | None) -> Recordings | str:
    """Return the recordings of a set, or why they are not there."""
    if entry["format"] == "shipped":
        files = [program.shipped(entry["files"][0])]
    elif entry["format"] == "simulated":
        return _finish(entry, *_simulated(), None)
    elif data is None:
        return "no folder of data"
    else:
        files = [data / name for name in entry["files"]]
    missing = [str(file) for file in files if not file.is_file()]
    if missing:
        return f"not there: {', '.join(missing)}"
    reader = READERS[entry["format"]]
    tables, headers = zip(*(reader(file) for file in files), strict=True)
    joined = {
        name: np.concatenate([one[name] for one in tables])
        for name in tables[0]
        if all(name in one for one in tables)
    }
    return _finish(entry, joined, headers[0], files[0] if len(files) == 1 else None)


def _finish(
    entry: dict[str, Any],
    table: dict[str, NDArray[Any]],
    header: dict[str, float | str],
    file: Path | None,
) -> Recordings:
    header = header | entry.get("header", {})
    el = np.radians(_numbers(table["el_deg"]))
    turn = np.pi if header.get("azimuth_zero") == "south" else 0.0
    az = np.radians(_numbers(table["az_deg"])) + turn
    across, step_x = _angle(table, "d_xel")
    around, step_a = _angle(table, "d_az")
    along, step_y = _angle(table, "d_el")
    x = np.where(np.isfinite(across), across, around * np.cos(el))
    kept = np.isfinite(x) | np.isfinite(along)
    if "set_aside" in table:
        kept &= table["set_aside"] == ""
    night = _nights(table)
    wave = entry.get("model") == "gmrt-paper"
    dropped = entry.get("drop", [])
    table = {name: cells for name, cells in table.items() if name not in dropped}
    group = np.full(len(el), "", dtype="U40")
    if wave:
        group = np.char.add(np.char.add(table["antenna"], "|"), table["session"])
    hour = np.radians(15 * _numbers(table["hour_angle_h"])) if wave else None
    found = Recordings(
        entry["name"], table, header, az, el, x, along, night, group,
        model=entry.get("model", "altaz"),
        hour_angle=hour,
        facts=tuple(entry.get("fact", ())),
        public=entry["format"] not in {"shipped", "simulated"},
        source=entry.get("source", ""),
        step_arcsec=min([one for one in (step_x, step_a, step_y) if one > 0], default=0.0),
    )  # fmt: skip
    return replace(found.take(np.flatnonzero(kept)), file=None if dropped else file)


def _angle(table: dict[str, NDArray[Any]], name: str) -> tuple[Array, float]:
    """Return an offset of the table [arcsec], NaN where it is not measured, and its last digit."""
    for unit, arcsec in _ARCSEC.items():
        if f"{name}_{unit}" in table:
            cells = table[f"{name}_{unit}"].astype(str)
            digits = max(len(one.partition(".")[2]) for one in cells.tolist())
            return _numbers(cells) * arcsec, 10.0**-digits * arcsec
    return np.full(len(next(iter(table.values()))), np.nan), 0.0


def _numbers(cells: NDArray[Any]) -> Array:
    return np.array([float(one) if str(one).strip() else np.nan for one in cells.tolist()])


def _nights(table: dict[str, NDArray[Any]]) -> NDArray[Any]:
    if "session" in table:
        return table["session"]
    if "time_utc" in table:
        time = table["time_utc"].astype("datetime64[ms]")
        order = np.argsort(time, kind="stable")
        gap = np.diff(time[order], prepend=time[order[0]]) / np.timedelta64(1, "h")
        night = np.empty(len(time), dtype=int)
        night[order] = np.cumsum(gap > NIGHT_H)
        return night.astype(str)
    return np.full(len(next(iter(table.values()))), "one")


def _csv(file: Path) -> tuple[dict[str, NDArray[Any]], dict[str, float | str]]:
    """Read recordings in the program's format, as text."""
    lines = file.read_text(encoding="utf-8").splitlines()
    header = {}
    for line in lines:
        if match := re.match(r"#\s*([a-z_]+):\s*(.*)", line):
            header[match[1]] = match[2].strip()
    names, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    keys = {"latitude_deg", "longitude_deg", "height_m", "azimuth_zero", "telescope"}
    return (
        {name: np.array(cells) for name, cells in zip(names, zip(*rows, strict=True), strict=True)},
        {key: value for key, value in header.items() if key in keys},
    )


def _tpoint(file: Path) -> tuple[dict[str, NDArray[Any]], dict[str, float | str]]:
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


def _tpoint_equatorial(file: Path) -> tuple[dict[str, NDArray[Any]], dict[str, float | str]]:
    """Read TPOINT's format 1: RA and Dec of the star and as observed, and the sidereal time."""
    lines = [line.split() for line in file.read_text(encoding="utf-8").splitlines()[1:]]
    latitude, rows = None, []
    for words in lines:
        if not words or words[0] in {":", "END"}:
            continue
        if latitude is None:
            latitude = _sexagesimal(words[:3])
            continue
        ra, ra_read = (15 * _sexagesimal(words[n : n + 3]) for n in (0, 6))
        dec, dec_read = (_sexagesimal(words[n : n + 3]) for n in (3, 9))
        lst = 15 * (float(words[12]) + float(words[13]) / 60)
        true = _horizontal(lst - ra, dec, latitude)
        read_ = _horizontal(lst - ra_read, dec_read, latitude)
        turn = (read_[0] - true[0] + 180) % 360 - 180
        rows.append((*true, 3600 * turn, 3600 * (read_[1] - true[1])))
    names = ("az_deg", "el_deg", "d_az_arcsec", "d_el_arcsec")
    table = {
        name: np.array([f"{one:.6f}" for one in cells])
        for name, cells in zip(names, zip(*rows, strict=True), strict=True)
    }
    return table, {"latitude_deg": latitude or 0.0}


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


def _no_header(file: Path) -> tuple[dict[str, NDArray[Any]], dict[str, float | str]]:
    """Read a list without names: date, UT h, number, source, az, el, and offsets with errors."""
    rows = list(csv.reader(file.read_text(encoding="utf-8").splitlines()))
    columns = [np.array(cells) for cells in zip(*rows, strict=True)]
    hours = _numbers(columns[1])
    time = columns[0].astype("datetime64[ms]") + (hours * 3.6e6).round().astype("timedelta64[ms]")
    names = ("az_deg", "el_deg", "d_xel_arcsec", "sigma_xel_arcsec", "d_el_arcsec")
    table = dict(zip((*names, "sigma_el_arcsec"), columns[4:10], strict=True))
    return table | {"time_utc": time.astype(str), "session": columns[0], "source": columns[3]}, {}


def _katpoint(file: Path) -> tuple[dict[str, NDArray[Any]], dict[str, float | str]]:
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


def _simulated() -> tuple[dict[str, NDArray[Any]], dict[str, float | str]]:
    """Let the program make its stand-in for a campaign that was never published."""
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-m", "pyport", "rt32", "--out", folder, "--quiet"]
        subprocess.run(words, check=True, capture_output=True)  # noqa: S603 - this program
        (file,) = Path(folder).glob("*.csv")
        return _csv(file)


#: Format -> how it is read.
READERS: dict[str, Callable[[Path], tuple[dict[str, NDArray[Any]], dict[str, float | str]]]] = {
    "recordings": _csv,
    "shipped": _csv,
    "tpoint": _tpoint,
    "tpoint-equatorial": _tpoint_equatorial,
    "no-header": _no_header,
    "katpoint": _katpoint,
}
