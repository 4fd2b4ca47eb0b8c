"""Choices made anew from some of the readings: what is left out must not have helped to choose.

Which member of its family an effect is, the moment of a step, the curve of an edge: a choice that
was made from all readings flatters the prediction of those that are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.diagnosis import oscillations
from pyport.diagnosis.case import Anew, Chosen, Problem, WhitenedData, temporal, whiten_model
from pyport.diagnosis.changes import still_noise
from pyport.diagnosis.evidence import at_best
from pyport.diagnosis.refine import refine
from pyport.diagnosis.view import shown_beside
from pyport.effects.oscillation import OSCILLATION
from pyport.noise.covariance import Covariance
from pyport.stages import stage


@stage("choosing anew")
def columns_anew(
    setup: Problem, weighed: WhitenedData, covariance: Covariance, chosen: Sequence[Chosen]
) -> list[Anew]:
    """Return each choice as readings of full weight would choose it.

    Parameters
    ----------
    setup, weighed
        The case and its last weighing.
    covariance
        Its noise, with no weight on the readings that must not choose.
    chosen
        What was chosen from all readings.
    """
    return [
        _anew(setup, weighed, covariance, [each for each in chosen if each is not one], one)
        for one in chosen
    ]


def _anew(
    setup: Problem,
    weighed: WhitenedData,
    covariance: Covariance,
    others: Sequence[Chosen],
    one: Chosen,
) -> Anew:
    effect = one.candidate.effect
    if effect.id == OSCILLATION:
        fresh = oscillations.again(setup, covariance, others, effect)
        if fresh.changes_with == "stretch":
            # Amplitudes that few readings tell would be fitted to their noise.
            curve = oscillations.predicted(setup, covariance, others, fresh)
            return Anew(np.zeros((len(curve), 0)), curve)
        columns = setup.stack.columns(fresh, setup.recordings.at)
        return Anew(columns[:, columns.any(axis=0)])
    family = [each for each in setup.candidates if each.effect.id == effect.id]
    if len(family) < 2 or one.scope != "all":
        return Anew(setup.expanded([one]))
    if temporal(setup, effect):
        covariance = still_noise(setup, covariance)
    white = whiten_model(setup, covariance, (*setup.base, *others))
    seen = replace(weighed, covariance=covariance, white=white)
    worth = [at_best(*each)[0] for each in shown_beside(setup, seen, others, family)]
    best = family[int(np.argmax(worth))]
    if any(each is one.candidate for each in family):
        return Anew(setup.expanded([Chosen(best, one.scope)]))
    wider, refined, *_ = refine(setup, seen, others, Chosen(best, one.scope))
    return Anew(wider.expanded([refined]))
