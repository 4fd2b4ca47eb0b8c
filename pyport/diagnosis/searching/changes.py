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
from itertools import pairwise

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.case import Chosen, Problem, confounded
from pyport.diagnosis.shapes import drive_waves, oscillations, wave_fits
from pyport.diagnosis.shapes.edges import edges_of
from pyport.diagnosis.trial import CandidateFit, at_best
from pyport.diagnosis.weighing import (
    View,
    WhitenedData,
    best_shown,
    left_beside,
    plain_view,
    shown_beside,
)
from pyport.effects import Effect, catalogue
from pyport.effects.empirical.epochs import epoch_step
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

    Of a single session nothing drifts.
    """
    session = _session_s(problem)
    noises = tuple(one.shown_within(session) for one in covariance.noises)
    return replace(covariance, noises=noises, departures=())


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


#: The best moment of each of so many stretches of time is weighed with the drift.
STRETCHES = 24


@stage("refining steps and edges")
def refine(
    problem: Problem, covariance: Covariance, chosen: Sequence[Chosen], plain: Chosen
) -> tuple[Problem, Chosen, float, float]:
    """Move the moment or edge of a choice to where it fits best, beside the rest of the model.

    Returns
    -------
    problem, chosen
        The case with the columns of the refined effect added, and the choice;
        both as they were where there is nothing to move.
    more
        By what factor the gain has grown.
    price
        What the further numbers of a moment or a curve must earn.
    """
    effect = plain.candidate.effect
    if plain.scope != "all":
        return problem, plain, 1.0, 0.0
    step = effect.is_change and effect.parameter is not None
    if not step and effect.edge is None:
        return problem, plain, 1.0, 0.0
    view = plain_view(problem, covariance, chosen)
    of_number = np.log(max(len(view.rows), 3))
    if step:
        tried = [(one, float(of_number)) for one in _moments(problem, view, effect)]
    else:
        tried = edges_of(problem, view, effect)
    # A drift pulls as a step does: what was found as if there were none is weighed with it.
    which = list(plain.candidate.coefficients)
    found = [problem.stack.columns(one, problem.recordings.at)[:, which] for one, _ in tried]
    old = problem.picked(plain.candidate.columns)
    before, *gains = _gains(problem, covariance, chosen, [old, *found])
    best = int(np.argmax([gain - price for gain, (_, price) in zip(gains, tried, strict=True)]))
    more = gains[best] / max(before, 1e-300)
    price = tried[best][1] - plain.candidate.price
    if more <= 1:
        return problem, plain, 1.0, 0.0
    return *problem.with_member(plain, tried[best][0]), more, max(float(price), 0.0)


def _gains(
    problem: Problem, covariance: Covariance, chosen: Sequence[Chosen], some: Sequence[Array]
) -> list[float]:
    """Return what each of some blocks of columns (m, k) gains beside the model."""
    _, left = left_beside(problem, covariance, chosen, np.concatenate(some, axis=1))
    gains = []
    for low, up in pairwise(np.cumsum([0, *(columns.shape[1] for columns in some)])):
        own = left[:, low:up]
        seen = own.T @ left[:, -1]
        gains.append(float(seen @ np.linalg.pinv(own.T @ own, hermitian=True) @ seen))
    return gains


def _moments(problem: Problem, view: View, effect: Effect) -> list[Effect]:
    """Return steps at the moments between two recordings that fit best, one in each stretch."""
    at = problem.recordings.at
    # With every row after the step its columns are those of the effect everywhere.
    whole = catalogue(at.mount)[effect.id]
    always = epoch_step(-1e15, whole, of_order=True)
    columns = problem.stack.columns(always, at)[view.rows] * view.root[:, None]
    time = clock(at)[problem.stack.row][view.rows]
    order = np.argsort(time, kind="stable")
    time, columns = time[order], columns[order]
    since = _from_the_end(columns[:, :, None] * columns[:, None, :])
    crossed = _from_the_end(view.basis[order][:, :, None] * columns[:, None, :])
    seen = _from_the_end(columns * view.left[order][:, None])
    information = since - crossed.transpose(0, 2, 1) @ crossed
    there = np.flatnonzero(np.diff(time, prepend=time[0]) > 0)
    there = there[(there >= FEWEST) & (there <= len(time) - FEWEST)]
    if len(there) == 0:
        return [effect]
    values = (np.linalg.pinv(information[there], hermitian=True) @ seen[there][:, :, None])[:, :, 0]
    gains = (values * seen[there]).sum(axis=1)
    stretches = np.array_split(np.arange(len(there)), min(STRETCHES, len(there)))
    best = [int(there[one[np.argmax(gains[one])]]) for one in stretches]
    of_order = effect.changes_with == "order"
    return [epoch_step(float(time[n - 1] + time[n]) / 2, whole, of_order=of_order) for n in best]


def past_outliers(
    problem: Problem, weighed: WhitenedData, one: Chosen
) -> tuple[Problem, list[Chosen]]:
    """Return a step moved to before and to behind the outliers next to it, and their case.

    A reading on the wrong side of a large step is an outlier, and no longer says where it belongs.
    """
    effect = one.candidate.effect
    if effect.parameter is None or not effect.is_change or one.scope != "all":
        return problem, []
    at, moved = problem.recordings.at, []
    time = clock(at)[problem.stack.row]
    moments = np.unique(time)
    sound = ~np.isin(moments, time[~weighed.used])
    now = int(np.searchsorted(moments, effect.parameter))
    before, behind = np.flatnonzero(sound[:now]) + 1, np.flatnonzero(sound[now:]) + now
    for n in {*before[-1:], *behind[:1]} - {now}:
        since, of_order = float(moments[n - 1] + moments[n]) / 2, effect.changes_with == "order"
        step = epoch_step(since, catalogue(at.mount)[effect.id], of_order=of_order)
        problem, other = problem.with_member(one, step)
        moved.append(other)
    return problem, moved


def _from_the_end(values: Array) -> Array:
    """Return sums from each row to the last."""
    return np.asarray(values[::-1].cumsum(axis=0)[::-1])


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
