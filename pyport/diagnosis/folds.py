"""Folds: which readings are left out together, to be predicted from the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import Codes
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.weighing import WhitenedData
from pyport.effects.base import THE_HOUR
from pyport.recordings.sky import clock
from pyport.thresholds import BLOCKS, FEWEST, FOLDS, MOST_FOLDS, SEVERAL

#: Stretches left out that tell how far a held-out rms may be off: two say nothing of how they
#: scatter.
FEWEST_STRETCHES = 3


@dataclass(frozen=True)
class Folds:
    """A partition of the readings (m,) into folds, and what it is called.

    `departing` says whether what a session or source departs by, as its other readings show it,
    belongs to a prediction. From `fewest` stretches on their scatter can refute what was found:
    of whole sessions, each off by what nobody predicts, it takes more.
    """

    scheme: str
    fold: Codes
    departing: bool = False
    fewest: int = FEWEST_STRETCHES


def folds(problem: Problem, weighed: WhitenedData, chosen: Sequence[Chosen]) -> Folds:
    """Choose what is left out together.

    Whole sessions where there are enough of them and nothing that is fitted
    belongs to a session; otherwise whole scans where they are known to be
    scans, or blocks of time within the sessions, or single pointings where
    there is neither time nor order. Where sessions depart from each other, blocks of each are
    predicted from its others; but a change among them must do better than the
    model alone, for any change could be called departures. What is over by itself is predicted from
    the pointings around.
    """
    sessions = problem.session
    choices = (*problem.base, *chosen)
    own = any("session" in one.scope for one in choices)
    epochs = any(one.candidate.effect.is_change or one.candidate.of_time for one in choices)
    departing = any(one.of == "session" for one in weighed.covariance.departures)
    departing = departing and not epochs
    if len(np.unique(sessions)) >= SEVERAL and not (own or epochs or departing):
        count = len(np.unique(sessions))
        if count <= MOST_FOLDS:
            return Folds("leave one session out", sessions, fewest=FEWEST)
        whole = sessions * MOST_FOLDS // count
        return Folds("leave whole sessions out, twenty folds", whole, fewest=FEWEST)
    rng = np.random.default_rng(problem.seed)
    at = problem.recordings.at
    time = clock(at)[problem.stack.row]
    if chosen and all(one.candidate.effect.is_over for one in chosen):
        return Folds(
            "leave pointings out, ten folds", _dealt(problem.pointing, rng), departing=True
        )
    if not np.isfinite(time).all():
        return Folds("leave pointings out, ten folds", _dealt(problem.pointing, rng), departing)
    if "scan_direction" in at and problem.blocks.antennas > 1:
        scans = np.unique(np.stack([sessions, time]), axis=1, return_inverse=True)[1].ravel()
        return Folds("leave whole scans out, ten folds", _dealt(scans, rng))
    fold = np.zeros(len(time), np.intp)
    # What goes with the hour would be unknown where all sessions lacked the same hour.
    by_hour = any(one.candidate.effect.driver == THE_HOUR for one in choices)
    for number, session in enumerate(np.unique(sessions)):
        rows = np.flatnonzero(sessions == session)
        rank = np.unique(time[rows], return_inverse=True)[1]
        first = number if by_hour else 0
        fold[rows] = (rank * BLOCKS // (rank.max() + 1) + first) % BLOCKS
    what = "time" if "time" in at else "rows"
    scheme = f"leave blocks of {what} out, five in each session"
    if departing:
        scheme += ", what a session departs by predicted from its others"
    return Folds(scheme, fold, departing)


def _dealt(groups: Codes, rng: np.random.Generator) -> Codes:
    """Deal groups out to the folds at random, evenly."""
    distinct, inverse = np.unique(groups, return_inverse=True)
    deal = rng.permutation(len(distinct)) % min(FOLDS, len(distinct))
    return deal[inverse]
