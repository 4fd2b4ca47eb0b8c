"""Between the two frames of a site: azimuth and elevation, hour angle and declination."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import RADIANS_PER, Array, Codes, wrap
from pyport.columns import DIRECTIONS, SPELLED
from pyport.effects import Circumstances
from pyport.effects.circumstances import NIGHT_GAP_S, mostly_known, nights_of
from pyport.recordings.schema import Recordings, group
from pyport.thresholds import PER_LABEL


def horizon(hour_angle: Array, dec: Array, latitude: float) -> tuple[Array, Array]:
    """Return azimuth (from north through east, in [-pi, pi)) and elevation [rad].

    Hour angle is positive west; all angles in radians. ERFA's `hd2ae`.
    """
    import erfa

    with np.errstate(invalid="ignore"):  # a NaN stays one
        az, el = erfa.hd2ae(hour_angle, dec, latitude)
    return wrap(az), el


def equator(az: Array, el: Array, latitude: float) -> tuple[Array, Array]:
    """Return hour angle (positive west, in [-pi, pi)) and declination [rad]. ERFA's `ae2hd`."""
    import erfa

    with np.errstate(invalid="ignore"):
        hour_angle, dec = erfa.ae2hd(az, el, latitude)
    return wrap(hour_angle), dec


def hour_angle_at(el: Array, dec: float, latitude: float) -> Array:
    """Return how far from the meridian [rad, 0 to pi] a source is at an elevation [rad].

    NaN where it never gets there.
    """
    sine = np.sin(el) - np.sin(latitude) * np.sin(dec)
    cosine = sine / (np.cos(latitude) * np.cos(dec))
    return np.arccos(np.where(np.abs(cosine) <= 1, cosine, np.nan))


#: An equinox before this year is Besselian where no letter says so (SUN/67, `sla_KBJ`).
FIRST_JULIAN = 1984.0
#: The one Besselian equinox that is read: FK4's.
FK4_YEAR = 1950.0


@dataclass(frozen=True)
class Equinox:
    """The year of an equinox, Julian or Besselian; places are of the same epoch."""

    year: float
    besselian: bool

    @property
    def known(self) -> bool:
        """Tell whether places of it can be moved: any Julian one, and B1950."""
        return not self.besselian or abs(self.year - FK4_YEAR) < 1e-3


@dataclass(frozen=True)
class Place:
    """A mean place [rad] and its proper motions, d(RA)/dt without cos Dec [rad/yr]."""

    ra: float
    dec: float
    pm_ra: float
    pm_dec: float


def equinox(word: str) -> Equinox | None:
    """Return the equinox that a word such as `B1950.0` or `2000` says, None for another word."""
    letter = word[:1].upper()
    try:
        year = float(word[1:] if letter in {"B", "J"} else word)
    except ValueError:
        return None
    if not 1800 < year < 2200:
        return None
    return Equinox(year, letter == "B" or (letter != "J" and year < FIRST_JULIAN))


def to_j2000(place: Place, of: Equinox) -> Place:
    """Return a mean place at equinox and epoch J2000, within 0.03 arcsec of the ICRS.

    FK4 places by ERFA's `fk425` (Standish 1982, Aoki et al. 1983: E-terms, precession and the
    motion of the equinox), those of a Julian equinox by the IAU 2006 precession.
    """
    import erfa

    if of.besselian:
        moved = erfa.fk425(place.ra, place.dec, place.pm_ra, place.pm_dec, 0.0, 0.0)
        return Place(*map(float, moved[:4]))
    if abs(of.year - 2000) < 1e-3:
        return place
    matrix = erfa.pmat06(*erfa.epj2jd(of.year))
    there = erfa.s2pv(place.ra, place.dec, 1.0, place.pm_ra, place.pm_dec, 0.0)
    ra, dec, _, pm_ra, pm_dec, _ = map(float, erfa.pv2s(erfa.trxpv(matrix, there)))
    years = 2000 - of.year
    return Place(ra + years * pm_ra, dec + years * pm_dec, pm_ra, pm_dec)


#: The share of rows along which one coordinate goes on and the other stands still beyond which
#: they are a table's: a raster has nearly all, places in random order at one elevation a third,
#: a source that is followed none.
RASTER = 0.5
#: The share of steps at which azimuth turns beyond which rising elevations are a table's: places
#: in random order turn at two thirds of them, a source that is followed at none.
TO_AND_FRO = 1 / 3
#: Header keys under which it is said what stands for what, and what is too short to be used.
SESSIONS, ORDER, TIMES, CELLS = "sessions_from", "order_from", "times_from", "cells_from"
SHORT, TIMELESS = "sessions_too_short", "no_time"


def with_nights(recordings: Recordings) -> Recordings:
    """Return recordings with sessions and an order, where they have times or rows to tell them by.

    Without a session the nights between gaps in time are sessions. A row without a time has that
    of the nearest row of the file. Where most have none, or all that an antenna recorded have one,
    the order of the rows, in the column `order`, stands for it, unless that is the order of their
    places. Blank cells of a column that is smooth in time are taken from the rows before and after.
    What was derived stands in `meta`.
    """
    at = recordings.at
    columns, meta = dict(at.columns), dict(recordings.meta)
    why = "no time being recorded"
    if "time" in at:
        time = np.asarray(at.column("time"), float)
        one = len(time) > 1 and len(np.unique(time[np.isfinite(time)])) == 1
        if one and len(np.unique(recordings.label("antenna"))) == 1:
            del columns["time"]
            why = "all having one time"
        elif mostly_known(time):
            columns["time"] = _nearest(time, recordings.line)
            if blank := int(np.isnan(time).sum()):
                meta[TIMES] = f"the nearest rows of the file for {blank} of them"
        else:
            del columns["time"]
            why = "most having no time"
    if "time" not in columns and _sorted(recordings):
        meta[TIMELESS] = f"{why}, and the rows stand in the order of their places"
    elif "time" not in columns:
        columns["order"] = np.argsort(np.argsort(recordings.line, kind="stable")).astype(float)
        meta[ORDER] = f"the order of the rows, {why}"
    elif "session" not in at:
        nights = _nights(columns["time"])
        if len(np.unique(nights)) > 1:
            columns["session"] = nights
            meta[SESSIONS] = f"gaps of more than {NIGHT_GAP_S / 3600:g} h in time"
    whole = replace(recordings, at=replace(at, columns=columns), meta=meta)
    return _with_cells(whole)


def with_sessions(recordings: Recordings) -> Recordings:
    """Return recordings `with_nights`, and without sessions too short to depart from each other.

    Labels that have fewer than `PER_LABEL` rows on average say what was pointed at, not when
    something was changed.
    """
    return _without_short(with_nights(_without_short(recordings)))


def _without_short(recordings: Recordings) -> Recordings:
    if "session" not in recordings.at:
        return recordings
    count, rows = len(group(recordings, ("session",))[1]), len(recordings)
    if count == 1 or rows >= PER_LABEL * count:
        return recordings
    columns = {name: one for name, one in recordings.at.columns.items() if name != "session"}
    meta = {**recordings.meta, SHORT: f"{count} in {rows} rows"}
    meta.pop(SESSIONS, None)
    return replace(recordings, at=replace(recordings.at, columns=columns), meta=meta)


def _with_cells(recordings: Recordings) -> Recordings:
    """Return recordings with the blank cells of smooth columns taken from before and after."""
    at, filled = recordings.at, []
    columns, time = dict(at.columns), clock(at)
    session, _ = group(recordings, ("antenna", "session"))
    for name, values in at.columns.items():
        if values.dtype.kind != "f" or name.rpartition("_")[2] in RADIANS_PER:
            continue
        blank = np.isnan(values)
        if blank.any() and mostly_known(values):
            if name in DIRECTIONS:
                found = np.angle(_between(np.exp(1j * values), time, session))
            else:
                found = _between(values, time, session)
            columns[name] = np.where(blank, found, values)
            if taken := int((blank & np.isfinite(found)).sum()):
                filled.append(f"{SPELLED.get(name, name)} in {taken} row{'s' * (taken > 1)}")
    if not filled:
        return recordings
    meta = {**recordings.meta, CELLS: ", ".join(filled)}
    return replace(recordings, at=replace(at, columns=columns), meta=meta)


def _between(values: NDArray[Any], time: Array, session: Codes) -> NDArray[Any]:
    """Return numbers (n,) with the blank ones of a session from those before and after in it.

    Only where they tell the known ones, every other of them taken so, better than the mean does.
    Angles come as complex numbers of unit size, so that north has no seam.
    """
    filled, missed = values.copy(), []
    for one in np.unique(session):
        rows = np.flatnonzero((session == one) & np.isfinite(time))
        known = rows[np.isfinite(values[rows])]
        known = known[np.argsort(time[known], kind="stable")]
        if len(known) == 0:
            continue
        blank = rows[np.isnan(values[rows])]
        filled[blank] = np.interp(time[blank], time[known], values[known])
        some, others = known[::2], known[1::2]
        if len(others):
            missed.append(values[others] - np.interp(time[others], time[some], values[some]))
    spread = float(np.nanstd(values))
    error = float(np.sqrt(np.mean(np.abs(np.concatenate(missed)) ** 2))) if missed else np.inf
    return filled if error < spread else values


def _nearest(time: Array, line: Codes) -> Array:
    """Return times (n,), those not known from the nearest of the lines that have one."""
    known = np.flatnonzero(np.isfinite(time))
    known = known[np.argsort(line[known], kind="stable")]
    nearest = np.rint(np.interp(line, line[known], np.arange(len(known)))).astype(int)
    return np.where(np.isfinite(time), time, time[known[nearest]])


def clock(at: Circumstances) -> Array:
    """Return what tells before from after: the time [s], or the order of the rows, shape (n,).

    NaN where it is not known.
    """
    for name in ("time", "order"):
        if name in at:
            return np.asarray(at.column(name), float)
    return np.full(len(at), np.nan)


def _sorted(recordings: Recordings) -> bool:
    """Tell whether the rows stand in the order of their places: a table's order is no time's.

    Along the lines of a grid one of azimuth and elevation goes on in one direction and the other
    stands still. Sorted by elevation a table goes to and fro in azimuth. A source that is followed
    moves in both, and turns in neither.
    """
    order = np.argsort(recordings.line, kind="stable")
    steps = np.sign(np.diff([recordings.at.az[order], recordings.at.el[order]]))
    if steps.shape[1] < 2:
        return False
    goes_on = (steps[:, 1:] == steps[:, :-1]) & (steps[:, 1:] != 0)
    stands = (steps[:, 1:] == 0) & (steps[:, :-1] == 0)
    along_lines = np.mean((goes_on & stands[::-1]).any(axis=0)) > RASTER
    turns = np.mean(steps[0, 1:] * steps[0, :-1] < 0) > TO_AND_FRO
    return bool(along_lines or (turns and len({*steps[1]} - {0.0}) == 1))


def _nights(time: Array) -> Array:
    """Return the date on which the night of each row began, its number behind it if it has two."""
    night = nights_of(time)
    dates = [night_of(time[night == one].min()) for one in np.unique(night)]
    names = [
        date if dates.count(date) == 1 else f"{date}.{dates[:n].count(date) + 1}"
        for n, date in enumerate(dates)
    ]
    return np.array(names)[night]


def night_of(time: float) -> str:
    """Return the date of a moment [s since 1970]."""
    return str(np.datetime64(int(time), "s").astype("datetime64[D]"))
