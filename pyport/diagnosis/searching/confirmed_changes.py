"""Changes with time, confirmed: what the noise, estimated anew, cannot do as well."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pyport.diagnosis.case import Chosen, Problem, confounded
from pyport.diagnosis.searching.changes import proposed
from pyport.diagnosis.searching.confirming import confirmed
from pyport.diagnosis.searching.contenders import (
    Contender,
    evidence_anew,
    joined,
    refined,
    waves_of,
)
from pyport.diagnosis.shapes import oscillations
from pyport.diagnosis.trial import CandidateFit
from pyport.diagnosis.weighing import best_shown
from pyport.effects.empirical.oscillations import OSCILLATION
from pyport.noise.covariance import Covariance
from pyport.runs.workers import side_by_side
from pyport.thresholds import CONVINCING


@dataclass(frozen=True)
class Changes:
    """The changes that are proposed in a turn, beside noise that holds still.

    Attributes
    ----------
    chosen, trials
        What stands in the turn, and all that was tried there.
    still
        The noise that holds still.
    waves
        The wave that is proposed, if any.
    moved
        Steps at their best moment and other changes, worth a look beside noise estimated anew.
    """

    chosen: tuple[Chosen, ...]
    trials: Sequence[CandidateFit]
    still: Covariance
    waves: list[Contender]
    moved: list[Contender]

    def confirmed(self, *, in_pairs: bool) -> list[Contender]:
        """Return each with its evidence beside noise estimated anew.

        In pairs those that do not convince have that of the lasting effect beside them, too.
        """
        sure_of = partial(self._sure_of, in_pairs=in_pairs)
        found = side_by_side(sure_of, [one for one in self.moved if not one.effect.part_of])
        standing = {one.effect.on_altaz for one in found if one.trial.evidence > CONVINCING}
        parts = [
            one
            for one in self.moved
            if one.effect.part_of in standing and _is_all_of_it(one, self.moved)
        ]
        return [*found, *side_by_side(sure_of, parts), *self.waves]

    def _sure_of(self, one: Contender, *, in_pairs: bool) -> Contender:
        # Beside noise that holds still it gained what the noise would have taken.
        sure = evidence_anew(one, self.chosen)
        if sure <= CONVINCING and in_pairs:
            one, sure = _beside_it(one, sure, self.still, self.chosen, self.trials)
        trial = replace(one.trial, evidence=sure, gain=sure)
        beside = self.waves[0].beside if self.waves else None
        return replace(one, trial=trial, beside=beside, sure=sure)


def changes_of(
    problem: Problem,
    present: Covariance,
    chosen: tuple[Chosen, ...],
    trials: Sequence[CandidateFit],
    banned: Collection[str] = (),
    above: float = -np.inf,
) -> Changes:
    """Return the changes that promise more than `above` beside noise that holds still.

    Steps are at their best moment: for hours beside it a drift does as well. `present` is the
    noise of the turn.
    """
    waves = []
    if OSCILLATION not in banned:
        waves = waves_of(problem, chosen, oscillations.proposed(problem, present, chosen, above))
    # What wins must be distinguished from a wave: its columns stand in the case of every change.
    wider = waves[0].problem if waves else problem
    still, best = proposed(problem, present, chosen, trials, banned)
    moved = [refined(wider, still, chosen, trial) for trial in best]
    least = max(CONVINCING, above)
    worth = [one for one in moved if one.trial.evidence > least]
    return Changes(chosen, trials, still, waves, worth)


def _is_all_of_it(part: Contender, moved: Sequence[Contender]) -> bool:
    """Tell whether a part of another change does what all of it does, beside still noise.

    A clock moves the tilt and the zero of azimuth together. One that fits the zero alone moves
    the tilt off, which noise whose nights lean differently forgives.
    """
    whole = [one for one in moved if one.effect.on_altaz == part.effect.part_of]
    return part.trial.evidence >= max(one.trial.evidence for one in whole)


def _beside_it(
    change: Contender,
    sure: float,
    still: Covariance,
    chosen: tuple[Chosen, ...],
    trials: Sequence[CandidateFit],
) -> tuple[Contender, float]:
    """Return a change and its evidence with that of the lasting effect that shows best beside it.

    Two that either alone the noise does as well it may not do together: a step among nights that
    the weather moves, too, at its best moment beside what the weather does.
    """
    found = _best_beside(change, still, chosen, trials)
    if found is None:
        return change, sure
    other, worth = found
    moved = refined(change.problem, still, (*chosen, other), change.trial)
    worlds = [(change, sure)]
    if moved.effect.parameter != change.effect.parameter:
        worlds.append((moved, evidence_anew(moved, chosen)))
    best, most = change, sure
    for one, alone in worlds:
        if alone + worth > CONVINCING:
            after = joined(one.problem, chosen, one.chosen)
            added = confirmed(one.problem, after, other, other.candidate.price)
            if added > CONVINCING and alone + added > most:
                best, most = one, alone + added
    return best, most


def _best_beside(
    change: Contender,
    still: Covariance,
    chosen: tuple[Chosen, ...],
    trials: Sequence[CandidateFit],
) -> tuple[Chosen, float] | None:
    """Return the lasting effect that shows best beside a change, and its evidence there."""
    problem, after = change.problem, joined(change.problem, chosen, change.chosen)
    lasting = [
        one.candidate
        for one in trials
        if one.candidate.effect.physical
        and one.scope == "all"
        and not confounded(problem, one.candidate.effect)
    ]
    if not lasting:
        return None
    best, worth = best_shown(problem, still, after, lasting)
    return (Chosen(best, "all"), worth) if worth > CONVINCING else None
