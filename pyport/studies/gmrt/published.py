"""Table 18: the paper's own fits of a + b cos(15 HA + d), antenna by antenna and day by day."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pyport.angles import ARCMIN, DEG, HOUR, Array
from pyport.recordings.schema import Table
from pyport.studies.gmrt.recovery import printed

#: Reference position of the array, from the observatory's antenna header.
LATITUDE_DEG = 19 + 5 / 60 + 47.46 / 3600
LONGITUDE_DEG = 74 + 2 / 60 + 59.07 / 3600

#: Antennas in the order of the tables' columns.
ANTENNAS = tuple(
    f"{arm}{number:02d}"
    for arm, numbers in (
        ("C", (0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 11, 12, 13, 14)),
        ("E", (2, 3, 4, 5, 6)),
        ("S", (1, 2, 3, 4, 6)),
        ("W", (1, 2, 3, 4, 5, 6)),
    )
    for number in numbers
)

#: Rate of every scan, section 3 of the paper.
SCAN_RATE_ARCMIN_PER_MIN = 20


@dataclass(frozen=True)
class Source:
    """A source and its J2000 place [deg]."""

    name: str
    ra_deg: float
    dec_deg: float


CRAB = Source("Crab", 15 * (5 + 34 / 60 + 31.94 / 3600), 22 + 0 / 60 + 52.2 / 3600)
CYG_A = Source("Cyg A", 15 * (19 + 59 / 60 + 28.3566 / 3600), 40 + 44 / 60 + 2.097 / 3600)


@dataclass(frozen=True)
class Session:
    """One day of scans: the date it began (UTC), its source and the table that holds it.

    The captions stand one table off (the first block bears the caption of
    Table 13, the second that of Table 15, the last none): the README tells how
    the declination and Table 18 decide. At the hour angles `reloaded_at_h` all
    antennas step at once, as they do when new offsets are loaded (section 3, x).
    """

    date: str
    source: Source
    table: int
    reloaded_at_h: tuple[float, ...] = ()


SESSIONS = (
    Session("2003-03-31", CRAB, 13),
    Session("2003-05-31", CRAB, 14, (-1.2,)),
    Session("2003-06-01", CYG_A, 15),
    Session("2003-06-02", CYG_A, 16),
    Session("2003-06-05", CYG_A, 17),
)

#: TT - UTC in 2003 [days].
_TT_MINUS_UTC = 64.184 / 86400

#: Sidereal seconds in a second of UT1.
_SIDEREAL = 1.00273790935


def _midnight(date: str) -> tuple[float, float]:
    """Return 0h UTC of a date as a two-part Julian date."""
    import erfa

    year, month, day = map(int, date.split("-"))
    start: tuple[float, float] = erfa.cal2jd(year, month, day)
    return start


def apparent_place(session: Session) -> tuple[float, float]:
    """Return right ascension and declination of date [rad], equinox of date, geocentric."""
    import erfa

    start, day = _midnight(session.date)
    ra, dec, origins = erfa.atci13(
        session.source.ra_deg * DEG, session.source.dec_deg * DEG, 0, 0, 0, 0, start, day + 0.5
    )
    return float(erfa.anp(ra - origins)), float(dec)


def utc_seconds(session: Session, hour_angle: Array) -> Array:
    """Return when the source had these hour angles [rad]: seconds of UTC since 1970.

    The earliest one is taken to lie on the session's date, the others count
    from it. UT1-UTC (-0.36 s then) is below the printed hundredth of an hour.
    """
    import erfa

    start, day = _midnight(session.date)
    sidereal = erfa.gst06a(start, day, start, day + _TT_MINUS_UTC)
    ra, _ = apparent_place(session)
    earliest = np.nanmin(hour_angle)
    first = erfa.anp(ra + earliest - LONGITUDE_DEG * DEG - sidereal)
    turned = first + hour_angle - earliest
    seconds: Array = (start - 2440587.5 + day) * 86400 + turned / HOUR * 3600 / _SIDEREAL
    return seconds


#: The file that Table 18 is shipped in.
NAME = "table_18.csv"

#: Where each day's six cells (a, b, d, each with its sigma) begin, counted from 0.
BEGINS = {
    1: "2003-03-31",
    8: "2003-06-01",
    14: "2003-06-02",
    20: "2003-06-05",
    26: "2003-05-31",
}

#: Cells that stand a little aside of their day: (antenna, where they begin) -> the day.
#: The tables decide: of all days it is the one whose offsets the curve runs through.
SHIFTED = {
    ("C12", 27): "2003-06-05",
    ("C12", 33): "2003-05-31",
    ("S02", 18): "2003-06-05",
    ("S04", 27): "2003-05-31",
}


_UNITS = (ARCMIN, ARCMIN, ARCMIN, ARCMIN, DEG, DEG)


@dataclass(frozen=True)
class Wave:
    """A published curve a + b cos(HA + d), with the printed sigmas [rad]."""

    antenna: str
    session: str
    a: float
    sigma_a: float
    b: float
    sigma_b: float
    d: float
    sigma_d: float

    def __call__(self, hour_angle: Array) -> Array:
        """Return the elevation offset [rad] at hour angles [rad]."""
        return self.a + self.b * np.cos(hour_angle + self.d)


def table_18() -> tuple[Wave, ...]:
    """Return every curve of Table 18, its rows in turn, in each the days as printed."""
    return tuple(
        Wave(antenna, session, *(float(v) * u for v, u in zip(values, _UNITS, strict=True)))
        for antenna, session, values, _ in _curves()
    )


def _curves() -> Iterator[tuple[str, str, list[str], tuple[int, int]]]:
    """Yield antenna, session, the six printed values and their printed row and column."""
    for number, cells in enumerate(printed.lines(18)[2:], 1):
        antenna = cells[0].strip("'")
        begin = 1
        while begin < len(cells):
            if not cells[begin]:
                begin += 1
                continue
            session = BEGINS.get(begin) or SHIFTED[antenna, begin]
            values = [cell.removeprefix("+/- ") for cell in cells[begin : begin + 6]]
            yield antenna, session, values, (number, begin + 1)
            begin += 6


def table() -> Table:
    """Return Table 18 as columns, each curve with the place it was printed in."""
    names = "antenna session a_arcmin sigma_a_arcmin b_arcmin sigma_b_arcmin d_deg sigma_d_deg"
    titles = [*names.split(), "table", "printed_row", "printed_column"]
    rows = [
        [antenna, session, *values, "18", *map(str, place)]
        for antenna, session, values, place in _curves()
    ]
    columns = {t: np.array(c) for t, c in zip(titles, zip(*rows, strict=True), strict=True)}
    return Table({"curve": "a + b cos(15 HA + d), HA in hours, offsets in arcmin"}, columns)
