"""Changes with time, proposed: beside noise that holds still, for the present noise may hold them.

A noise that was estimated beside the model alone has taken a step for a night's departure or a
drift, and beside it the step gains nothing. So changes are looked for beside what the noise does
within a session; whether one is more than the noise can do is then for its confirmation to say.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from pyport.diagnosis.case import Chosen, Problem, WhitenedData, temporal, whiten_model
from pyport.diagnosis.evidence import CandidateFit, at_best
from pyport.diagnosis.identify import TIE
from pyport.diagnosis.view import shown_beside
from pyport.effects.oscillation import OSCILLATION
from pyport.noise.covariance import Covariance
from pyport.stages import stage
from pyport.thresholds import CONVINCING, MOST_CHANGES


@stage("proposing changes")
def proposed(
    setup: Problem,
    weighed: WhitenedData,
    chosen: Sequence[Chosen],
    trials: Sequence[CandidateFit],
    banned: Collection[str],
) -> tuple[WhitenedData, list[CandidateFit]]:
    """Return the case beside noise that holds still, and the best change of each kind there.

    `trials` are those of the turn; a change that shows in none of them is not proposed, nor one
    of a term that the model lacks: first that term is looked for. Oscillations are proposed by
    `oscillations`, which looks for their period.
    """
    effects = [one.candidate.effect for one in (*setup.base, *chosen)]
    has = {"", *(one.of or one.id for one in effects)}
    wanted = [
        one
        for one in trials
        if one.candidate.effect.physical
        and temporal(setup, one.candidate.effect)
        and one.candidate.effect.id not in {*banned, OSCILLATION}
        and one.candidate.effect.change_of in has
    ]
    still = still_noise(setup, weighed.covariance)
    white = whiten_model(setup, still, (*setup.base, *chosen))
    beside = WhitenedData(still, white, weighed.evidence)
    if not wanted:
        return beside, []
    seen = shown_beside(setup, beside, chosen, [one.candidate for one in wanted])
    best: dict[str, CandidateFit] = {}
    for trial, (power, along) in zip(wanted, seen, strict=True):
        if trial.scope != "all" or not len(power):
            continue
        evidence = at_best(power, along)[0] - trial.candidate.price
        gain = float((along**2 / power).sum())
        held = best.get(trial.candidate.effect.id)
        if evidence > CONVINCING and (held is None or evidence > held.evidence):
            best[trial.candidate.effect.id] = replace(trial, gain=gain, evidence=evidence)
    ranked = sorted(best.values(), key=lambda one: -round(one.evidence, TIE))
    return beside, ranked[:MOST_CHANGES]


def still_noise(setup: Problem, covariance: Covariance) -> Covariance:
    """Return what scatters and drifts within a session: no departures, no longer memory.

    A longer memory shows within a session by the share of its variance that it changes there.
    Within a single session nothing drifts.
    """
    longest = _session_s(setup)
    noises = tuple(
        replace(
            one,
            drifts=tuple(
                (amplitude * float(np.sqrt(min(1.0, longest / memory))), min(memory, longest))
                for amplitude, memory in one.drifts
                if longest > 0
            ),
        )
        for one in covariance.noises
    )
    return replace(covariance, noises=noises, departures=())


def _session_s(setup: Problem) -> float:
    """Return how long a session usually takes [s], 0 of a single one."""
    sessions = np.unique(setup.session)
    if len(sessions) == 1:
        return 0.0
    spans = [
        float(np.ptp(part.time[own]))
        for part in setup.parts
        if part.time is not None
        for one in sessions
        if (own := setup.session[part.first] == one).any()
    ]
    return float(np.median(spans)) if spans else 0.0
