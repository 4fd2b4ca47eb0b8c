"""Changes with time, proposed: beside noise that holds still, for the present noise may hold them.

A noise that was estimated beside the model alone has taken a step for a night's departure or a
drift, and beside it the step gains nothing. So changes are looked for beside what the noise does
within a session; whether one is more than the noise can do is then for its confirmation to say.

Which member of its family an effect is, the moment of a step, the curve of an edge: a choice that
was made from all readings flatters the prediction of those that are left out.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.diagnosis.case import Chosen, Problem, confounded
from pyport.diagnosis.searching.refining import refine
from pyport.diagnosis.shapes import drive_waves, oscillations, wave_fits
from pyport.diagnosis.trial import CandidateFit, at_best
from pyport.diagnosis.weighing import best_shown, shown_beside
from pyport.effects import Effect
from pyport.effects.empirical.oscillations import OSCILLATION
from pyport.noise.covariance import Covariance
from pyport.recordings.sky import clock
from pyport.runs.stages import stage
from pyport.thresholds import FEWEST


@stage("proposing changes")
def proposed(
    problem: Problem,
    present: Covariance,
    chosen: Sequence[Chosen],
    trials: Sequence[CandidateFit],
    banned: Collection[str],
) -> tuple[Covariance, list[CandidateFit]]:
    """Return the noise that holds still, and the best changes of each kind beside it.

    Of each kind they are the best step and the best of the others, which lie in one session.
    `present` is the noise of the turn, `trials` are its trials; a change that shows in none of them
    is not proposed, nor one of a term that the model lacks: first that term is looked for. One
    source's place is proposed like a change, for the noise may have taken it for what all sources
    scatter by. Oscillations are proposed by `oscillations`, which looks for their period.
    """
    effects = [one.candidate.effect for one in (*problem.base, *chosen)]
    has = {"", *(one.on_altaz for one in effects)}
    wanted = [
        one
        for one in trials
        if confounded(problem, one.candidate.effect)
        and one.candidate.effect.id not in {*banned, OSCILLATION}
        and one.candidate.effect.change_of in has
        and not _departs(problem, one.candidate.effect)
    ]
    still = still_noise(problem, present)
    if not wanted:
        return still, []
    seen = shown_beside(problem, still, chosen, [one.candidate for one in wanted])
    best: dict[tuple[str, bool], CandidateFit] = {}
    for trial, (power, along) in zip(wanted, seen, strict=True):
        if trial.scope != "all" or not len(power):
            continue
        evidence = at_best(power, along)[0] - trial.candidate.price
        gain = float((along**2 / power).sum())
        # One night apart from all others, which noise does as well, hides no step within a night.
        kind = trial.candidate.effect.id, trial.candidate.effect.parameter is None
        held = best.get(kind)
        if held is None or evidence > held.evidence:
            best[kind] = replace(trial, gain=gain, evidence=evidence)
    return still, list(best.values())


def _departs(problem: Problem, effect: Effect) -> bool:
    """Tell whether an effect is what departures do: one of each label, not of one among them."""
    labels = {one.of for one in problem.frame.departures}
    return effect.belongs_to in labels and len(effect.member.get(f"{effect.belongs_to}s", ())) > 1


def still_noise(problem: Problem, covariance: Covariance) -> Covariance:
    """Return what scatters and drifts within a session: no departures, no longer memory.

    Of a single session nothing drifts. Outliers that follow each other are readings again: what
    was displaced for a while is no mistake of each.
    """
    session = _session_s(problem)
    noises = tuple(one.shown_within(session) for one in covariance.noises)
    weights = np.where(_consecutive(problem, ~covariance.used), 1.0, covariance.weights)
    return replace(covariance, noises=noises, departures=(), weights=weights)


def _consecutive(problem: Problem, outlying: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Tell which readings are of pointings that follow each other and are outlying all, (m,).

    As many as have `FEWEST` readings.
    """
    row = problem.stack.row
    of_row = np.zeros(row.max() + 1, np.bool_)
    of_row[row[outlying]] = True
    order = np.unique(row)
    order = order[np.argsort(clock(problem.recordings.at)[order], kind="stable")]
    turns = np.flatnonzero(np.diff(of_row[order], prepend=False, append=False))
    for first, behind in turns.reshape(-1, 2):
        of_row[order[first:behind]] = behind - first >= FEWEST // 2
    return of_row[row]


def _session_s(problem: Problem) -> float:
    """Return how long a session usually takes [s], 0 of a single one."""
    sessions = np.unique(problem.session)
    if len(sessions) == 1:
        return 0.0
    spans = [
        float(np.ptp(part.time[own]))
        for part in problem.parts
        if part.time is not None
        for one in sessions
        if (own := problem.session[part.first] == one).any()
    ]
    return float(np.median(spans)) if spans else 0.0


@dataclass(frozen=True)
class Anew:
    """A choice made anew.

    Attributes
    ----------
    columns
        What is fitted, shape (m, P).
    curve
        What is predicted beside it [rad], shape (m,); None where all is fitted.
    """

    columns: Array
    curve: Array | None = None


@stage("choosing anew")
def columns_anew(problem: Problem, covariance: Covariance, chosen: Sequence[Chosen]) -> list[Anew]:
    """Return each choice as readings of full weight would choose it.

    Parameters
    ----------
    problem
        The case.
    covariance
        Its noise, with no weight on the readings that must not choose.
    chosen
        What was chosen from all readings.
    """
    return [
        _anew(problem, covariance, [each for each in chosen if each is not one], one)
        for one in chosen
    ]


def _anew(problem: Problem, covariance: Covariance, others: Sequence[Chosen], one: Chosen) -> Anew:
    effect = one.candidate.effect
    if effect.id == OSCILLATION:
        fresh = oscillations.again(problem, covariance, others, effect)
        if fresh.changes_with == "stretch":
            # Amplitudes that rest on few readings would be fitted to their noise.
            curve = wave_fits.predicted(problem, covariance, others, fresh)
            return Anew(np.zeros((len(curve), 0)), curve)
        columns = problem.stack.columns(fresh, problem.recordings.at)
        return Anew(columns[:, columns.any(axis=0)])
    if drive_waves.is_short(effect):
        fresh = drive_waves.again(problem, covariance, others, effect)
        return Anew(problem.stack.columns(fresh, problem.recordings.at))
    family = [each for each in problem.candidates if each.effect.id == effect.id]
    if len(family) < 2 or one.scope != "all":
        return Anew(problem.expanded([one]))
    if confounded(problem, effect):
        covariance = still_noise(problem, covariance)
    best = best_shown(problem, covariance, others, family)
    if any(each is one.candidate for each in family):
        return Anew(problem.expanded([Chosen(best, one.scope)]))
    wider, refined, *_ = refine(problem, covariance, others, Chosen(best, one.scope))
    return Anew(wider.expanded([refined]))
