"""Honest sigmas: how the parameters scatter when whole sessions are drawn anew."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array, Codes
from pyport.errors import BadInput
from pyport.recordings.schema import Recordings, group
from pyport.studies.rt32.fit import Rt32Fit, settle

_DAY_S = 86400.0


def bootstrap(fit: Rt32Fit, draws: int = 300, seed: int = 0) -> Array:
    """Return the parameters of `draws` campaigns made of sessions of this one, shape (draws, P).

    Errors that last as long as a session make formal sigmas too small; sessions,
    drawn with replacement, are as independent as anything that was measured. The
    model is taken as linear about the fit, the scale of the loss is held, votes
    are weighed anew.

    Raises `BadInput`: there are fewer than two sessions.
    """
    session = sessions(fit.recordings)[fit.stack.row]
    count = int(session.max()) + 1
    if count < 2:
        raise BadInput("one session: expected two or more to draw from", fit.recordings.file)
    rng = np.random.default_rng(seed)
    drawn = np.empty((draws, len(fit.values)))
    for k in range(draws):
        times = np.bincount(rng.integers(count, size=count), minlength=count)[session]
        change, _, _, _ = settle(
            fit.columns, fit.residual, fit.stack.is_y, lambda _: fit.tuned, times * fit.prior
        )
        drawn[k] = fit.values + change
    return drawn


def honest_sigmas(fit: Rt32Fit) -> Array:
    """Return how far drawn parameters scatter [rad], shape (P,); NaN with one session only."""
    if sessions(fit.recordings).max() == 0:
        return np.full(len(fit.values), np.nan)
    return bootstrap(fit).std(axis=0, ddof=1)


def sessions(recordings: Recordings) -> Codes:
    """Return the number of each recording's session, or of its day; all are one without times."""
    if "session" in recordings.at or "time" not in recordings.at:
        return group(recordings, ("session",))[0]
    day = np.floor(recordings.at.numbers("time") / _DAY_S)
    return np.unique(day, return_inverse=True)[1]
