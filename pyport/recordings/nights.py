"""Nights and order: what stands for sessions and times in recordings that name none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pyport.angles import Array
from pyport.effects import Circumstances
from pyport.recordings.schema import Recordings

#: What is not measured for so long parts two nights [s]: longer than any break of one, shorter
#: than a summer's day.
NIGHT_GAP_S = 6 * 3600.0
#: Rows that turn back in azimuth or elevation less often than this are sorted by place.
TURNING = 0.5
#: Header keys under which it is said what stands for what.
SESSIONS, ORDER = "sessions_from", "order_from"


def with_nights(recordings: Recordings) -> Recordings:
    """Return recordings with sessions and an order, where they have times or rows to tell them by.

    Without a session the nights between gaps in time are sessions. Without times the order of
    the rows, in the column `order`, stands for them. What was derived stands in `meta`.
    """
    at = recordings.at
    columns, meta = dict(at.columns), dict(recordings.meta)
    if "time" not in at and not _sorted(recordings):
        columns["order"] = np.argsort(np.argsort(recordings.line, kind="stable")).astype(float)
        meta[ORDER] = "the order of the rows, no time being recorded"
    elif "time" in at and "session" not in at:
        time = np.asarray(at.column("time"), float)
        if np.isfinite(time).all() and len(time):
            nights = _nights(time)
            if len(np.unique(nights)) > 1:
                columns["session"] = nights
                meta[SESSIONS] = f"gaps of more than {NIGHT_GAP_S / 3600:g} h in time"
    return replace(recordings, at=replace(at, columns=columns), meta=meta)


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

    From one row to the next a random order of azimuths or elevations turns back in two of three
    cases, the grid of a table in few.
    """
    order = np.argsort(recordings.line, kind="stable")

    def turns(values: Array) -> float:
        steps = np.diff(values[order])
        steps = np.sign(steps[steps != 0])
        return float(np.mean(steps[1:] != steps[:-1])) if len(steps) > 1 else 0.0

    return max(turns(recordings.at.az), turns(recordings.at.el)) < TURNING


def _nights(time: Array) -> Array:
    """Return the date on which the night of each row began, its number behind it if it has two."""
    order = np.argsort(time, kind="stable")
    night = np.concatenate([[0], np.cumsum(np.diff(time[order]) > NIGHT_GAP_S)])
    first = time[order][np.unique(night, return_index=True)[1]]
    dates = [night_of(one) for one in first]
    names = [
        date if dates.count(date) == 1 else f"{date}.{dates[:n].count(date) + 1}"
        for n, date in enumerate(dates)
    ]
    found = np.empty(len(time), dtype=f"<U{max(map(len, names))}")
    found[order] = np.array(names)[night]
    return found


def night_of(time: float) -> str:
    """Return the date of a moment [s since 1970]."""
    return str(np.datetime64(int(time), "s").astype("datetime64[D]"))
