"""The search: add what explains the strongest mismatch, weigh again, until nothing is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyport.diagnosis import identify
from pyport.diagnosis.boxes import boxes
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen, Setup, Weighed, weigh
from pyport.diagnosis.evidence import Beside, Blocks, Trial
from pyport.diagnosis.fields import Ground, Worth, as_candidate
from pyport.diagnosis.holdout import folds, unseen_misfit
from pyport.diagnosis.refine import refine
from pyport.diagnosis.significance import family_p_value

#: Chance of any finding where there is nothing to find, by the fitted noise; below the 5 % that
#: are promised because no noise is quite as it was fitted.
FAMILY_ERROR = 0.01
#: A field must beat all names together by this much, in twice the logarithm of the evidence.
FIELD_MARGIN = 6.0
#: What every name beyond the first costs: few things are left out at once, and each name was one
#: of many.
NAME_PRICE = 12.0
MOST_FINDINGS = 8
#: What a strong effect leaves because its shape is known to first order only, as a share of its
#: gain: a further finding must gain more than that.
IMPERFECTION = 0.02
#: This share of what an effect gains in the fit it must gain on data that the fit had not seen.
UNSEEN_SHARE = 0.3
#: So many of the best candidates of a turn may fail on unseen data before the search gives up.
MOST_TRIED = 4


@dataclass(frozen=True)
class Step:
    """One turn of the search.

    Attributes
    ----------
    winner, chosen
        The trial that won, and what was added: the winner with its moment or edge refined.
    trials
        Everything that was tried beside the model of that turn.
    before
        The model of that turn, without the winner.
    beside
        The evidence as it was weighed in that turn, with that model projected out.
    p_value
        Chance that noise alone gives a search as good as this, over all trials.
    """

    winner: Trial
    chosen: Chosen
    trials: tuple[Trial, ...]
    before: tuple[Chosen, ...]
    beside: Beside
    p_value: float


@dataclass(frozen=True)
class Outcome:
    """The end of a search: what was chosen in which turn, and the evidence weighed with all of it.

    `setup` is the case with the columns of what was refined added to it.
    `p_value` is that of the first turn: is there any mismatch at all?
    `last` holds the trials of the turn that found nothing more.
    """

    setup: Setup
    chosen: tuple[Chosen, ...]
    steps: tuple[Step, ...]
    weighed: Weighed
    p_value: float
    last: tuple[Trial, ...]


def search(setup: Setup, tell: Callable[[str], None] = lambda _: None) -> Outcome:
    """Add effects to the model, the best first, while noise alone would not look like that.

    An effect is added only when it also predicts what the fit had not seen;
    the next best takes its turn when it does not. One that a later effect
    made idle is dropped again. Where several effects in a row are needed and a
    field without a name explains the recordings better than all of them
    together, they are wrong names for something else, and the field stands.

    Parameters
    ----------
    setup
        The case.
    tell
        Called with a line about each turn.
    """
    outcome = _walk(Outcome(setup, (), (), weigh(setup), 1.0, ()), tell)
    turn = 0
    while turn <= len(outcome.steps) and len(outcome.steps) < MOST_FINDINGS:
        field = _field_instead(outcome, turn)
        if field is not None:
            found = field.steps[-1].winner.candidate.effect
            tell(f"{found.variant}: no effect explains it as well")
            outcome = _walk(field, tell)
        turn += 1
    return outcome


def _walk(start: Outcome, tell: Callable[[str], None]) -> Outcome:
    """Go on from where a search stands with the effects that have names."""
    setup, chosen, steps, weighed = start.setup, start.chosen, start.steps, start.weighed
    first = start.p_value if steps else None
    while True:
        beside = weighed.evidence.beside([setup.part(one) for one in (*setup.base, *chosen)])
        trials = _trials(setup, beside)
        p_value = family_p_value(trials)
        first = p_value if first is None else first
        winner = None
        if p_value <= FAMILY_ERROR and len(steps) < MOST_FINDINGS:
            strongest = max((step.winner.gain for step in steps), default=0.0)
            winner = _winner(setup, weighed, chosen, trials, IMPERFECTION * strongest)
        if winner is None:
            return Outcome(setup, chosen, steps, weighed, first, tuple(trials))
        trial, setup, new = winner
        tell(f"{trial.candidate.effect.id} ({trial.scope}): p = {p_value:.2g}")
        steps = (*steps, Step(trial, new, tuple(trials), chosen, beside, p_value))
        chosen = _with(setup, chosen, new)
        weighed = weigh(setup, chosen)
        chosen, before = _without_idle(setup, weighed, chosen), chosen
        if len(chosen) < len(before):
            weighed = weigh(setup, chosen)


def _field_instead(outcome: Outcome, turn: int) -> Outcome | None:
    """Return the search with a field in place of all names from some turn on, if it is better."""
    names = outcome.steps[turn:]
    if not names and family_p_value(outcome.last) > FAMILY_ERROR:
        return None
    setup = outcome.setup
    before = names[0].before if names else outcome.chosen
    ground = Ground(setup, weigh(setup, before), before)
    worths = [*ground.worths(), *map(ground.worth_of, boxes(setup, ground.weighed, before))]
    best = max(worths, key=lambda one: one.evidence)
    strongest = max((step.winner.gain for step in outcome.steps[:turn]), default=0.0)
    least = max(FIELD_MARGIN, IMPERFECTION * strongest)
    if names:
        least += _together(ground, setup, names)
    if best.evidence <= least:
        return None
    return _with_field(setup, outcome.steps[:turn], before, best, outcome.p_value)


def _together(ground: Ground, setup: Setup, names: Sequence[Step]) -> float:
    """Return the evidence of several names together; each beyond the first has its price."""
    columns = setup.expanded([step.chosen for step in names])
    prices = sum(step.winner.gain - step.winner.evidence for step in names)
    return ground.gain(columns) - prices - NAME_PRICE * (len(names) - 1)


def _with_field(
    setup: Setup, steps: tuple[Step, ...], before: tuple[Chosen, ...], worth: Worth, p_value: float
) -> Outcome | None:
    """Return the search with a field added to it; None where it does not predict unseen data."""
    columns = worth.field.columns @ worth.directions
    places = np.arange(setup.columns.shape[1], setup.columns.shape[1] + columns.shape[1])
    wider = replace(setup, columns=np.concatenate([setup.columns, columns], axis=1))
    candidate = as_candidate(worth, places)
    new = Chosen(candidate, "all")
    seen = weigh(wider, before)
    after = (*before, new)
    partition = folds(wider, after, setup.seed)
    was, now = (unseen_misfit(wider, seen, one, partition) for one in (before, after))
    if was - now <= UNSEEN_SHARE * min(worth.gain, was):
        return None
    beside = seen.evidence.beside([wider.part(one) for one in (*wider.base, *before)])
    trials = _trials(wider, beside)
    own = beside.trials([(candidate, "all")])
    if not own:
        return None
    winner = replace(own[0], evidence=worth.evidence)
    step = Step(winner, new, (*trials, winner), before, beside, family_p_value(trials))
    weighed = weigh(wider, after)
    return Outcome(wider, after, (*steps, step), weighed, p_value, ())


def _trials(setup: Setup, beside: Beside) -> list[Trial]:
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
    if effect.id.startswith("epoch"):
        return [scope for scope in there if "session" not in scope]
    if effect.common != "antenna":
        return [scope for scope in there if "antenna" not in scope]
    return there if "antenna" in there else ["all"]


def _winner(
    setup: Setup,
    weighed: Weighed,
    chosen: tuple[Chosen, ...],
    trials: Sequence[Trial],
    least: float,
) -> tuple[Trial, Setup, Chosen] | None:
    """Return the effect most worth its coefficients that also predicts unseen data better.

    Nothing wins that gains no more than `least`. Steps and edges compete with their
    moment and curve refined. With the trial comes the case that holds the
    columns of what is to be added, and the choice itself.
    """
    named = [t for t in trials if t.candidate.effect.physical]
    worth = [t for t in named if t.evidence > least and identify.fits_physics(t)]
    worth.sort(key=lambda trial: -trial.evidence)
    ranked = []
    refined: set[str] = set()
    for trial in worth:
        effect = trial.candidate.effect
        score = trial.evidence
        wider, new = setup, Chosen(trial.candidate, trial.scope)
        if effect.id not in refined:
            refined.add(effect.id)
            wider, new, more, price = refine(setup, weighed, chosen, trial)
            added = trial.gain * (more - 1)
            score += added - price
            trial = replace(  # noqa: PLW2901 - the same trial, its moment or edge moved
                trial,
                gain=trial.gain + added,
                delta_bic=trial.delta_bic + added - price,
                evidence=trial.evidence + added - price,
            )
        ranked.append((score, trial, wider, new))
    ranked.sort(key=lambda one: -one[0])
    for _, trial, wider, new in ranked[:MOST_TRIED]:
        after = _with(wider, chosen, new)
        seen = weighed if wider is setup else weigh(wider, chosen)
        partition = folds(wider, after, setup.seed)
        was, now = (unseen_misfit(wider, seen, one, partition) for one in (chosen, after))
        # Predictions count only so far off: no effect can gain more there than all there was.
        if was - now > UNSEEN_SHARE * min(trial.gain, was):
            return trial, wider, new
    return None


def _without_idle(setup: Setup, weighed: Weighed, chosen: tuple[Chosen, ...]) -> tuple[Chosen, ...]:
    """Drop choices that the others have made idle, the idlest first."""
    evidence = weighed.evidence
    price = np.log(max(evidence.pointings, 3))
    while len(chosen) > 1:
        whole = evidence.gram.solve([setup.part(one) for one in (*setup.base, *chosen)])
        worths = []
        for one in chosen:
            others = [setup.part(o) for o in (*setup.base, *chosen) if o is not one]
            less = evidence.gram.solve(others)
            gain = (less.residual - whole.residual) / evidence.common.factor
            worths.append(gain - price * (whole.rank - less.rank))
        if min(worths) > 0:
            break
        idle = int(np.argmin(worths))
        chosen = chosen[:idle] + chosen[idle + 1 :]
    return chosen


def _with(setup: Setup, chosen: tuple[Chosen, ...], new: Chosen) -> tuple[Chosen, ...]:
    """Add a choice; earlier ones whose every curve it can draw make way for it."""
    columns = setup.columns[:, new.candidate.columns]
    groups = setup.blocks.groups(new.scope)
    kept = []
    for one in chosen:
        own = setup.columns[:, one.candidate.columns]
        left = own - columns @ np.linalg.lstsq(columns, own, rcond=1e-9)[0]
        inside = np.linalg.norm(left) < 1e-6 * np.linalg.norm(own)
        # Blocks that share a coefficient of the new choice must share one of the old, too.
        pairs = np.unique(np.stack([groups, setup.blocks.groups(one.scope)]), axis=1)
        if not (inside and len(np.unique(pairs[0])) == pairs.shape[1]):
            kept.append(one)
    return (*kept, new)
