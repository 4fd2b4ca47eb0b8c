"""Contenders: what may join in a turn, each in the case that it makes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.evidence import Projection
from pyport.diagnosis.searching.confirming import among, confirmed
from pyport.diagnosis.searching.refining import refine
from pyport.diagnosis.shapes.wave_fits import is_line
from pyport.diagnosis.trial import CandidateFit
from pyport.diagnosis.weighing import noise, projection, weigh
from pyport.effects.base import Effect
from pyport.least_squares.gram import beyond
from pyport.noise.covariance import Covariance
from pyport.thresholds import CONVINCING, ENOUGH_ANTENNAS


@dataclass(frozen=True)
class Contender:
    """What may join in a turn: its trial, the case with its columns, the choice.

    `price` is what its choice among its family costs, a refined moment or edge included.
    `beside` is what it was tried in where that is not the turn's: a wave's columns joined the case.
    `rivals` are the other changes, each with the evidence that the noise leaves it.
    `sure` is its evidence beside noise estimated anew.
    """

    trial: CandidateFit
    problem: Problem
    chosen: Chosen
    price: float
    beside: Projection | None = None
    rivals: tuple[CandidateFit, ...] = ()
    sure: float = -np.inf

    @property
    def effect(self) -> Effect:
        """Return its effect, with the moment or edge that it has."""
        return self.chosen.candidate.effect


def refined(
    problem: Problem, covariance: Covariance, chosen: tuple[Chosen, ...], trial: CandidateFit
) -> Contender:
    """Return a trial with its moment or edge moved to where it fits best."""
    plain = Chosen(trial.candidate, trial.scope)
    wider, new, more, price = refine(problem, covariance, chosen, plain)
    added = trial.gain * (more - 1)
    better = replace(
        trial,
        gain=trial.gain + added,
        delta_bic=trial.delta_bic + added - price,
        evidence=trial.evidence + added - price,
    )
    return Contender(better, wider, new, price + new.candidate.price)


def waves_of(problem: Problem, chosen: tuple[Chosen, ...], one: Chosen | None) -> list[Contender]:
    """Return the wave that is proposed, with its columns.

    None if the noise can do it as well, or if it has no period of its own.
    """
    if one is None:
        return []
    wider, _ = problem.with_member(one, one.candidate.effect)
    price = one.candidate.price
    sure = confirmed(wider, chosen, one, price)
    if sure <= CONVINCING:
        return []
    beside_it = noise(wider, (*chosen, one), searching=False)
    if not is_line(wider, beside_it, chosen, one.candidate.effect):
        return []
    beside = projection(wider, weigh(wider, chosen), chosen)
    trials = beside.trials([(one.candidate, one.scope)])
    # Beside the noise of the turn, which took it for a drift, one in time gains too little.
    of_time = one.candidate.of_time
    return [
        Contender(
            replace(each, evidence=sure, gain=sure if of_time else each.gain, delta_bic=sure),
            wider,
            one,
            price,
            beside,
            sure=sure,
        )
        for each in trials
    ]


def evidence_anew(one: Contender, chosen: tuple[Chosen, ...]) -> float:
    """Return the evidence of a contender beside noise estimated anew, its price paid.

    In an array it is that of the turn, whose noise alone includes what antennas share.
    """
    problem = one.problem
    if problem.blocks.antennas >= ENOUGH_ANTENNAS:
        return one.trial.evidence - one.trial.owed_to_scale - among(problem, one.effect)
    others = joined(problem, chosen, one.chosen)[:-1]
    return confirmed(problem, others, one.chosen, one.price)


def joined(problem: Problem, chosen: tuple[Chosen, ...], new: Chosen) -> tuple[Chosen, ...]:
    """Add a choice; earlier ones whose every curve it can draw make way for it."""
    columns = problem.picked(new.candidate.columns)
    groups = problem.blocks.groups(new.scope)
    kept = []
    for one in chosen:
        own = problem.picked(one.candidate.columns)
        inside = np.linalg.norm(beyond(columns, own)) < 1e-6 * np.linalg.norm(own)
        # Blocks that share a coefficient of the new choice must share one of the old, too.
        pairs = np.unique(np.stack([groups, problem.blocks.groups(one.scope)]), axis=1)
        if not (inside and len(np.unique(pairs[0])) == pairs.shape[1]):
            kept.append(one)
    return (*kept, new)
