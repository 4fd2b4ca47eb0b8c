"""A field in place of names: where one form without physics explains more than all names do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import takewhile

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.case import Chosen
from pyport.diagnosis.searching.turns import Outcome, Step, family_p_value
from pyport.diagnosis.searching.winner import predicts, trials_of
from pyport.diagnosis.shapes.boxes import boxes, sectors
from pyport.diagnosis.shapes.cycles import cycles
from pyport.diagnosis.shapes.fields import Ground, Worth, as_candidate
from pyport.diagnosis.shapes.forms import Field
from pyport.diagnosis.weighing import projection, weigh, weigh_model
from pyport.thresholds import (
    CONVINCING,
    ENOUGH_ANTENNAS,
    FAMILY_ERROR,
    IMPERFECTION,
    NAME_PRICE,
)


def field_instead(outcome: Outcome, turn: int) -> Outcome | None:
    """Return the search with a field in place of all names from some turn on, if it is better.

    One that lasts does not stand in place of changes with time, which beside the noise of the
    model alone are mostly noise: they stay.

    A field that no name points at shows by itself: a Bayes factor bounds the chance that noise
    alone reaches it. None in time does, for that is what a drift is like; and none in an array,
    where what the antennas share in a scan is too little known to bear that bound.
    """
    before, names = outcome.steps[:turn], outcome.steps[turn:]
    if not names and outcome.problem.blocks.antennas >= ENOUGH_ANTENNAS:
        return None
    changes = tuple(one for one in names if _stays_changed(one))
    if not changes:
        ways = [(before, names, (False, True) if names else (False,))]
    else:
        lasting = tuple(one for one in names if not _stays_changed(one))
        ways = [(before, names, (True,))]
        ways += [((*before, *changes), lasting, (False,))] if lasting else []
    found = [(*one, way[0]) for way in ways if (one := _best_in_place(outcome, *way)) is not None]
    more, best, kept = max(found, key=lambda one: one[0], default=(0.0, None, ()))
    if best is None or more <= 0 or best.directions.shape[1] == 0:
        return None
    return _with_field(outcome, kept, best)


def _stays_changed(step: Step) -> bool:
    """Tell whether a turn chose a change with time that was not over while it went on.

    What was displaced for a while was seen in some part of the sky, and a field may draw it.
    """
    effect = step.chosen.candidate.effect
    return effect.changes_with != "" and not effect.came_back


def _best_in_place(
    outcome: Outcome, kept: Sequence[Step], names: Sequence[Step], of_time: Sequence[bool]
) -> tuple[float, Worth] | None:
    """Return the best field beside what is kept, and by how much it exceeds the names it replaces.

    `of_time`: which of the fields are tried, those that last and those in time. None where there
    are none.
    """
    problem, chosen = outcome.problem, tuple(one.chosen for one in kept)
    whole = len(kept) == len(outcome.steps)
    weighed = outcome.weighed if whole else weigh_model(problem, chosen)
    ground = Ground(problem, weighed, chosen)
    best = _best(ground, of_time)
    strongest = max((step.winner.gain for step in kept), default=0.0)
    if names:
        together = ground.gain(problem.expanded([step.chosen for step in names]))
        least = max(CONVINCING, IMPERFECTION * max(strongest, together))
        least += _evidence(together, names)
    else:
        least = max(CONVINCING, IMPERFECTION * strongest, -2 * float(np.log(FAMILY_ERROR)))
    if best is None:
        return None
    return (_standing(best) if names else best.evidence) - least, best


def _best(ground: Ground, of_time: Sequence[bool]) -> Worth | None:
    """Return the field that stands highest of those that last, and of those in time."""
    worths = list(ground.worths(of_time))
    if False in of_time:
        worths += map(ground.worth_of, (*boxes(ground), *sectors(ground), *cycles(ground)))
    return max(worths, key=_standing, default=None)


def lasting_instead(outcome: Outcome, one: Chosen) -> Worth | None:
    """Return the best field that lasts, beside what was found before a choice."""
    before = tuple(takewhile(lambda each: each is not one, outcome.chosen))
    weighed = weigh_model(outcome.problem, before)
    return _best(Ground(outcome.problem, weighed, before), (False,))


def _standing(worth: Worth) -> float:
    """Return the evidence by which a field is chosen: that it takes two columns must convince."""
    return worth.evidence - (CONVINCING if worth.field.of_two else 0.0)


def _evidence(gain: float, names: Sequence[Step]) -> float:
    """Return the evidence of names of some gain together; each beyond the first has its price."""
    prices = sum(step.winner.gain - step.winner.evidence for step in names)
    return gain - prices - NAME_PRICE * (len(names) - 1)


def _with_field(outcome: Outcome, steps: tuple[Step, ...], worth: Worth) -> Outcome | None:
    """Return the search with a field beside what some turns chose; None where it predicts not."""
    problem, before = outcome.problem, tuple(one.chosen for one in steps)
    gain, same = worth.gain, next((one for one in steps if _same_bumps(one, worth.field)), None)
    if same is not None:
        worth, steps = _together_with(same, worth), tuple(one for one in steps if one is not same)
    others = tuple(one for one in before if same is None or one is not same.chosen)
    columns = worth.field.columns @ worth.directions
    # Of unit rms, so that a coefficient is the size of what it stands for.
    unit = np.sqrt(np.mean(columns**2, axis=0))
    columns = columns / unit
    places = np.arange(problem.size, problem.size + columns.shape[1])
    wider = problem.with_columns(columns)
    candidate = as_candidate(worth, places, unit)
    new = Chosen(candidate, "all")
    after = (*others, new)
    if not predicts(wider, weigh_model(wider, before), before, after, gain):
        return None
    beside = projection(wider, weigh(wider, others), others)
    trials = trials_of(wider, beside)
    own = beside.trials([(candidate, "all")])
    if not own:
        return None
    winner = replace(own[0], evidence=worth.evidence)
    chance = min(family_p_value(trials), float(np.exp(-worth.evidence / 2)))
    first = outcome.p_value if steps else min(outcome.p_value, chance)
    step = Step(winner, new, (*trials, winner), beside, chance, candidate.price)
    return replace(
        outcome,
        problem=wider,
        chosen=after,
        steps=(*steps, step),
        weighed=weigh(wider, after),
        p_value=first,
        last=(),
    )


def _same_bumps(step: Step, field: Field) -> bool:
    """Tell whether a turn chose a field of the same bumps on an axis of this one."""
    member = step.chosen.candidate.effect.member
    return member.get("bumps") == field.bumps and bool({*member["axes"]} & {*field.axes})


def _together_with(step: Step, worth: Worth) -> Worth:
    """Return a field with what the same bumps were found to draw in an earlier turn.

    One of them is of both axes, or both are of one: the wider holds the other.
    """
    member, new = step.chosen.candidate.effect.member, worth.field
    old = replace(
        new, axes=tuple(member["axes"]), which=tuple(member["which"]), variant=member["variant"]
    )
    wide = max(new, old, key=lambda one: len(one.axes))
    place = {pair: n for n, pair in enumerate(zip(wide.axes, wide.which, strict=True))}

    def widened(field: Field, directions: Array) -> Array:
        out = np.zeros((len(place), directions.shape[1]))
        out[[place[pair] for pair in zip(field.axes, field.which, strict=True)]] = directions
        return out

    before = step.winner
    return Worth(
        wide,
        worth.evidence + before.evidence,
        worth.gain + before.gain,
        np.hstack([widened(old, np.array(member["directions"])), widened(new, worth.directions)]),
        np.concatenate([before.values, worth.values]),
        np.concatenate([member["spread"], worth.spread]),
    )
