"""Pointings: readings of one moment and place, however often and with whatever last digits given.

Readings of one pointing share its error. Were they taken for several pointings, telling a
measurement twice would make it surer.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, HOUR, Array, Codes
from pyport.recordings.schema import Recordings, group

#: No telescope makes two pointings within a second, at nearly the same place.
SAME_S, SAME_PLACE = 1.0, 0.02 * DEG
#: The same where nothing tells the moment: what tracking passes through in a quarter of a second.
SAME_TIMELESS = 0.001 * DEG


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
    first = order[_starts(code[order], clock[order], at.az[order], at.el[order], reach[order])]
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
        turn = np.abs((az[some] - az[others] + np.pi) % (2 * np.pi) - np.pi)
        away = np.hypot(turn * np.cos(el[some]), el[some] - el[others]) > reach[some]
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
