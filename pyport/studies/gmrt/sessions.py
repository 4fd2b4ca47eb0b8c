"""The five sessions of 2003: which table is which day, what was observed, and where from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pyport.angles import DEG, HOUR, Array

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
