"""From judged cells to recordings: the contract's columns, one row for each printed cell."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pyport.angles import DEG, HOUR, Array
from pyport.recordings import sky
from pyport.recordings.files import NAMES
from pyport.recordings.formats import csv
from pyport.recordings.tabulate import Table, iso_8601
from pyport.studies.gmrt import published
from pyport.studies.gmrt.recovery.cells import cells
from pyport.studies.gmrt.recovery.down import cells_down
from pyport.studies.gmrt.sessions import (
    LATITUDE_DEG,
    LONGITUDE_DEG,
    SCAN_RATE_ARCMIN_PER_MIN,
    SESSIONS,
    Session,
    apparent_place,
    utc_seconds,
)

#: The table that has an antenna a row.
ANTENNAS_DOWN = 13


def columns(session: Session) -> dict[str, list[str]]:
    """Return the contract's columns for one session."""
    found = cells_down(session) if session.table == ANTENNAS_DOWN else cells(session)
    ra, dec = apparent_place(session)
    hour_angle = np.array([cell.hour_angle_h for cell in found]) * HOUR
    az, el = sky.horizon(hour_angle, np.full(len(found), dec), LATITUDE_DEG * DEG)
    return {
        "antenna": [cell.antenna for cell in found],
        "session": [session.date] * len(found),
        "source": [session.source.name] * len(found),
        "channel": [_known(cell.channel) for cell in found],
        "scan": [str(cell.scan) for cell in found],
        "scan_axis": ["el"] * len(found),
        "scan_direction": [f"{cell.direction:+d}" for cell in found],
        "scan_rate_arcmin_per_min": [str(SCAN_RATE_ARCMIN_PER_MIN)] * len(found),
        "time_utc": iso_8601(np.round(utc_seconds(session, hour_angle))).astype("U19").tolist(),
        "hour_angle_h": _decimals(hour_angle / HOUR, 2),
        "ra_deg": [f"{ra / DEG:.5f}"] * len(found),
        "dec_deg": [f"{dec / DEG:.5f}"] * len(found),
        "az_deg": _decimals(az / DEG, 4),
        "el_deg": _decimals(el / DEG, 4),
        "el_printed_deg": [str(cell.el_printed) for cell in found],
        "d_el_arcmin": ["" if cell.set_aside else _known(cell.offset) for cell in found],
        "table": [str(session.table)] * len(found),
        "printed_row": [str(cell.row) for cell in found],
        "printed_column": [_known(cell.column) for cell in found],
        "printed": [cell.text for cell in found],
        "confidence": [_known(cell.confidence) for cell in found],
        "set_aside": [cell.set_aside for cell in found],
    }


def _known(number: float | None) -> str:
    """Return a number as text, blank where it is not known."""
    return "" if number is None else str(number)


def _decimals(values: Array, places: int) -> list[str]:
    """Return numbers as text with so many decimals, blank for NaN."""
    return ["" if np.isnan(value) else f"{value:.{places}f}" for value in values]


def header(dates: Sequence[str]) -> dict[str, str]:
    """Return the header keys of a file that holds these sessions."""
    keys = {
        "telescope": "GMRT",
        "latitude_deg": f"{LATITUDE_DEG:.6f}",
        "longitude_deg": f"{LONGITUDE_DEG:.6f}",
        "azimuth_zero": "north",
        "bookkeeping": "scan el_printed_deg table printed_row printed_column printed confidence",
        "origin": "Lal, Ishwara-Chandra & Rao, The GMRT Antenna Pointing II, 2003, updated 2005",
        "derived": "az, el, time, ra and dec, from date, hour angle, source and site",
    }
    if any(one.date in dates and one.table == ANTENNAS_DOWN for one in SESSIONS):
        keys["derived"] = "hour angle from the printed elevation (rising), and all that follows"
    return keys


def write_all(folder: Path) -> None:
    """Write the recordings of every shipped name, and Table 18, into a folder."""
    made = {session.date: columns(session) for session in SESSIONS}
    for name, dates in NAMES.items():
        days = [made[date] for date in dates]
        joined = {key: np.array([v for day in days for v in day[key]]) for key in days[0]}
        csv.write(Table(header(dates), joined), folder / f"{name}.csv")
    csv.write(published.table(), folder / published.NAME)
