"""Held-out data: the only proof that a better fit is more than a more flexible one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.case import Chosen, Setup, Weighed
from pyport.diagnosis.noise import whiten
from pyport.fitting.gram import Gram
from pyport.fitting.stacking import Codes

#: Sessions from which on whole sessions are left out.
ENOUGH_SESSIONS = 3
FOLDS = 10


@dataclass(frozen=True)
class Folds:
    """A partition of the readings (m,) into folds, and what it is called."""

    scheme: str
    fold: Codes


def folds(setup: Setup, chosen: Sequence[Chosen], seed: int) -> Folds:
    """Choose what is left out together.

    Whole sessions where there are enough of them and nothing that is fitted
    belongs to a session; otherwise whole scans where they are known to be
    scans, or blocks of time, or single pointings where there is no time.
    """
    sessions = np.unique(setup.blocks.session, return_inverse=True)[1][setup.block]
    own = any("session" in one.scope for one in (*setup.base, *chosen))
    per_session = any(one.candidate.effect.id.startswith("epoch") for one in chosen)
    if len(np.unique(sessions)) >= ENOUGH_SESSIONS and not own and not per_session:
        return Folds("leave one session out", sessions)
    rng = np.random.default_rng(seed)
    at = setup.recordings.at
    if "time" not in at or not np.all(np.isfinite(np.asarray(at.column("time"), float))):
        return Folds("leave pointings out, ten folds", _dealt(setup.pointing, rng))
    time = np.asarray(at.column("time"), float)[setup.stack.row]
    if "scan_direction" in at:
        scans = np.unique(np.stack([sessions, time]), axis=1, return_inverse=True)[1].ravel()
        return Folds("leave whole scans out, ten folds", _dealt(scans, rng))
    order = np.argsort(np.argsort(time, kind="stable"), kind="stable")
    return Folds("leave blocks of time out, ten blocks", order * FOLDS // len(order))


def _dealt(groups: Codes, rng: np.random.Generator) -> Codes:
    """Deal groups out to the folds at random, evenly."""
    distinct, inverse = np.unique(groups, return_inverse=True)
    deal = rng.permutation(len(distinct)) % min(FOLDS, len(distinct))
    return deal[inverse]


def residuals(
    setup: Setup, weighed: Weighed, chosen: Sequence[Chosen], partition: Folds
) -> Array:
    """Return each reading less what a fit without its fold predicts [rad], shape (m,).

    NaN where the other folds do not determine the prediction.
    """
    choices = (*setup.base, *chosen)
    parts = [setup.part(one) for one in choices]
    data = np.concatenate([setup.columns, setup.residual[:, None]], axis=1)
    expanded = setup.expanded(choices)
    left = np.full(len(setup.residual), np.nan)
    total = weighed.evidence.gram.matrices
    white = whiten(data, weighed.weights, setup.parts, weighed.noises)
    block = np.concatenate([setup.block, setup.block])
    fold = np.concatenate([partition.fold, partition.fold])
    for one in np.unique(partition.fold):
        own = Gram.of(white * (fold == one)[:, None], block, len(setup.blocks)).matrices
        solution = Gram(total - own).solve(parts)
        rows = np.flatnonzero(partition.fold == one)
        unknown = np.any((expanded[rows] != 0) & ~solution.known, axis=1)
        predicted = expanded[rows] @ solution.values
        left[rows] = np.where(unknown, np.nan, setup.residual[rows] - predicted)
    return left

