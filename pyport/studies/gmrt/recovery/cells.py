"""Every printed cell judged: whose it is, how surely, and why it is excluded if it is.

An antenna that finds no peak reports a chance number. Where a row has the same
one as a row of another scan, and its neighbours besides, it was not measured
there. The earlier row is taken to be the original.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from pyport.angles import ARCMIN, HOUR, Array
from pyport.studies.gmrt.published import ANTENNAS, Session, table_18
from pyport.studies.gmrt.recovery import printed
from pyport.studies.gmrt.recovery.printed import NO_PEAK, Row, minutes
from pyport.studies.gmrt.recovery.recover import Numbers, Recovered, recover, sign_lost

#: No antenna that sees the source is off by more; such a number is chance [arcmin].
LARGEST_ARCMIN = 40

#: The run of equal cells that convinces, a chance number among them.
SHORTEST_RUN = 4

#: How far cells of the two rows may be displaced by those that were lost.
FARTHEST_SHIFT = 3


@dataclass(frozen=True)
class Repeat:
    """Cells `first` to `last` (exclusive, from 0) of a row that repeat another printed row."""

    row: int
    first: int
    last: int
    of: int


def repeats(rows: Sequence[Row], scans: Sequence[int]) -> list[Repeat]:
    """Return the runs of cells that repeat an earlier row of another scan."""
    found = []
    for later, row in enumerate(rows):
        for original, scan in zip(rows[:later], scans, strict=False):
            if scan != scans[later]:
                found += _common(row, original)
    return found


def _common(row: Row, original: Row) -> list[Repeat]:
    """Return the convincing runs that two rows share."""
    found = []
    for shift in range(-FARTHEST_SHIFT, FARTHEST_SHIFT + 1):
        first = 0
        while first < len(row.offsets):
            last = first
            while (
                last < len(row.offsets)
                and 0 <= last + shift < len(original.offsets)
                and row.offsets[last] == original.offsets[last + shift]
            ):
                last += 1
            run = row.offsets[first:last]
            if len(run) >= SHORTEST_RUN and any(map(_by_chance, run)):
                found.append(Repeat(row.number, first, last, original.number))
            first = max(last, first + 1)
    return found


def _by_chance(text: str) -> bool:
    """Tell whether a cell is a number that two scans do not share but by copying."""
    offset = minutes(text)
    return offset is not None and abs(offset) > LARGEST_ARCMIN and abs(offset) not in NO_PEAK


CHANNELS_MHZ = (130, 175)

#: Misread heads of rows: (table, printed row) -> the hour angle that the row's
#: elevation and its neighbours tell. 63 deg belongs to -1.23 h, not to -1.48 h.
HOUR_ANGLE_MISPRINTS = {(17, 28): -1.23}

#: A cell is vouched for from this probability on; see the test that garbles rows.
VOUCHED = 0.9

#: The two channels of a scan see the same beam; farther apart is no peak [arcmin].
CHANNELS_AGREE = 2

NO_PEAK_FOUND = "no peak found (printed as 999)"
OUT_OF_LINE = "no peak, or misprinted: out of line with the scans around it"


@dataclass
class Cell:
    """One printed offset, or an antenna's missing one (`column` and `text` blank)."""

    row: int
    column: int | None
    text: str
    scan: int
    el_printed: int
    hour_angle_h: float = math.nan
    direction: int = 0
    channel: int | None = None
    antenna: str = ""
    offset: int | None = None
    confidence: float | None = None
    set_aside: str = ""


@dataclass(frozen=True)
class Scan:
    """A scan: its number from 1, its hour angle [h], its rows (a channel each)."""

    number: int
    hour_angle_h: float
    rows: tuple[Row, ...]

    @property
    def direction(self) -> int:
        """Forward (+1) and reverse (-1) take turns, forward first: section 3 of the paper."""
        return 1 if self.number % 2 else -1

    def channel(self, row: Row) -> int | None:
        """Return a row's channel [MHz]; a row that lost its twin could be either."""
        return CHANNELS_MHZ[self.rows.index(row)] if len(self.rows) == 2 else None


def scans(table: int) -> list[Scan]:
    """Return the scans of one of the tables 14 to 17."""

    def hour_angle(row: Row) -> float:
        return HOUR_ANGLE_MISPRINTS.get((table, row.number), float(row.head[0]))

    groups = groupby(printed.day(table), hour_angle)
    return [Scan(number, ha, tuple(rows)) for number, (ha, rows) in enumerate(groups, 1)]


def numbers(session: Session) -> Numbers:
    """Return a day's table as numbers."""
    each = [(scan, row) for scan in scans(session.table) for row in scan.rows]
    offset = np.full((len(each), max(len(row.offsets) for _, row in each)), np.nan)
    for i, (_, row) in enumerate(each):
        offset[i, : len(row.offsets)] = [printed.number(text) for text in row.offsets]
    hour_angle_h = np.array([scan.hour_angle_h for scan, _ in each])
    return Numbers(
        offset,
        np.array([len(row.offsets) for _, row in each]),
        hour_angle_h,
        np.array([scan.direction for scan, _ in each], float),
        np.array([scan.number for scan, _ in each]),
        np.searchsorted(session.reloaded_at_h, hour_angle_h),
        _published(session, hour_angle_h),
    )


def _published(session: Session, hour_angle_h: Array) -> Array:
    """Return the published curves of a day [arcmin], shape (rows, antennas), NaN for none."""
    curve = np.full((len(hour_angle_h), len(ANTENNAS)), np.nan)
    for wave in table_18():
        if wave.session == session.date:
            curve[:, ANTENNAS.index(wave.antenna)] = wave(hour_angle_h * HOUR) / ARCMIN
    return curve


def cells(session: Session) -> list[Cell]:
    """Return every cell of one of the tables 14 to 17, excluded ones with a reason."""
    day = numbers(session)
    recovered = recover(day)
    each = [(scan, row) for scan in scans(session.table) for row in scan.rows]
    found: list[Cell] = []
    for i, (scan, row) in enumerate(each):
        placed = list(_placed(scan, row, recovered, i, day.published[i]))
        found += placed
        found += _lost(scan, row, placed)
    _set_aside_repeats(found, each)
    hold_channels_together(found)
    _set_aside_blind_antennas(found)
    return found


def _cell(scan: Scan, row: Row, column: int | None, text: str) -> Cell:
    place = row.number, column, text, scan.number, int(row.head[1])
    return Cell(*place, scan.hour_angle_h, scan.direction, scan.channel(row))


def _placed(scan: Scan, row: Row, recovered: Recovered, i: int, published: Array) -> Iterator[Cell]:
    for k, text in enumerate(row.offsets):
        cell = _cell(scan, row, row.column(k), text)
        best = int(recovered.column[i, k])
        belongs, trusted = float(recovered.belongs[i, k]), float(recovered.trusted[i, k])
        cell.confidence = round(min(belongs, 0.9999), 4)
        if belongs < VOUCHED:
            cell.set_aside = f"columns lost in print: whose it is is not sure ({ANTENNAS[best]}?)"
        else:
            cell.antenna = ANTENNAS[best]
            cell.offset = printed.minutes(text)
            if not printed.OFFSET.fullmatch(text):
                cell.set_aside = "not a sign and three digits in print"
            elif cell.offset is None:
                cell.set_aside = NO_PEAK_FOUND
            elif sign_lost(cell.offset, published[best]):
                cell.set_aside = "the sign contradicts the published curve, of the same size"
            elif trusted < VOUCHED:
                cell.set_aside = OUT_OF_LINE
        yield cell


def _lost(scan: Scan, row: Row, placed: Sequence[Cell]) -> Iterator[Cell]:
    present = {cell.antenna for cell in placed}
    for antenna in ANTENNAS:
        if antenna not in present:
            cell = _cell(scan, row, None, "")
            cell.antenna = antenna
            cell.set_aside = "columns lost in print: no cell of this row is surely this antenna's"
            yield cell


def _set_aside_repeats(found: Sequence[Cell], each: Sequence[tuple[Scan, Row]]) -> None:
    rows, numbers_of = [row for _, row in each], [scan.number for scan, _ in each]
    head = len(rows[0].head)
    for repeat in repeats(rows, numbers_of):
        for cell in found:
            if cell.row != repeat.row or cell.column is None or cell.set_aside:
                continue
            if repeat.first <= cell.column - head - 1 < repeat.last:
                cell.set_aside = f"repeats printed row {repeat.of}, a chance number included"


def hold_channels_together(found: Sequence[Cell]) -> None:
    """Exclude both channels of a scan where they disagree."""
    pairs: dict[tuple[int, str], list[Cell]] = {}
    for cell in found:
        if not cell.set_aside:
            pairs.setdefault((cell.scan, cell.antenna), []).append(cell)
    for pair in pairs.values():
        offsets = [cell.offset for cell in pair if cell.offset is not None]
        if max(offsets) - min(offsets) > CHANNELS_AGREE:
            for cell in pair:
                cell.set_aside = "the two channels disagree"


def _set_aside_blind_antennas(found: Sequence[Cell]) -> None:
    """Exclude an antenna that found no peak in half of its scans or more: chance fits in too."""
    for antenna in ANTENNAS:
        own = [cell for cell in found if cell.antenna == antenna]
        used = [cell for cell in own if not cell.set_aside]
        if len(used) <= sum(cell.set_aside in {NO_PEAK_FOUND, OUT_OF_LINE} for cell in own):
            for cell in used:
                cell.set_aside = "the antenna found no peak in half of its scans or more"
