"""Settling: what a search found once more as a whole, beside the noise that is left.

The search tests each effect as it joins; what joins later may make it useless, and the sum may
predict worse than its parts. Whatever does not pay on data left out, in the scheme that suits it,
is dropped and listed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pyport.diagnosis import joint
from pyport.diagnosis.case import Chosen, confounded
from pyport.diagnosis.folds import folds
from pyport.diagnosis.holdout import unseen
from pyport.diagnosis.naming import classes
from pyport.diagnosis.naming.classes import TIE
from pyport.diagnosis.searching.confirming import lead, likeliest
from pyport.diagnosis.searching.refining import past_outliers
from pyport.diagnosis.searching.turns import Outcome, Step
from pyport.diagnosis.searching.winner import trials_of
from pyport.diagnosis.shapes.drive_waves import is_short
from pyport.diagnosis.weighing import projection, weigh, weigh_model
from pyport.runs.stages import stage
from pyport.thresholds import NOT_EXCLUDED, OUT_OF_REACH, PAYS, SEEN

#: Members of a family, and rivals that follow a condition, tried beside noise of their own at most.
MOST_NOISES = 3


@dataclass(frozen=True)
class Dropped:
    """An effect that was looked at and dropped: what it was, and why."""

    effect: str
    variant: str
    reason: str


@stage("settling findings")
def settled(outcome: Outcome) -> tuple[Outcome, tuple[Dropped, ...]]:
    """Weigh with the final noise, and drop what does not predict unseen data better.

    One at a time; then, while the whole predicts worse than the model alone, the weakest.
    """
    outcome = _of_moments(_of_families(outcome))
    dropped: list[Dropped] = []
    while True:
        weighed = weigh(outcome.problem, outcome.chosen, searching=False)
        outcome = replace(outcome, weighed=weighed)
        worst = _worst(outcome)
        if worst is None:
            return _held_to_the_end(outcome), tuple(dropped)
        one, reason = worst
        effect = one.candidate.effect
        dropped.append(Dropped(effect.id, effect.variant, reason))
        outcome = outcome.without(one)


def _held_to_the_end(outcome: Outcome) -> Outcome:
    """Hold each lasting effect against its rivals once more, beside the final noise.

    The noise in which it was found had grown to hold what it explains, and distinguished it from
    its rivals less well than the noise that is left.
    """
    return replace(outcome, steps=tuple(_in_final_noise(outcome, step) for step in outcome.steps))


def _in_final_noise(outcome: Outcome, step: Step) -> Step:
    """Return a turn beside the final noise, as it was where something changes or was refined."""
    problem, one = outcome.problem, step.chosen
    refined, effect = one.candidate is not step.winner.candidate, one.candidate.effect
    if refined or not effect.physical or effect.changes_with or problem.blocks.antennas > 1:
        return step
    beside = projection(problem, outcome.weighed, outcome.others(one))
    own = beside.trials([(one.candidate, one.scope)])
    if not own:
        return step
    trials = tuple(trials_of(problem, beside))
    return _with_driven_rivals(outcome, replace(step, winner=own[0], trials=trials, beside=beside))


def _with_driven_rivals(outcome: Outcome, step: Step) -> Step:
    """Return a turn in which what follows a condition has the evidence that its own noise leaves.

    Conditions go slowly with time, and so does noise: what such a rival explains is a drift to
    the noise beside the winner.
    """
    problem, best, others = outcome.problem, step.winner, outcome.others(step.chosen)
    driven = [
        one
        for one in step.trials
        if one.candidate.effect.driver is not None
        and not confounded(problem, one.candidate.effect)
        and one.scope == best.scope
        and best.evidence - OUT_OF_REACH < one.evidence < best.evidence - NOT_EXCLUDED
    ]
    driven.sort(key=lambda one: -round(one.evidence, TIE))
    tried = classes.distinct(step.beside, [best, *driven], MOST_NOISES)[1:]
    if not tried:
        return step
    behind = {
        id(one): lead(problem, others, step.chosen, Chosen(one.candidate, one.scope))
        for one in tried
    }
    trials = tuple(
        replace(one, evidence=max(one.evidence, best.evidence - behind.get(id(one), np.inf)))
        for one in step.trials
    )
    return replace(step, trials=trials)


def _of_families(outcome: Outcome) -> Outcome:
    """Choose the members of families anew, each beside the noise that it leaves.

    The search holds all members against one noise, which may have grown to hold what the right
    one explains. What has not the size that physics gives is not the right one.
    """
    problem = outcome.problem
    for one in outcome.chosen:
        step = outcome.step_of(one)
        if one.candidate is not step.winner.candidate or one.candidate.choices == 1:
            continue
        if confounded(problem, one.candidate.effect) or is_short(one.candidate.effect):
            continue
        same = [
            each
            for each in step.trials
            if each.candidate.effect.id == one.candidate.effect.id
            and each.scope == one.scope
            and each.candidate is not one.candidate
            and each.evidence > step.winner.evidence - OUT_OF_REACH
            and classes.fits_physics(each)
        ]
        same.sort(key=lambda each: -round(each.evidence, TIE))
        others = classes.distinct(step.beside, [step.winner, *same], MOST_NOISES)[1:]
        members = [one, *(Chosen(each.candidate, each.scope) for each in others)]
        best = likeliest(problem, outcome.others(one), members) if len(members) > 1 else one
        if best is not one:
            winner = next(each for each in same if each.candidate is best.candidate)
            outcome = outcome.exchanged(one, best, winner=winner)
    return outcome


def _of_moments(outcome: Outcome) -> Outcome:
    """Choose the moments of steps anew where the readings next to them became outliers."""
    for one in outcome.chosen:
        problem, moved = past_outliers(outcome.problem, outcome.weighed, one)
        if not moved:
            continue
        best = likeliest(problem, outcome.others(one), [one, *moved])
        outcome = replace(outcome, problem=problem).exchanged(one, best)
    return outcome


def _worst(outcome: Outcome) -> tuple[Chosen, str] | None:
    """Return the choice that is to be dropped, and why; None where all of them pay.

    Of several that do harm, or have no size, the one with the least evidence: the others may do it
    through it.
    """
    problem, weighed, chosen = outcome.problem, outcome.weighed, outcome.chosen
    idle: list[tuple[Chosen, str]] = []
    for one in chosen:
        partition = folds(problem, weighed, (one,))
        found = unseen(problem, (weighed, weighed), outcome.others(one), chosen, partition)
        before, after = found.rms()
        if before - after <= PAYS * (found.fall_sigma(found.counted, partition.fewest) or 0.0):
            by = 100 * abs(before - after) / max(before, 1e-300)
            how = f"worse with it, by {by:.2g} per cent"
            if before > after:
                how = f"better with it by {by:.2g} per cent, less than the error of that"
            idle.append((one, f"data left out are predicted {how}"))
    idle = idle or _without_size(outcome)
    if idle:
        return min(idle, key=lambda each: outcome.step_of(each[0]).winner.evidence)
    if chosen and (weakest := _harm_to_all(outcome)) is not None:
        return weakest, "with everything found data left out are predicted worse than by the model"
    return None


def _without_size(outcome: Outcome) -> list[tuple[Chosen, str]]:
    """Return the choices whose reported size may be zero.

    Coefficients that are drawn from a prior are drawn toward zero: of these the evidence says it.
    """
    problem, chosen = outcome.problem, outcome.chosen
    together = joint.fit(problem, outcome.weighed, chosen)
    return [
        (one, f"its size is within {SEEN:g} sigma of zero")
        for n, one in enumerate(chosen, len(problem.base))
        if not one.candidate.effect.prior and joint.distance(together, n) < SEEN
    ]


def _harm_to_all(outcome: Outcome) -> Chosen | None:
    """Return the choice that all others do best without, where all do no better than the model."""
    problem, weighed, chosen = outcome.problem, outcome.weighed, outcome.chosen
    alone = weigh_model(problem, (), searching=False)
    partition = folds(problem, weighed, chosen)

    def rms_with(some: tuple[Chosen, ...]) -> tuple[float, float]:
        return unseen(problem, (alone, weighed), (), some, partition).rms()

    before, after = rms_with(chosen)
    if after < before:
        return None
    return min(chosen, key=lambda one: rms_with(outcome.others(one))[1])
