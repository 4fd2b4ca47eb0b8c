"""Times of a session at which its sources stood where they do not stand in the other sessions."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from pyport.angles import DEG, wrap
from pyport.effects.base import MissingColumn
from pyport.recordings.schema import Recordings
from pyport.recordings.sky import equator

#: Refraction at the horizon is half a degree. [rad]
APART = 0.5 * DEG
#: One source may be a planet, or two that have one name.
FEWEST_SOURCES = 2
#: Sources of a session whose clock is off are off by the same, but for this share of it.
ALIKE = 0.1
#: Nearer to the pole right ascensions say little. [rad]
HIGHEST = 80 * DEG
TURNS_PER_DAY = 1.00273781191135448  #: of the Earth, in a day of UTC


def note(recordings: Recordings) -> str:
    """Return the session whose sources stand elsewhere than in other sessions, if there is one.

    A source has one right ascension: what all of them are off by in one session, its times are.
    """
    at = recordings.at
    if not {"time", "source", "session"} <= at.columns.keys():
        return ""
    try:
        hour_angle, dec = equator(at.az, at.el, at.latitude())
    except MissingColumn:
        return ""
    days = at.numbers("time") / 86400
    east = wrap(2 * np.pi * TURNS_PER_DAY * (days - np.nanmin(days)) - hour_angle)
    good = np.isfinite(east) & (np.abs(dec) < HIGHEST)
    session, source = (np.asarray(at.column(name)).astype(str) for name in ("session", "source"))
    off: dict[str, list[float]] = defaultdict(list)
    for name in {*source[good]} - {""}:
        own = np.flatnonzero(good & (source == name))
        place = wrap(east[own] - east[own[0]])
        of_each = {one: np.median(place[session[own] == one]) for one in {*session[own]}}
        for one, value in of_each.items():
            others = [other for label, other in of_each.items() if label != one]
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
    minutes = abs(apart[one]) / (2 * np.pi * TURNS_PER_DAY) * 1440
    return (
        f"{len(off[one])} sources stand {abs(apart[one]) / DEG:.3g} deg "
        f"{'east' if apart[one] > 0 else 'west'} in session {one} of where they stand in others: "
        f"its times may be {minutes:.3g} min {'late' if apart[one] > 0 else 'early'}"
    )
