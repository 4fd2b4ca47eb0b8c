"""From printed tables to recordings: one cell, one row, and a reason where it is set aside."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from pyport.angles import DEG, HOUR, Array
from pyport.recordings import sky
from pyport.recordings.gmrt import printed
from pyport.recordings.gmrt.sessions import (
    ANTENNAS,
    LATITUDE_DEG,
    LONGITUDE_DEG,
    SCAN_RATE_ARCMIN_PER_MIN,
    Session,
    apparent_place,
    utc_seconds,
)
from pyport.recordings.tabulate import iso_8601

CHANNELS_MHZ = (130, 175)

#: Misread heads of rows: (table, printed row) -> the hour angle that the row's
#: elevation and its neighbours tell. 63 deg belongs to -1.23 h, not to -1.48 h.
HOUR_ANGLE_MISPRINTS = {(17, 28): -1.23}

#: The two channels of a scan see the same beam; more apart than this is no peak. [arcmin]
CHANNELS_AGREE = 2

#: How far an offset may lie from the median of its neighbours in the same direction [arcmin].
NEIGHBOURS_AGREE = 4

#: How many offsets before and after a scan are its neighbours.
NEIGHBOURS = 4


#: The table with a row for each antenna, and scans told by their elevation.
ANTENNAS_DOWN = 13


@dataclass
class Cell:
    """One printed offset: where it stands, what it says, whether it can be used."""

    row: int
    column: int
    text: str
    scan: int = 0
    el_printed: int | None = None
    hour_angle_h: float = np.nan
    direction: int = 0
    channel: int | None = None
    antenna: str = ""
    offset: int | None = None
    set_aside: str = ""


def cells(table: int) -> list[Cell]:
    """Return every printed offset of a table, those set aside with a reason."""
    found = list(_placed_down() if table == ANTENNAS_DOWN else _placed(table))
    _hold_channels_together(found)
    _hold_neighbours_together(found)
    return found


def scans(table: int) -> Iterator[tuple[int, float, list[printed.Row]]]:
    """Yield each scan: its number from 1, its hour angle [h] and its rows, a channel each."""

    def hour_angle(row: printed.Row) -> float:
        return HOUR_ANGLE_MISPRINTS.get((table, row.number), float(row.head[0]))

    for number, (ha, rows) in enumerate(groupby(printed.day(table), hour_angle), 1):
        yield number, ha, list(rows)


def _placed_down() -> Iterator[Cell]:
    """Yield every offset of Table 13; it has a scan where its row has a cell for each."""
    titles = printed.scans_across()
    for row in printed.antennas_down():
        whole = len(row.offsets) == len(titles) * len(CHANNELS_MHZ)
        for position, text in enumerate(row.offsets):
            cell = Cell(row.number, row.column(position), text, antenna=row.head[-1])
            if whole:
                scan, channel = divmod(position, len(CHANNELS_MHZ))
                sign, elevation = titles[scan]
                cell.scan, cell.channel = scan + 1, CHANNELS_MHZ[channel]
                cell.direction, cell.el_printed = sign, elevation
                _take(cell)
            else:
                count = f"{len(row.offsets)} offsets for {len(titles)} scans"
                cell.set_aside = f"columns lost in print: the row has {count}"
            yield cell


def _take(cell: Cell) -> None:
    """Read a cell whose place is known."""
    cell.offset = printed.minutes(cell.text)
    if cell.offset is None and printed.OFFSET.fullmatch(cell.text):
        cell.set_aside = "no peak found (printed as 999)"
    elif cell.offset is None:
        cell.set_aside = "not a sign and three digits in print"


def _placed(table: int) -> Iterator[Cell]:
    """Yield every offset; it has an antenna where its row has a cell for each."""
    for scan, hour_angle, rows in scans(table):
        for channel, row in zip(CHANNELS_MHZ, rows, strict=False):
            whole = len(row.offsets) == len(ANTENNAS)
            for position, text in enumerate(row.offsets):
                cell = Cell(row.number, row.column(position), text, scan, int(row.head[1]))
                cell.hour_angle_h, cell.channel = hour_angle, channel
                cell.direction = 1 if scan % 2 else -1
                if whole:
                    cell.antenna = ANTENNAS[position]
                    _take(cell)
                else:
                    count = f"{len(row.offsets)} offsets for {len(ANTENNAS)} antennas"
                    cell.set_aside = f"columns lost in print: the row has {count}"
                yield cell


def _hold_channels_together(found: Iterable[Cell]) -> None:
    """Set aside both channels of a scan where they disagree."""
    pairs: dict[tuple[int, str], list[Cell]] = {}
    for cell in found:
        if not cell.set_aside:
            pairs.setdefault((cell.scan, cell.antenna), []).append(cell)
    for pair in pairs.values():
        apart = max(c.offset or 0 for c in pair) - min(c.offset or 0 for c in pair)
        if apart > CHANNELS_AGREE:
            for cell in pair:
                cell.set_aside = f"the two channels disagree by {apart} arcmin"


def _hold_neighbours_together(found: Iterable[Cell]) -> None:
    """Set aside what lies far from the scans in the same direction before it and after it.

    One side is enough: between two scans new offsets may have been loaded.
    """
    tracks: dict[tuple[str, int], list[Cell]] = {}
    for cell in found:
        if not cell.set_aside:
            tracks.setdefault((cell.antenna, cell.direction), []).append(cell)
    for track in tracks.values():
        scan = np.array([cell.scan for cell in track])
        offset = np.array([cell.offset for cell in track], float)
        for here, cell in enumerate(track):
            before = offset[scan < cell.scan][-NEIGHBOURS:]
            after = offset[scan > cell.scan][:NEIGHBOURS]
            apart = [abs(offset[here] - np.median(side)) for side in (before, after) if side.size]
            if not apart or min(apart) > NEIGHBOURS_AGREE:
                cell.set_aside = "out of line with the scans before and after it"


def columns(session: Session) -> dict[str, list[str]]:
    """Return the contract's columns for one session."""
    found = cells(session.table)
    ra, dec = apparent_place(session)
    hour_angle = np.array([cell.hour_angle_h for cell in found]) * HOUR
    if session.table == ANTENNAS_DOWN:
        el = np.array([np.nan if c.el_printed is None else c.el_printed for c in found]) * DEG
        hour_angle = -sky.hour_angle_at(el, dec, LATITUDE_DEG * DEG)
    az, el = sky.horizon(hour_angle, np.full(len(found), dec), LATITUDE_DEG * DEG)
    return {
        "antenna": [cell.antenna for cell in found],
        "session": [session.date] * len(found),
        "source": [session.source.name] * len(found),
        "channel": [_known(cell.channel) for cell in found],
        "scan": [_known(cell.scan or None) for cell in found],
        "scan_axis": ["el"] * len(found),
        "scan_direction": [f"{cell.direction:+d}" for cell in found],
        "scan_rate_arcmin_per_min": [str(SCAN_RATE_ARCMIN_PER_MIN)] * len(found),
        "time_utc": iso_8601(np.round(utc_seconds(session, hour_angle))).astype("U19").tolist(),
        "hour_angle_h": _decimals(hour_angle / HOUR, 2),
        "ra_deg": [f"{ra / DEG:.5f}"] * len(found),
        "dec_deg": [f"{dec / DEG:.5f}"] * len(found),
        "az_deg": _decimals(az / DEG, 4),
        "el_deg": _decimals(el / DEG, 4),
        "el_printed_deg": [_known(cell.el_printed) for cell in found],
        "d_el_arcmin": ["" if cell.set_aside else _known(cell.offset) for cell in found],
        "table": [str(session.table)] * len(found),
        "printed_row": [str(cell.row) for cell in found],
        "printed_column": [str(cell.column) for cell in found],
        "printed": [cell.text for cell in found],
        "set_aside": [cell.set_aside for cell in found],
    }


def _known(number: int | None) -> str:
    """Return a number as text, blank where it is not known."""
    return "" if number is None else str(number)


def _decimals(values: Array, places: int) -> list[str]:
    """Return numbers as text with so many decimals, blank for NaN."""
    return ["" if np.isnan(value) else f"{value:.{places}f}" for value in values]


def header() -> dict[str, str]:
    """Return the header keys that all files share."""
    return {
        "telescope": "GMRT",
        "latitude_deg": f"{LATITUDE_DEG:.6f}",
        "longitude_deg": f"{LONGITUDE_DEG:.6f}",
        "azimuth_zero": "north",
        "source": "Lal, Ishwara-Chandra & Rao, The GMRT Antenna Pointing II, 2003, updated 2005",
    }
