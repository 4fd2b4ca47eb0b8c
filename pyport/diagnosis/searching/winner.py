"""One turn of the search: what is tried, what wins, and what it makes idle."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from pyport.diagnosis.candidates import Blocks, Candidate
from pyport.diagnosis.case import Chosen, Problem, confounded
from pyport.diagnosis.evidence import Projection
from pyport.diagnosis.folds import folds
from pyport.diagnosis.holdout import unseen_misfit
from pyport.diagnosis.naming import classes
from pyport.diagnosis.searching.confirmed_changes import Changes
from pyport.diagnosis.searching.contenders import (
    Contender,
    evidence_anew,
    joined,
    refined,
    waves_of,
)
from pyport.diagnosis.shapes import drive_waves
from pyport.diagnosis.trial import CandidateFit
from pyport.diagnosis.weighing import WhitenedData
from pyport.effects.base import HELD
from pyport.thresholds import CONVINCING, LEADS, MOST_TRIED, PER_SHAPE, UNSEEN_SHARE

#: Evidence that a candidate of a case must exceed.
Least = Callable[[Problem, Candidate], float]


def trials_of(problem: Problem, beside: Projection) -> list[CandidateFit]:
    """Try every effect in every scope that has enough readings for it."""
    most = len(problem.residual) // PER_SHAPE
    return beside.trials(
        [
            (candidate, scope)
            for candidate in problem.candidates
            for scope in _scopes(candidate, problem.blocks)
            if scope == "all" or len(candidate.columns) * problem.blocks.count(scope) <= most
        ]
    )


def _scopes(candidate: Candidate, blocks: Blocks) -> list[str]:
    """Return the scopes that the effect's physics allows.

    A clock is one for all antennas; a mount does not change from session to
    session, and the effects of epochs are there for the one that does. Only an
    array can show what is common to its antennas in a session, so there every
    scope is tried, but for the place where an antenna stands.
    """
    effect, there = candidate.effect, blocks.scopes()
    place = effect.in_arrays == HELD and effect.common == "antenna"
    if effect.is_change or place:
        there = [scope for scope in there if "session" not in scope]
    if effect.common != "antenna":
        return [scope for scope in there if "antenna" not in scope]
    return there if "antenna" in there else ["all"]


def winner_of(
    problem: Problem,
    weighed: WhitenedData,
    chosen: tuple[Chosen, ...],
    trials: Sequence[CandidateFit],
    least: Least,
    *,
    beside: Projection,
    banned: Collection[str],
    changes: Changes | None = None,
) -> Contender | None:
    """Return the effect most worth its coefficients that also predicts unseen data better.

    Nothing wins whose evidence is no more than the `least`, or that is `banned`, or that the noise,
    estimated anew, does as well. Steps and edges compete with their moment and curve refined. What
    changes with time is looked for where `changes` are given. One that promises less than a lasting
    effect gains waits until that effect has failed.
    """
    lasting = lasting_effects(problem, weighed, chosen, trials, banned, least, beside)
    if changes is not None:
        lasting += _of_drives(problem, weighed, chosen, least, banned)
    lead = max((one.trial.evidence for one in lasting), default=-np.inf)
    # Noise is estimated anew, which takes long, only for what can stand.
    lasting = [one for one in lasting if one.trial.evidence > CONVINCING]
    if changes is None:
        return _first(weighed, chosen, [], lasting)
    found = _first(weighed, chosen, _convincing(changes.confirmed(lead)), lasting)
    if found is None and lasting:
        moved = _convincing(changes.confirmed(-np.inf))
        found = _first(weighed, chosen, moved, lasting) if moved else None
    return found


def _convincing(found: Sequence[Contender]) -> list[Contender]:
    """Return the changes with time that are more than the noise can do."""
    return [one for one in found if one.trial.evidence > CONVINCING]


def _first(
    weighed: WhitenedData,
    chosen: tuple[Chosen, ...],
    moved: Sequence[Contender],
    lasting: Sequence[Contender],
) -> Contender | None:
    """Return the best of the changes and of the lasting effects that stands its tests."""
    if moved:
        # What was there all along may pass for a change, and a change for it: both compete by
        # what the noise cannot do.
        lasting = [
            _at_least(one, anew)
            for one in lasting
            if (anew := evidence_anew(one, chosen)) > CONVINCING
        ]
    for one in sorted([*moved, *lasting], key=_rank)[:MOST_TRIED]:
        if confounded(one.problem, one.effect):
            return replace(one, rivals=tuple(each.trial for each in moved if each is not one))
        after = joined(one.problem, chosen, one.chosen)
        if not predicts(one.problem, weighed, chosen, after, one.trial.gain):
            continue
        if not moved:
            one = replace(one, sure=evidence_anew(one, chosen))  # noqa: PLW2901 - it, looked at
        if one.sure > CONVINCING:
            return one
    return None


def _at_least(one: Contender, anew: float) -> Contender:
    """Return a lasting effect that competes by the better of both kinds of evidence."""
    trial = replace(one.trial, evidence=max(one.trial.evidence, anew))
    return replace(one, trial=trial, sure=anew)


def _rank(one: Contender) -> float:
    return -round(one.trial.evidence, classes.TIE)


def _of_drives(
    problem: Problem,
    weighed: WhitenedData,
    chosen: tuple[Chosen, ...],
    least: Least,
    banned: Collection[str],
) -> list[Contender]:
    """Return the short wave of a drive that is proposed, if any and worth more than the least."""
    one = drive_waves.proposed(problem, weighed.covariance, chosen)
    return [
        each
        for each in waves_of(problem, chosen, one)
        if each.trial.evidence > least(each.problem, each.chosen.candidate)
        and each.effect.id not in banned
    ]


def lasting_effects(
    problem: Problem,
    weighed: WhitenedData,
    chosen: tuple[Chosen, ...],
    trials: Sequence[CandidateFit],
    banned: Collection[str],
    least: Least,
    beside: Projection,
) -> list[Contender]:
    """Return the best lasting effects above the least evidence, edges where they fit best.

    Of those that draw the same curve the first stands for all.
    """
    found = []
    moved: set[str] = set()
    several = _worth(problem, trials, least, banned)
    for trial in several:
        one = Contender(trial, problem, Chosen(trial.candidate, trial.scope), trial.candidate.price)
        if trial.candidate.effect.id not in moved:
            moved.add(trial.candidate.effect.id)
            one = refined(problem, weighed.covariance, chosen, trial)
        # In an array each pays for itself: its odds are those of the turn.
        shared = together(trial, several) if problem.blocks.antennas == 1 else 0.0
        if one.trial.evidence > least(problem, trial.candidate):
            found.append(replace(one, price=one.price - shared))
    found.sort(key=_rank)
    tried = classes.distinct(beside, (one.trial for one in found), MOST_TRIED)
    return [one for one in found if any(one.trial is each for each in tried)]


def together(trial: CandidateFit, several: Sequence[CandidateFit]) -> float:
    """Return by how much likelier it is that one of several effects is there than that one.

    Twice the log, over those of its scope that it leads: of names that the data do not distinguish
    each is one of many, and all of them together are not.
    """
    behind = [
        each.evidence - trial.evidence
        for each in several
        if each.scope == trial.scope and each.evidence <= trial.evidence
    ]
    return 2 * float(np.log(np.exp(np.array(behind) / 2).sum()))


def _worth(
    problem: Problem, trials: Sequence[CandidateFit], least: Least, banned: Collection[str]
) -> list[CandidateFit]:
    """Return the named trials that are worth a closer look, the best first.

    One whose known size does not come out is among them only where it leads by
    far: what else was left out may have bent it.
    """
    named = [
        t
        for t in trials
        if not confounded(problem, t.candidate.effect)
        and t.candidate.effect.id not in banned
        and t.evidence > least(problem, t.candidate)
    ]
    named.sort(key=lambda trial: -round(trial.evidence, classes.TIE))
    sound = [trial for trial in named if classes.fits_physics(trial)]
    leader = next((t for t in named if classes.seen(t)), None)
    if leader is not None:
        best = sound[0].evidence if sound else least(problem, leader.candidate)
        if leader.evidence > best + LEADS:
            return [leader, *sound]
    return sound


def predicts(
    problem: Problem,
    weighed: WhitenedData,
    before: tuple[Chosen, ...],
    after: tuple[Chosen, ...],
    gain: float,
) -> bool:
    """Tell whether what was added gains enough on data that the fit had not seen.

    Predictions count only so far off: no effect can gain more there than all there was.
    """
    partition = folds(problem, weighed, after)
    was, now = (unseen_misfit(problem, weighed, one, partition) for one in (before, after))
    return was - now > UNSEEN_SHARE * min(gain, was)


def alone(
    problem: Problem, weighed: WhitenedData, chosen: tuple[Chosen, ...], one: Chosen
) -> CandidateFit | None:
    """Return the trial of a choice beside all the others; None where they can draw all of it."""
    others = [problem.part(each) for each in (*problem.base, *chosen) if each is not one]
    beside = weighed.evidence.beside(others, only=one.candidate.columns)
    trials = beside.trials([(one.candidate, one.scope)])
    return trials[0] if trials else None


def without_idle(
    problem: Problem, weighed: WhitenedData, chosen: tuple[Chosen, ...]
) -> tuple[Chosen, ...]:
    """Drop choices that the others have made idle, the idlest first."""
    while len(chosen) > 1:
        trials = [alone(problem, weighed, chosen, one) for one in chosen]
        worth = [-np.inf if trial is None else trial.evidence for trial in trials]
        idle = int(np.argmin(worth))
        if worth[idle] > 0:
            break
        chosen = chosen[:idle] + chosen[idle + 1 :]
    return chosen
