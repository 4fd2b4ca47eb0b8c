"""Pointings: readings of one moment and place, however often and with whatever last digits given.

Readings of one pointing share its error. Were they taken for several pointings, to repeat a
measurement would make it surer. So do exposures that follow one another while the telescope
tracks, where nothing says which of them are of one source.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, HOUR, Array, Codes, wrap
from pyport.effects.sky.frame import SIDEREAL
from pyport.recordings.schema import Recordings, group

#: No telescope makes two pointings within a second, at nearly the same place.
SAME_S, SAME_PLACE = 1.0, 0.02 * DEG
#: The same where nothing tells the moment: what tracking passes through in a quarter of a second.
SAME_TIMELESS = 0.001 * DEG
#: Exposures without a slew between them are one visit of a place: so many at most, in so long [s].
#: What is longer is a record of tracking.
MOST_EXPOSURES, LONGEST_VISIT_S = 10, 300.0


def pointings(recordings: Recordings) -> Codes:
    """Give rows of the same antenna, session, source, moment, direction and scan one number."""
    at = recordings.at
    labels, _ = group(recordings, ("antenna", "session", "source"))
    clock = _clock(recordings)
    who = [labels.astype(float), np.isnan(clock).astype(float)]
    if "scan_direction" in at:
        who.append(np.nan_to_num(np.asarray(at.column("scan_direction"), float)))
    code = np.unique(np.stack(who, axis=1), axis=0, return_inverse=True)[1].ravel()
    known, clock = np.isfinite(clock), np.nan_to_num(clock)
    reach = np.where(known, SAME_PLACE, SAME_TIMELESS)
    height = np.where(known, 0.0, np.round(at.el / SAME_TIMELESS))
    order = np.lexsort((at.el, at.az, height, clock, code))
    start = _starts(code[order], clock[order], at.az[order], at.el[order], reach[order])
    turned = at.side if at.mount.turns_over else np.zeros(len(at))
    alone = np.where(known & (recordings.label("source") == ""), turned, np.nan)[order]
    start = _visits(start, code[order], clock[order], at.az[order], at.el[order], alone)
    first = order[start]
    keys = np.stack([code[first], at.az[first], at.el[first], clock[first]], axis=1)
    found = np.empty(len(at), np.intp)
    found[order] = np.unique(keys, axis=0, return_inverse=True)[1].ravel()
    return found


def _clock(recordings: Recordings) -> Array:
    """Return what tells the moments [s], NaN where nothing does: time, else the hour angle."""
    at = recordings.at
    if "time" in at:
        return np.asarray(at.column("time"), float)
    if "hour_angle" in at:
        return np.asarray(at.column("hour_angle"), float) / HOUR * 3600.0
    return np.full(len(at), np.nan)


def _starts(code: Codes, clock: Array, az: Array, el: Array, reach: Array) -> Codes:
    """Return where in their order the pointing of each row starts.

    A row belongs to the pointing whose first row is near: what is near to its last one only
    begins another, so that a chain of rows does not become one pointing.
    """
    rows = np.arange(len(code))

    def apart(some: Codes, others: Codes) -> NDArray[np.bool_]:
        away = _away(az, el, some, others) > reach[some]
        late = np.abs(clock[some] - clock[others]) > SAME_S
        return np.asarray((code[some] != code[others]) | late | away)

    begins = np.concatenate([[True], apart(rows[1:], rows[:-1])])
    start = np.maximum.accumulate(np.where(begins, rows, 0))
    for low in np.unique(start[apart(rows, start)]):
        first = low
        for row in range(low + 1, len(rows)):
            if begins[row]:
                break
            if apart(rows[row : row + 1], rows[first : first + 1])[0]:
                first = row
            start[row] = first
    return start


def _away(az: Array, el: Array, some: Codes, others: Codes) -> Array:
    """Return how far some rows point from others, on the sky [rad]."""
    across = wrap(az[some] - az[others]) * np.cos(el[some])
    return np.hypot(across, el[some] - el[others])


def _visits(start: Codes, code: Codes, clock: Array, az: Array, el: Array, side: Array) -> Codes:
    """Return where in their order the visit of each row starts, from where its pointing does.

    A visit goes on while nothing moves by more than the sky turns, in time and on one `side` of the
    pier; NaN where no time is known, or a source is.
    """
    first = np.unique(start)
    before, after = first[:-1], first[1:]
    tracks = _away(az, el, after, before) <= SIDEREAL * (clock[after] - clock[before]) + SAME_PLACE
    goes_on = tracks & (code[after] == code[before]) & (side[after] == side[before])
    visit = np.cumsum(np.concatenate([[True], ~goes_on])) - 1
    begins = np.flatnonzero(np.diff(visit, prepend=-1))
    length = clock[first[np.append(begins[1:], len(first)) - 1]] - clock[first[begins]]
    brief = (np.bincount(visit) <= MOST_EXPOSURES) & (length <= LONGEST_VISIT_S)
    begun = np.where(brief[visit], first[begins][visit], first)
    return begun[np.searchsorted(first, start)]
