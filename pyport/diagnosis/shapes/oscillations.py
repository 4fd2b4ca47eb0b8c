"""Oscillations in time: proposed beside noise that must not swallow them.

A drift that was estimated beside the model alone has taken most of a slow oscillation, for within
a few periods it can draw one. So the search looks beside the drift as it was estimated and beside
less of it, and charges each of them what it explains worse without an oscillation. A drift alone
loses hundreds by that; where there is an oscillation, it gains them back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.shapes.periods import peaks_of
from pyport.diagnosis.shapes.scans import Peak, Scan, scan_of, view_of
from pyport.diagnosis.shapes.wave_fits import (
    effect_of,
    is_wave,
    likeliest_direction,
    likeliest_period,
    likeliest_repeat,
    repeats,
    scan_again,
    wanders,
)
from pyport.effects.base import Effect
from pyport.noise.covariance import Covariance
from pyport.runs.stages import stage
from pyport.thresholds import CONVINCING

#: Shares of the drift's amplitude beside which a period is looked for.
SHARES_OF_DRIFT = (1.0, 0.7, 0.3)


@stage("looking for periods")
def proposed(
    problem: Problem, present: Covariance, chosen: Sequence[Chosen], above: float = -np.inf
) -> Chosen | None:
    """Return the oscillation that is worth a confirmation beside what is chosen, if any.

    Its columns are for `Problem.with_member` to add. `present` is the noise of the turn; nothing is
    proposed that is worth no more than `above`.
    """
    scans = [
        scan for one in _ways(problem) if (scan := scan_of(problem, reversing=one)) is not None
    ]
    if not scans or any(is_wave(one.candidate.effect) for one in chosen):
        return None
    noises = [_with_drift(present, share, scans[0].longest) for share in SHARES_OF_DRIFT]
    each = [[view_of(problem, scan, noise, chosen) for noise in noises] for scan in scans]
    least = min(view.lack for view in each[0])
    # What is more than a sine whose phase holds must be convincingly better: it nearly is one.
    found = [
        (peak.worth - view.lack + least - CONVINCING * (not peak.plain), peak, scan, noise)
        for scan, views in zip(scans, each, strict=True)
        for noise, view, peaks in zip(noises, views, peaks_of(scan, views), strict=True)
        for peak in peaks
    ]
    worth, best, scan, _ = max(found, key=lambda one: one[0])
    # Beside none it need not: it is confirmed.
    worth += CONVINCING * (not best.plain) - 2 * float(np.log(len(scans)))
    if worth <= max(CONVINCING, above) or not scan.shows(best):
        return None
    refined = []
    for kind in {peak.kind for _, peak, *_ in found}:
        own = [one for one in found if one[1].kind == kind]
        was, peak, scan, noise = max(own, key=lambda one: one[0])
        if scan.shows(peak):
            one, evidence = _refined(problem, scan, noise, chosen, peak, len(scans))
            refined.append((was + evidence - peak.evidence, one))
    return max(refined, key=lambda one: one[0])[1]


def _ways(problem: Problem) -> tuple[bool, ...]:
    """Return whether waves may change their sign with the side of the pier: not, or either way."""
    at = problem.recordings.at
    return (False, True) if at.mount.turns_over and len(np.unique(at.side)) > 1 else (False,)


def again(
    problem: Problem, covariance: Covariance, others: Sequence[Chosen], one: Effect
) -> Effect:
    """Return an oscillation of the same kind with the period that readings of weight prefer."""
    scan = scan_again(problem, one)
    view = view_of(problem, scan, covariance, others)
    peak = next(each for each in peaks_of(scan, [view])[0] if each.kind == (wanders(one), 1))
    first = effect_of(problem, scan, peak.period, peak.direction_deg)
    if peak.wanders:
        return first
    return effect_of(problem, scan, likeliest_period(problem, covariance, others, first)[0])


def _with_drift(present: Covariance, share: float, longest: float) -> Covariance:
    """Return a noise with a share of the amplitude of drifts that forget within a session.

    What remembers for longer, and departures, leave a shorter period alone.
    """
    noises = tuple(
        replace(
            one,
            drifts=tuple(
                (size * (share if memory <= longest else 1.0), memory)
                for size, memory in one.drifts
            ),
        )
        for one in present.noises
    )
    return replace(present, noises=noises)


def _refined(
    problem: Problem, scan: Scan, noise: Covariance, chosen: Sequence[Chosen], peak: Peak, ways: int
) -> tuple[Chosen, float]:
    """Return the oscillation at the best period near a peak, one of so many ways to sign it.

    And its evidence.
    """
    first = effect_of(problem, scan, peak.period, peak.direction_deg, harmonics=peak.harmonics)
    if repeats(first):
        effect, evidence = likeliest_repeat(problem, noise, chosen, first)
    else:
        period, _, evidence = likeliest_period(problem, noise, chosen, first)
        effect = effect_of(problem, scan, period, peak.direction_deg)
    if peak.wanders:
        direction, _, evidence = likeliest_direction(problem, noise, chosen, effect)
        effect = effect_of(problem, scan, period, direction)
    one = of_period(problem, effect, peak.choices * ways)
    return replace(one, candidate=replace(one.candidate, of_time=True)), evidence


def of_period(problem: Problem, effect: Effect, choices: float) -> Chosen:
    """Return a wave, one of so many periods, as a choice in the case that has its columns."""
    kept = np.flatnonzero(problem.stack.columns(effect, problem.recordings.at).any(axis=0))
    places = problem.size + np.arange(len(kept))
    return Chosen(Candidate(effect, places, tuple(kept.tolist()), max(1, round(choices))), "all")
