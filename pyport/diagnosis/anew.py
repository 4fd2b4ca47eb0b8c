"""Choices made anew from some of the readings: what is left out must not have helped to choose.

Which member of its family an effect is, the moment of a step, the curve of an edge: a choice that
was made from all readings flatters the prediction of those that are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen, Problem, WhitenedData, temporal, whiten_model
from pyport.diagnosis.changes import still_noise
from pyport.diagnosis.evidence import at_best, shown
from pyport.diagnosis.refine import refine
from pyport.noise.covariance import Covariance
from pyport.stages import stage


@stage("choosing anew")
def columns_anew(
    setup: Problem, weighed: WhitenedData, covariance: Covariance, chosen: Sequence[Chosen]
) -> list[Array]:
    """Return the columns of each choice, (m, P) each, as readings of full weight would choose it.

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
) -> Array:
    effect = one.candidate.effect
    family = [each for each in setup.candidates if each.effect.id == effect.id]
    if len(family) < 2 or one.scope != "all":
        return setup.expanded([one])
    if temporal(setup, effect):
        covariance = still_noise(setup, covariance)
    white = whiten_model(setup, covariance, (*setup.base, *others))
    best = _best(setup, covariance, white, others, family)
    if any(each is one.candidate for each in family):
        return setup.expanded([Chosen(best, one.scope)])
    seen = replace(weighed, covariance=covariance, white=white)
    wider, refined, *_ = refine(setup, seen, others, Chosen(best, one.scope))
    return wider.expanded([refined])


def _best(
    setup: Problem,
    covariance: Covariance,
    white: Array,
    others: Sequence[Chosen],
    family: Sequence[Candidate],
) -> Candidate:
    """Return the member of a family with the most evidence beside the model and other choices."""
    model = setup.expanded((*setup.base, *others), of=white)
    places = [each.columns for each in family]
    own = covariance.whiten(setup.columns[:, np.concatenate(places)])
    both = np.concatenate([own, white[:, -1:]], axis=1)
    left = both - model @ np.linalg.lstsq(model, both, rcond=1e-9)[0]
    starts = np.cumsum([0, *map(len, places)])
    worth = [
        at_best(*shown(left[:, low:up], np.linalg.norm(own[:, low:up], axis=0), left[:, -1]))[0]
        for low, up in pairwise(starts)
    ]
    return family[int(np.argmax(worth))]
