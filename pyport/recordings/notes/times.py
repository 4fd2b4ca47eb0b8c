"""Times of a session at which its sources stood where they do not stand in the other sessions."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from pyport.angles import DEG, Array, Codes, wrap
from pyport.effects.base import MissingColumn
from pyport.effects.circumstances import DAY_S
from pyport.recordings.schema import Recordings, group
from pyport.recordings.sky import equator

#: Refraction at the horizon is half a degree. [rad]
APART = 0.5 * DEG
#: One source may be a planet, or two that have one name.
FEWEST_SOURCES = 2
#: Sources of a session whose clock is off are off by the same, but for this share of it.
ALIKE = 0.1
#: Nearer to the pole right ascensions say little. [rad]
HIGHEST = 80 * DEG
#: So many rows, evenly chosen, show where sources stand.
MOST_ROWS = 10_000
TURNS_PER_DAY = 1.00273781191135448  #: of the Earth, in a day of UTC


def note(recordings: Recordings) -> str:
    """Return the session whose sources stand elsewhere than in other sessions, if there is one.

    A source has one right ascension: what all of them are off by in one session, its times are.
    """
    if not {"time", "source", "session"} <= recordings.at.columns.keys():
        return ""
    recordings = recordings.take(slice(None, None, len(recordings) // MOST_ROWS + 1))
    at = recordings.at
    try:
        hour_angle, dec = equator(at.az, at.el, at.latitude())
    except MissingColumn:
        return ""
    east = wrap(2 * np.pi * TURNS_PER_DAY / DAY_S * at.numbers("time") - hour_angle)
    good = np.flatnonzero(np.isfinite(east) & (np.abs(dec) < HIGHEST))
    off: dict[str, list[float]] = defaultdict(list)
    for of_each in _places(recordings, east, good):
        for one, value in of_each.items():
            others = [other for session, other in of_each.items() if session != one]
            if others:
                off[one].append(float(wrap(value - np.median(others))))
    apart = {
        one: float(np.median(values))
        for one, values in off.items()
        if len(values) >= FEWEST_SOURCES
        and np.abs(values).min() > APART
        and np.ptp(values) < ALIKE * abs(np.median(values))
    }
    if not apart:
        return ""
    # A session that shares its sources with none but that one stands off as well.
    one = max(sorted(apart), key=lambda name: len(off[name]))
    minutes = abs(apart[one]) / (2 * np.pi * TURNS_PER_DAY) * DAY_S / 60
    return (
        f"{len(off[one])} sources stand {abs(apart[one]) / DEG:.3g} deg "
        f"{'east' if apart[one] > 0 else 'west'} in session {one} of where they stand in others: "
        f"its times may be {minutes:.3g} min {'late' if apart[one] > 0 else 'early'}"
    )


def _places(recordings: Recordings, east: Array, rows: Codes) -> list[dict[str, float]]:
    """Return where each source stood in each session [rad], from where one of its rows has it."""
    code, names = group(recordings, ("source", "session"))
    rows = rows[np.argsort(code[rows], kind="stable")]
    found: dict[str, dict[str, float]] = defaultdict(dict)
    first: dict[str, float] = {}
    for own in np.split(rows, np.flatnonzero(np.diff(code[rows])) + 1):
        if not len(own) or not (source := names[code[own[0]]][0]):
            continue
        place = wrap(east[own] - first.setdefault(source, east[own[0]]))
        found[source][names[code[own[0]]][1]] = float(np.median(place))
    return list(found.values())
