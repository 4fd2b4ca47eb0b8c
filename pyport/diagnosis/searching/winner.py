"""One turn of the search: what is tried, what wins, and what it makes idle."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyport.diagnosis.candidates import Blocks, Candidate
from pyport.diagnosis.case import Chosen, Problem, confounded
from pyport.diagnosis.evidence import CandidateFit, Projection
from pyport.diagnosis.holdout import folds, unseen_misfit
from pyport.diagnosis.searching import turns
from pyport.diagnosis.searching.changes import proposed, refine
from pyport.diagnosis.searching.confirming import confirmed
from pyport.diagnosis.shapes import drive_waves, oscillations
from pyport.diagnosis.weighing import WhitenedData, best_shown, seen_beside, weigh
from pyport.effects.base import Effect
from pyport.effects.empirical.fields import OSCILLATION
from pyport.runs.workers import side_by_side
from pyport.thresholds import CONVINCING, LEADS, MOST_TRIED, UNSEEN_SHARE


def trials_of(setup: Problem, beside: Projection) -> list[CandidateFit]:
    """Try every effect and shape in every scope that makes sense for it."""
    return beside.trials(
        [
            (candidate, scope)
            for candidate in (*setup.candidates, *setup.shapes)
            for scope in _scopes(candidate, setup.blocks)
        ]
    )


def _scopes(candidate: Candidate, blocks: Blocks) -> list[str]:
    """Return the scopes that the effect's physics allows.

    A clock is one for all antennas; a mount does not change from session to
    session, and the effects of epochs are there for the one that does. Only an
    array can show what is common to its antennas in a session, so there every
    scope is tried.
    """
    effect, there = candidate.effect, blocks.scopes()
    if not effect.physical:
        return ["all"]
    if effect.is_change:
        there = [scope for scope in there if "session" not in scope]
    if effect.common != "antenna":
        return [scope for scope in there if "antenna" not in scope]
    return there if "antenna" in there else ["all"]


@dataclass(frozen=True)
class Winner:
    """What a turn adds: its trial, the case with its columns, the choice.

    `price` is what its choice among its family costs, a refined moment or edge included.
    `beside` is what it was tried in where that is not the turn's: a wave's columns joined the case.
    `rivals` are the other changes, each with the evidence that the noise leaves it.
    """

    trial: CandidateFit
    setup: Problem
    chosen: Chosen
    price: float
    beside: Projection | None = None
    rivals: tuple[CandidateFit, ...] = ()


def winner_of(
    setup: Problem,
    weighed: WhitenedData,
    chosen: tuple[Chosen, ...],
    trials: Sequence[CandidateFit],
    least: float,
    *,
    beside: Projection,
    banned: Collection[str] = (),
    mismatch: bool = True,
    changes: bool = True,
) -> Winner | None:
    """Return the effect most worth its coefficients that also predicts unseen data better.

    Nothing wins whose evidence is no more than `least`, or that is `banned`, or that the noise,
    estimated anew, does as well. Steps and edges compete with their moment and curve refined. What
    changes with time is looked for unless no `changes` are, and without a `mismatch` beside the
    present noise only short waves of drives are, whose periods no trial has: the noise may have
    swallowed a change, and no other effect. A change that promises less than a lasting effect gains
    waits until that effect has failed.
    """
    turn = (setup, weighed, chosen, trials, banned)
    drives = _of_drives(setup, weighed, chosen, least, banned) if changes else []
    lasting = [*(_lasting(*turn, least, beside) if mismatch else []), *drives]
    lead = max((one.trial.evidence for one in lasting), default=-np.inf)
    moved = _changes(*turn, lead) if changes else []
    if moved and not mismatch:
        lasting = [*_lasting(*turn, least, beside), *drives]
    found = _first(weighed, chosen, moved, lasting)
    if found is None and changes and lead > -np.inf:
        moved = _changes(*turn, -np.inf)
        found = _first(weighed, chosen, moved, lasting) if moved else None
    return found


def _first(
    weighed: WhitenedData,
    chosen: tuple[Chosen, ...],
    moved: Sequence[Winner],
    lasting: Sequence[Winner],
) -> Winner | None:
    """Return the best of the changes and of the lasting effects that stands its tests."""
    if moved:
        # What was there all along may pass for a change, and a change for it: both compete by
        # what the noise cannot do.
        sure = side_by_side(lambda one: _confirmed(one, chosen), lasting)
        lasting = [
            replace(one, trial=replace(one.trial, evidence=max(one.trial.evidence, odds)))
            for odds, one in zip(sure, lasting, strict=True)
            if odds > CONVINCING
        ]
    for one in sorted([*moved, *lasting], key=_rank)[:MOST_TRIED]:
        if confounded(one.setup, one.chosen.candidate.effect):
            return replace(one, rivals=tuple(each.trial for each in moved if each is not one))
        after = joined(one.setup, chosen, one.chosen)
        if not predicts(one.setup, weighed, chosen, after, one.trial.gain):
            continue
        if moved or _confirmed(one, chosen) > CONVINCING:
            return one
    return None


def _rank(one: Winner) -> float:
    return -round(one.trial.evidence, turns.TIE)


def _changes(
    setup: Problem,
    weighed: WhitenedData,
    chosen: tuple[Chosen, ...],
    trials: Sequence[CandidateFit],
    banned: Collection[str],
    above: float,
) -> list[Winner]:
    """Return the changes with time that are more than the noise can do."""
    found = confirmed_changes(setup, weighed, chosen, trials, banned, above)
    return [one for one in found if one.trial.evidence > CONVINCING]


def confirmed_changes(
    setup: Problem,
    weighed: WhitenedData,
    chosen: tuple[Chosen, ...],
    trials: Sequence[CandidateFit],
    banned: Collection[str] = (),
    above: float = -np.inf,
) -> list[Winner]:
    """Return the changes that are proposed, each with its evidence beside noise estimated anew.

    Only those that promise more than `above` beside noise that holds still: steps at their best
    moment, for hours beside it a drift does as well.
    """
    waves = [] if OSCILLATION in banned else _oscillating(setup, weighed, chosen, above)
    # What wins must be told from a wave: its columns stand in the case of every change.
    wider, beside = (waves[0].setup, waves[0].beside) if waves else (setup, None)
    still, best = proposed(setup, weighed, chosen, trials, banned)
    moved = [_refined(wider, still, chosen, trial) for trial in best]

    def sure_of(one: Winner) -> Winner:
        # Beside noise that holds still it gained what the noise would have taken.
        sure = _confirmed(one, chosen)
        if sure <= CONVINCING:
            one, sure = _beside_it(one, sure, still, chosen, trials)
        return replace(one, trial=replace(one.trial, evidence=sure, gain=sure), beside=beside)

    least = max(CONVINCING, above)
    worth = [one for one in moved if one.trial.evidence > least]
    found = side_by_side(sure_of, [one for one in worth if not _effect(one).part_of])
    standing = {_name(one) for one in found if one.trial.evidence > CONVINCING}
    found += side_by_side(sure_of, [one for one in worth if _effect(one).part_of in standing])
    return [*found, *waves]


def _effect(one: Winner) -> Effect:
    return one.chosen.candidate.effect


def _name(one: Winner) -> str:
    """Return the id of a winner on an alt-azimuth mount."""
    return _effect(one).of or _effect(one).id


def _beside_it(
    change: Winner,
    sure: float,
    still: WhitenedData,
    chosen: tuple[Chosen, ...],
    trials: Sequence[CandidateFit],
) -> tuple[Winner, float]:
    """Return a change and its evidence with that of the lasting effect that shows best beside it.

    Two that either alone the noise does as well it may not do together: a step among nights that
    the weather moves, too, at its best moment beside what the weather does.
    """
    found = _best_beside(change, still, chosen, trials)
    if found is None:
        return change, sure
    other, worth = found
    best, most = change, sure
    seen = seen_beside(change.setup, still, still.covariance, (*chosen, other))
    moved = _refined(change.setup, seen, (*chosen, other), change.trial)
    for one in (change, moved):
        alone = _confirmed(one, chosen)
        if alone + worth > CONVINCING:
            after = joined(one.setup, chosen, one.chosen)
            added = confirmed(one.setup, after, other, other.candidate.price)
            if added > CONVINCING and alone + added > most:
                best, most = one, alone + added
    return best, most


def _best_beside(
    change: Winner,
    still: WhitenedData,
    chosen: tuple[Chosen, ...],
    trials: Sequence[CandidateFit],
) -> tuple[Chosen, float] | None:
    """Return the lasting effect that shows best beside a change, and its evidence there."""
    setup, after = change.setup, joined(change.setup, chosen, change.chosen)
    lasting = [
        one.candidate
        for one in trials
        if one.candidate.effect.physical
        and one.scope == "all"
        and not confounded(setup, one.candidate.effect)
    ]
    if not lasting:
        return None
    seen = seen_beside(setup, still, still.covariance, after)
    best, worth = best_shown(setup, seen, after, lasting)
    return (Chosen(best, "all"), worth) if worth > CONVINCING else None


def _oscillating(
    setup: Problem, weighed: WhitenedData, chosen: tuple[Chosen, ...], above: float
) -> list[Winner]:
    """Return the oscillation that is proposed, if any, as a winner whose period is a new one."""
    one = oscillations.proposed(setup, weighed.covariance, chosen, above)
    return [] if one is None else _of_its_case(setup, chosen, one)


def _of_drives(
    setup: Problem,
    weighed: WhitenedData,
    chosen: tuple[Chosen, ...],
    least: float,
    banned: Collection[str],
) -> list[Winner]:
    """Return the short wave of a drive that is proposed, if any and worth more than the least."""
    one = drive_waves.proposed(setup, weighed.covariance, chosen)
    found = [] if one is None else _of_its_case(setup, chosen, one)
    return [
        each
        for each in found
        if each.trial.evidence > least and each.chosen.candidate.effect.id not in banned
    ]


def _of_its_case(setup: Problem, chosen: tuple[Chosen, ...], one: Chosen) -> list[Winner]:
    """Return a wave that the noise cannot do as well, as a winner that brings its columns."""
    wider, price = oscillations.widened(setup, one), one.candidate.price
    sure = confirmed(wider, chosen, one, price)
    if sure <= CONVINCING:
        return []
    seen = weigh(wider, chosen)
    beside = seen.evidence.beside([wider.part(each) for each in (*wider.base, *chosen)])
    trials = beside.trials([(one.candidate, one.scope)])
    return [
        Winner(replace(each, evidence=sure, gain=sure, delta_bic=sure), wider, one, price, beside)
        for each in trials
    ]


def _lasting(
    setup: Problem,
    weighed: WhitenedData,
    chosen: tuple[Chosen, ...],
    trials: Sequence[CandidateFit],
    banned: Collection[str],
    least: float,
    beside: Projection,
) -> list[Winner]:
    """Return the best lasting effects above the least evidence, edges where they fit best.

    Of those that draw the same curve the first stands for all.
    """
    found = []
    refined: set[str] = set()
    for trial in _worth(setup, trials, least, banned):
        one = Winner(trial, setup, Chosen(trial.candidate, trial.scope), trial.candidate.price)
        if trial.candidate.effect.id not in refined:
            refined.add(trial.candidate.effect.id)
            one = _refined(setup, weighed, chosen, trial)
        if one.trial.evidence > least:
            found.append(one)
    found.sort(key=_rank)
    tried = turns.distinct(beside, (one.trial for one in found), MOST_TRIED)
    return [one for one in found if any(one.trial is each for each in tried)]


def _refined(
    setup: Problem, weighed: WhitenedData, chosen: tuple[Chosen, ...], trial: CandidateFit
) -> Winner:
    """Return a trial with its moment or edge moved to where it fits best."""
    plain = Chosen(trial.candidate, trial.scope)
    wider, new, more, price = refine(setup, weighed, chosen, plain)
    added = trial.gain * (more - 1)
    better = replace(
        trial,
        gain=trial.gain + added,
        delta_bic=trial.delta_bic + added - price,
        evidence=trial.evidence + added - price,
    )
    return Winner(better, wider, new, price + new.candidate.price)


def _confirmed(one: Winner, chosen: tuple[Chosen, ...]) -> float:
    """Return the evidence of a winner in the world that it makes, its price paid."""
    others = joined(one.setup, chosen, one.chosen)[:-1]
    return confirmed(one.setup, others, one.chosen, one.price)


def _worth(
    setup: Problem, trials: Sequence[CandidateFit], least: float, banned: Collection[str]
) -> list[CandidateFit]:
    """Return the named trials that are worth a closer look, the best first.

    One whose known size does not come out is among them only where it leads by
    far: what else was left out may have bent it.
    """
    named = [
        t
        for t in trials
        if t.candidate.effect.physical
        and not confounded(setup, t.candidate.effect)
        and t.evidence > least
        and t.candidate.effect.id not in banned
    ]
    named.sort(key=lambda trial: -round(trial.evidence, turns.TIE))
    sound = [trial for trial in named if turns.fits_physics(trial)]
    best = sound[0].evidence if sound else least
    leader = next((t for t in named if turns.seen(t)), None)
    if leader is not None and leader.evidence > best + LEADS:
        return [leader, *sound]
    return sound


def predicts(
    setup: Problem,
    weighed: WhitenedData,
    before: tuple[Chosen, ...],
    after: tuple[Chosen, ...],
    gain: float,
) -> bool:
    """Tell whether what was added gains enough on data that the fit had not seen.

    Predictions count only so far off: no effect can gain more there than all there was.
    """
    partition = folds(setup, weighed, after)
    was, now = (unseen_misfit(setup, weighed, one, partition) for one in (before, after))
    return was - now > UNSEEN_SHARE * min(gain, was)


def alone(
    setup: Problem, weighed: WhitenedData, chosen: tuple[Chosen, ...], one: Chosen
) -> CandidateFit | None:
    """Return the trial of a choice beside all the others; None where they can draw all of it."""
    others = [setup.part(each) for each in (*setup.base, *chosen) if each is not one]
    beside = weighed.evidence.beside(others, only=one.candidate.columns)
    trials = beside.trials([(one.candidate, one.scope)])
    return trials[0] if trials else None


def without_idle(
    setup: Problem, weighed: WhitenedData, chosen: tuple[Chosen, ...]
) -> tuple[Chosen, ...]:
    """Drop choices that the others have made idle, the idlest first."""
    while len(chosen) > 1:
        trials = [alone(setup, weighed, chosen, one) for one in chosen]
        worth = [-np.inf if trial is None else trial.evidence for trial in trials]
        idle = int(np.argmin(worth))
        if worth[idle] > 0:
            break
        chosen = chosen[:idle] + chosen[idle + 1 :]
    return chosen


def joined(setup: Problem, chosen: tuple[Chosen, ...], new: Chosen) -> tuple[Chosen, ...]:
    """Add a choice; earlier ones whose every curve it can draw make way for it."""
    columns = setup.picked(new.candidate.columns)
    groups = setup.blocks.groups(new.scope)
    kept = []
    for one in chosen:
        own = setup.picked(one.candidate.columns)
        left = own - columns @ np.linalg.lstsq(columns, own, rcond=1e-9)[0]
        inside = np.linalg.norm(left) < 1e-6 * np.linalg.norm(own)
        # Blocks that share a coefficient of the new choice must share one of the old, too.
        pairs = np.unique(np.stack([groups, setup.blocks.groups(one.scope)]), axis=1)
        if not (inside and len(np.unique(pairs[0])) == pairs.shape[1]):
            kept.append(one)
    return (*kept, new)
