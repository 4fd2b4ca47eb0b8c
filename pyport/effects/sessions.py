"""How long a session lasts: when its clock was set, its dome opened, its drives switched on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.effects.circumstances import NIGHT_GAP_S, Circumstances, nights_of


def _sessions(at: Circumstances) -> NDArray[np.str_]:
    """Return the session of each row, shape (n,): the night where none are recorded."""
    if "session" in at:
        return at.column("session").astype(str)
    return nights_of(at.numbers("time")).astype(str)


def spans_of(at: Circumstances) -> dict[str, list[float]]:
    """Return when each session with times began and ended [s]."""
    time, session = at.numbers("time"), _sessions(at)
    found = {}
    for name in np.unique(session[np.isfinite(time)]).tolist():
        own = time[session == name]
        found[name] = [float(np.nanmin(own)), float(np.nanmax(own))]
    return found


def since_begun(at: Circumstances, known: Mapping[str, Sequence[float]]) -> Array:
    """Return the time since the session of each row began [s], shape (n,).

    `known`: when sessions of recordings before began and ended. Another session, or one of that
    name at another time, began with its own first row. Nights stand for sessions that are not
    recorded.
    """
    time, session, named = at.numbers("time"), _sessions(at), "session" in at
    since = np.full(len(at), np.nan)
    for name, (began, _) in spans_of(at).items():
        own = session == name
        spans = [span for other, span in known.items() if other == name or not named]
        # What follows within a night's gap belongs to the same night.
        same = (first for first, last in spans if first <= began < last + NIGHT_GAP_S)
        since[own] = time[own] - next(same, began)
    return since
