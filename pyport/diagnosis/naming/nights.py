"""How many nights recordings hold, which readings are of which, and what goes with the hour."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyport.diagnosis.naming.scene import Scene
from pyport.effects.circumstances import DAY_S, NIGHT_GAP_S, nights_of
from pyport.least_squares.gram import beyond
from pyport.recordings.sky import clock
from pyport.thresholds import CARRIERS, NIGHT_ORDER, WITH_THE_HOUR


def night_numbers(scene: Scene) -> NDArray[np.intp]:
    """Return a number for the night of each reading, shape (m,): sessions, and gaps in them."""
    session, row = scene.problem.session, scene.problem.stack.row
    time = scene.problem.recordings.at.times
    if time is None:
        return np.unique(session, return_inverse=True)[1].ravel()
    return np.unique(np.stack([session, nights_of(time)[row]]), axis=1, return_inverse=True)[
        1
    ].ravel()


def nights(scene: Scene) -> int:
    """Return in how many nights there are enough pointings; of longer runs each day counts.

    Where no times are known sessions stand for nights; without those it is one as far as is known.
    """
    time = scene.problem.recordings.at.times
    if time is None:
        return len(np.unique(scene.problem.session))
    first = np.unique(scene.problem.pointing, return_index=True)[1]
    time = np.sort(time[scene.problem.stack.row[first]])
    runs = np.split(time, np.flatnonzero(np.diff(time) > NIGHT_GAP_S) + 1)
    return sum(
        max(1, round(float(run[-1] - run[0]) / DAY_S)) for run in runs if len(run) >= CARRIERS
    )


def goes_with_the_hour(scene: Scene, column: str) -> bool:
    """Tell whether a smooth curve draws a column in time, or else in the order of the rows.

    Where neither is known, or of too few rows, it may be so.
    """
    time = clock(scene.problem.recordings.at)
    if not np.isfinite(time).all() or len(time) < NIGHT_ORDER + 2 or np.ptp(time) == 0:
        return True
    values = np.asarray(scene.problem.recordings.at.column(column), float)
    known = np.isfinite(values)
    if known.sum() < NIGHT_ORDER + 2:
        return True
    phase = (time - time.min()) / np.ptp(time) * 2 - 1
    basis = np.polynomial.legendre.legvander(phase[known], NIGHT_ORDER)
    left = beyond(basis, values[known])
    return float(left.var()) <= (1 - WITH_THE_HOUR) * float(values[known].var())
