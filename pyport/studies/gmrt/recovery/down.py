"""Table 13, printed the other way round: an antenna a row, the scans across, no hour angles."""

from __future__ import annotations

import numpy as np

from pyport.angles import ARCMIN, DEG, HOUR, Array
from pyport.recordings import sky
from pyport.studies.gmrt.published import table_18
from pyport.studies.gmrt.recovery import printed
from pyport.studies.gmrt.recovery.cells import (
    CHANNELS_MHZ,
    NO_PEAK_FOUND,
    OUT_OF_LINE,
    Cell,
    hold_channels_together,
)
from pyport.studies.gmrt.recovery.expect import expected_offsets
from pyport.studies.gmrt.sessions import LATITUDE_DEG, Session, apparent_place

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
