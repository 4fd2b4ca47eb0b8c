"""From judged cells to recordings: the contract's columns, one row for each printed cell."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pyport.angles import ARCMIN, DEG, HOUR, Array
from pyport.recordings import sky
from pyport.recordings.files import NAMES
from pyport.recordings.formats import csv
from pyport.recordings.schema import Table, iso_8601
from pyport.studies.gmrt import published
from pyport.studies.gmrt.published import (
    LATITUDE_DEG,
    LONGITUDE_DEG,
    SCAN_RATE_ARCMIN_PER_MIN,
    SESSIONS,
    Session,
    apparent_place,
    table_18,
    utc_seconds,
)
from pyport.studies.gmrt.recovery import printed
from pyport.studies.gmrt.recovery.cells import (
    CHANNELS_MHZ,
    NO_PEAK_FOUND,
    OUT_OF_LINE,
    Cell,
    cells,
    hold_channels_together,
)
from pyport.studies.gmrt.recovery.printed import expected_offsets

#: A row whose offsets lie farther from its antenna's published curve is another's [arcmin].
LABEL_AGREES = 2.5

#: An offset this far from what the scans around it tell is no peak or misprinted [arcmin].
IN_LINE = 4


def cells_down(session: Session) -> list[Cell]:
    """Return every cell of Table 13, excluded ones with a reason.

    Nearly all rows have a pair of cells too many, and end by printing the last
    pair twice; so a row is read from its start. A row that ends otherwise, or
    whose label the published curve contradicts, is excluded.
    """
    titles = printed.scans_across()
    slots = len(titles) * len(CHANNELS_MHZ)
    hour_angle = rising_hour_angle(session, np.array([el for _, el in titles]))
    curves = {wave.antenna: wave for wave in table_18() if wave.session == session.date}
    found: list[Cell] = []
    for row in printed.antennas_down():
        values = np.array([printed.number(text) for text in row.offsets[:slots]])
        reason = ""
        if not slots <= len(values) or not _ends_in_repetition(row.offsets, slots):
            reason = "columns lost in print: the row does not end with its last pair repeated"
        elif row.head[-1] in curves:
            curve = curves[row.head[-1]](np.repeat(hour_angle, 2)) / ARCMIN
            apart = float(np.nanmedian(np.abs(values - curve)))
            if apart > LABEL_AGREES:
                reason = "the row's label is doubtful: the published curve runs elsewhere"
        for place, text in enumerate(row.offsets):
            scan, channel = divmod(min(place, slots - 1), 2)
            direction, el = titles[scan]
            cell = Cell(row.number, row.column(place), text, scan + 1, el)
            cell.hour_angle_h = float(hour_angle[scan]) / HOUR
            cell.direction, cell.channel = direction, CHANNELS_MHZ[channel]
            cell.antenna = row.head[-1]
            cell.offset = printed.minutes(text)
            cell.set_aside = reason or _why_not(cell, place >= slots)
            found.append(cell)
    _hold_in_line(found, hour_angle)
    hold_channels_together(found)
    return found


def rising_hour_angle(session: Session, el_deg: Array) -> Array:
    """Return the hour angles [rad] of a rising source at printed elevations [deg]."""
    _, dec = apparent_place(session)
    return -sky.hour_angle_at(el_deg * DEG, dec, LATITUDE_DEG * DEG)


def _ends_in_repetition(offsets: tuple[str, ...], slots: int) -> bool:
    """Tell whether the cells beyond the slots repeat the last pair."""
    beyond = offsets[slots:]
    return len(beyond) <= 2 and beyond == offsets[slots - 2 : slots][: len(beyond)]


def _why_not(cell: Cell, beyond: bool) -> str:  # noqa: FBT001 - private
    """Return why a cell cannot be used, "" if it can."""
    if beyond:
        return "a cell too many: the row's last pair is printed twice"
    if cell.offset is None:
        return NO_PEAK_FOUND
    return ""


def _hold_in_line(found: list[Cell], hour_angle: Array) -> None:
    """Exclude what the scans around it contradict."""
    good = [cell for cell in found if not cell.set_aside]
    antennas = sorted({cell.antenna for cell in good})
    slots = 2 * len(hour_angle)
    offset = np.full((slots, len(antennas)), np.nan)
    direction = np.zeros(slots)
    for cell in good:
        slot = 2 * cell.scan - 2 + CHANNELS_MHZ.index(cell.channel or 0)
        offset[slot, antennas.index(cell.antenna)] = cell.offset
        direction[slot] = cell.direction
    scan = np.repeat(np.arange(len(hour_angle)), 2)
    expected = expected_offsets(
        offset,
        np.isfinite(offset).astype(float),
        hour_angle_h=np.repeat(hour_angle / HOUR, 2),
        direction=direction,
        scan=scan,
        stretch=np.zeros(slots),
    )
    for cell in good:
        slot = 2 * cell.scan - 2 + CHANNELS_MHZ.index(cell.channel or 0)
        apart = abs((cell.offset or 0) - expected[slot, antennas.index(cell.antenna)])
        if apart > IN_LINE:
            cell.set_aside = OUT_OF_LINE


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
