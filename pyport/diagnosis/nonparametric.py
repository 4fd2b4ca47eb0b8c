"""A field in the place of names: where none of them, nor all together, explain it as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.diagnosis.boxes import boxes
from pyport.diagnosis.case import Chosen, Problem, weigh, weigh_model
from pyport.diagnosis.fields import Ground, Worth, as_candidate
from pyport.diagnosis.significance import family_p_value
from pyport.diagnosis.steps import Outcome, Step
from pyport.diagnosis.winner import predicts, trials_of
from pyport.thresholds import CONVINCING, FAMILY_ERROR, IMPERFECTION, NAME_PRICE


def field_instead(outcome: Outcome, turn: int) -> Outcome | None:
    """Return the search with a field in place of all names from some turn on, if it is better."""
    setup, before, names = outcome.setup, outcome.chosen[:turn], outcome.steps[turn:]
    if not names and family_p_value(outcome.last) > FAMILY_ERROR:
        return None
    weighed = outcome.weighed if not names else weigh_model(setup, before)
    ground = Ground(setup, weighed, before)
    worths = [*ground.worths(), *map(ground.worth_of, boxes(setup, weighed, before))]
    best = max(worths, key=lambda one: one.evidence)
    strongest = max((step.winner.gain for step in outcome.steps[:turn]), default=0.0)
    least = max(CONVINCING, IMPERFECTION * strongest)
    if names:
        least += _together(ground, setup, names)
    if best.evidence <= least or best.directions.shape[1] == 0:
        return None
    return _with_field(setup, before, outcome.steps[:turn], best, outcome.p_value)


def _together(ground: Ground, setup: Problem, names: Sequence[Step]) -> float:
    """Return the evidence of several names together; each beyond the first has its price."""
    columns = setup.expanded([step.chosen for step in names])
    prices = sum(step.winner.gain - step.winner.evidence for step in names)
    return ground.gain(columns) - prices - NAME_PRICE * (len(names) - 1)


def _with_field(
    setup: Problem,
    before: tuple[Chosen, ...],
    steps: tuple[Step, ...],
    worth: Worth,
    p_value: float,
) -> Outcome | None:
    """Return the search with a field added to it; None where it does not predict unseen data."""
    columns = worth.field.columns @ worth.directions
    # Of unit rms, so that a coefficient is the size of what it stands for.
    unit = np.sqrt(np.mean(columns**2, axis=0))
    columns = columns / unit
    places = np.arange(setup.columns.shape[1], setup.columns.shape[1] + columns.shape[1])
    wider = replace(setup, columns=np.concatenate([setup.columns, columns], axis=1))
    candidate = as_candidate(worth, places, unit)
    new = Chosen(candidate, "all")
    seen = weigh(wider, before)
    after = (*before, new)
    if not predicts(wider, seen, before, after, worth.gain):
        return None
    beside = seen.evidence.beside([wider.part(one) for one in (*wider.base, *before)])
    trials = trials_of(wider, beside)
    own = beside.trials([(candidate, "all")])
    if not own:
        return None
    winner = replace(own[0], evidence=worth.evidence)
    chance = family_p_value(trials)
    step = Step(winner, new, (*trials, winner), before, beside, chance, candidate.price)
    return Outcome(wider, after, (*steps, step), weigh(wider, after), p_value, ())
