"""The search: add what explains the strongest mismatch, weigh again, until nothing is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen, Problem, confounded
from pyport.diagnosis.naming import classes
from pyport.diagnosis.searching.confirmed_changes import Changes
from pyport.diagnosis.searching.confirming import confirmed
from pyport.diagnosis.searching.contenders import joined
from pyport.diagnosis.searching.instead import field_instead
from pyport.diagnosis.searching.turns import Outcome, Step, family_p_value
from pyport.diagnosis.searching.winner import alone, trials_of, winner_of, without_idle
from pyport.diagnosis.weighing import projection, weigh
from pyport.runs.workers import in_order
from pyport.thresholds import (
    CONVINCING,
    IMPERFECTION,
    MOST_FINDINGS,
)


def search(problem: Problem, tell: Callable[[str], None] = lambda _: None) -> Outcome:
    """Add effects to the model, the best first, while noise alone would not look like that.

    An effect is added only when it also predicts what the fit had not seen;
    the next best takes its turn when it does not. One that a later effect
    made idle is dropped again, one that another now beats makes way for it. An
    effect of known size that does not have it in the end was the wrong one.
    Where a field without a name explains the recordings better than all names
    together, they are wrong names for something else, and the field stands.

    Parameters
    ----------
    problem
        The case.
    tell
        Called with a line about each turn.
    """
    start = Outcome(problem, (), (), weigh(problem), 1.0, ())
    while True:
        outcome = _searched(start, tell)
        wrong = _wrong_sizes(outcome)
        if not wrong:
            standing = _standing(outcome, tell)
            # What the search goes on to find has to stand, too: it may be what was dropped.
            return outcome if standing is outcome else _standing(_walk(standing, tell), tell)
        tell(f"{', '.join(sorted(wrong))}: not the size that physics gives, once more without")
        start = replace(start, banned=start.banned | wrong)


def resumed(outcome: Outcome, tell: Callable[[str], None]) -> Outcome:
    """Go on with names where a search was settled: one that a field replaced gets its place back.

    `outcome`, `tell`: what was settled, and what is called with a line about each turn.
    """
    now = replace(outcome, weighed=weigh(outcome.problem, outcome.chosen))
    return _standing(_walk(now, tell), tell)


def _searched(start: Outcome, tell: Callable[[str], None]) -> Outcome:
    """Return where a search ends, whether a field stands in place of its names or not."""
    outcome, first = _walk(start, tell), 0
    while (found := _first_field(outcome, first)) is not None:
        turn, field = found
        tell(f"{field.steps[-1].winner.candidate.effect.variant}: no effect explains it as well")
        outcome, first = _walk(field, tell), turn + 1
    return outcome


def _first_field(outcome: Outcome, first: int) -> tuple[int, Outcome] | None:
    """Return from which turn on, not before the first, a field is better than names; with it."""
    turns = range(first, min(len(outcome.steps) + 1, MOST_FINDINGS))
    for turn, field in zip(turns, in_order(partial(field_instead, outcome), turns), strict=True):
        if field is not None:
            return turn, field
    return None


def _standing(now: Outcome, tell: Callable[[str], None]) -> Outcome:
    """Drop what the noise, estimated with it and without it, can do as well; the weakest first."""
    before = now
    while now.chosen:
        sure = [_standing_of(now, one) for one in now.chosen]
        weakest = min(range(len(sure)), key=lambda n: sure[n])
        if sure[weakest] > CONVINCING:
            break
        out = now.chosen[weakest]
        tell(f"{out.candidate.effect.id}: the noise does as well")
        now = now.without(out)
    return now if now is before else replace(now, weighed=weigh(now.problem, now.chosen))


def _standing_of(now: Outcome, one: Chosen) -> float:
    """Return the evidence of a choice beside all others, the noise estimated anew."""
    return confirmed(now.problem, now.others(one), one, now.step_of(one).price)


def _wrong_sizes(outcome: Outcome) -> frozenset[str]:
    """Return the chosen effects of known size that do not have it, everything else fitted too."""
    problem, chosen = outcome.problem, outcome.chosen
    found = set()
    for one in chosen:
        if all(c.expected is None for c in one.candidate.effect.coefficients):
            continue
        trial = alone(problem, outcome.weighed, chosen, one)
        if trial is not None and not classes.fits_physics(trial):
            found.add(one.candidate.effect.id)
    return frozenset(found)


def _walk(start: Outcome, tell: Callable[[str], None]) -> Outcome:
    """Go on from where a search stands with the effects that have names."""
    now = start
    first = start.p_value if start.steps else None
    while True:
        problem, chosen, weighed = now.problem, now.chosen, now.weighed
        beside = projection(problem, weighed, chosen)
        trials = tuple(trials_of(problem, beside))
        p_value = family_p_value(trials)
        first = p_value if first is None else first
        winner, nearest = None, None
        if len(now.steps) < MOST_FINDINGS:
            changes = Changes(problem, weighed.covariance, chosen, trials, now.banned)
            winner = winner_of(
                problem,
                weighed,
                chosen,
                trials,
                partial(_imperfect, now.steps),
                beside=beside,
                banned=now.banned,
                changes=changes,
            )
            nearest = changes.nearest() if winner is None else None
        if winner is None:
            return replace(now, p_value=first, last=trials, nearest=nearest)
        trial, problem, new = winner.trial, winner.problem, winner.chosen
        # A Bayes factor bounds the chance that noise alone reaches it.
        p_value = min(p_value, float(np.exp(-winner.sure / 2)))
        if not now.steps:
            first = min(first, p_value)
        tell(f"{trial.candidate.effect.id} ({trial.scope}): p = {p_value:.2g}")
        if winner.beside is not None:
            beside, trials = winner.beside, tuple(trials_of(problem, winner.beside))
        # What a change competed with is what its name must be distinguished from.
        trials = (*winner.rivals, *trials)
        step = Step(trial, new, trials, beside, p_value, winner.price)
        more = joined(problem, chosen, new)
        then = _settled(replace(now, problem=problem, chosen=more, steps=(*now.steps, step)))
        if all(any(one is old for old in chosen) for one in then.chosen):
            return replace(now, p_value=first, last=trials)
        now = _exchanged(then, tell)


def _imperfect(steps: Sequence[Step], problem: Problem, candidate: Candidate) -> float:
    """Return the evidence that what stands may leave to a candidate, its shape a little wrong.

    In the axes that both act in.
    """
    own = problem.axes_of(candidate)
    gains = [step.winner.gain for step in steps if own & problem.axes_of(step.chosen.candidate)]
    return IMPERFECTION * max(gains, default=0.0)


def _settled(now: Outcome) -> Outcome:
    """Weigh with what is chosen, without what that has made idle; only its turns are kept."""
    weighed = weigh(now.problem, now.chosen)
    kept = without_idle(now.problem, weighed, now.chosen)
    if len(kept) < len(now.chosen):
        weighed = weigh(now.problem, kept)
    steps = tuple(step for step in now.steps if any(step.chosen is one for one in kept))
    return replace(now, chosen=kept, steps=steps, weighed=weighed)


def _exchanged(now: Outcome, tell: Callable[[str], None]) -> Outcome:
    """Exchange earlier choices for others that are better beside the latest one."""
    for one in now.chosen[:-1]:
        own = alone(now.problem, now.weighed, now.chosen, one)
        effect = one.candidate.effect
        if own is None or not effect.physical or confounded(now.problem, effect):
            continue
        others = now.others(one)
        beside = projection(now.problem, now.weighed, others)
        trials = tuple(trials_of(now.problem, beside))
        better = winner_of(
            now.problem,
            now.weighed,
            others,
            trials,
            lambda *_, least=own.evidence + CONVINCING: least,  # convincingly more than it has
            beside=beside,
            banned=now.banned,
        )
        if better is None or better.trial.candidate.effect.id == one.candidate.effect.id:
            continue
        trial, problem, new = better.trial, better.problem, better.chosen
        tell(f"{trial.candidate.effect.id} in place of {one.candidate.effect.id}")
        turn = {"winner": trial, "trials": trials, "beside": beside, "price": better.price}
        now = _settled(replace(now, problem=problem).exchanged(one, new, **turn))
    return now
