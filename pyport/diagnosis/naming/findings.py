"""From choices to findings: where each effect acts, how big it is, what it is called."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.arrays.findings import of_array, taken_apart
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.joint import contribution, visible
from pyport.diagnosis.naming import classes, waves, words
from pyport.diagnosis.naming.finding import Finding, Parameter, Where, beyond
from pyport.diagnosis.naming.scene import (
    Check,
    Scene,
    axes,
    centred,
    evidence_of,
    halves,
    held_out,
    known,
    moved_antennas,
    parameters_of,
    size,
)
from pyport.diagnosis.naming.verdict import honest
from pyport.diagnosis.searching.refining import began_between
from pyport.diagnosis.searching.turns import Step
from pyport.diagnosis.shapes import drive_waves
from pyport.diagnosis.shapes.edges import curve_points
from pyport.effects.circumstances import utc
from pyport.effects.empirical.oscillations import OSCILLATION
from pyport.effects.mounts import declared
from pyport.fitting.soundness import largest_offset
from pyport.runs.stages import stage
from pyport.thresholds import MOST_MEMBERS


@stage("telling findings")
def collect(scene: Scene) -> list[Finding]:
    """Return the findings, strongest first."""
    found: list[Finding] = []
    bend_of = cache(partial(waves.bend, scene))
    first = len(scene.problem.base)
    for n, chosen in enumerate(scene.outcome.chosen):
        step = scene.outcome.step_of(chosen)
        earlier = scene.outcome.chosen[:n]
        parts = taken_apart(scene, first + n) if "antenna" in chosen.scope else None
        own = of_array(scene, first + n, step, earlier, parts) if parts else []
        # Where neither an antenna's own part nor the common one is significant: as it was fitted.
        own = own or [_single(scene, first + n, step, bend_of)]
        own = honest(scene, first + n, step, own)
        found += [replace(one, choice=first + n) for one in own]
    return sorted(found, key=lambda one: -one.evidence.delta_bic)


def _partial(problem: Problem, curve: Array) -> bool:
    """Tell whether a curve (m,) acts on some of the readings of its axes only."""
    of_axes = [curve[problem.stack.is_y == is_y] != 0 for is_y in (False, True)]
    acting = np.concatenate([one for one in of_axes if one.any()] or of_axes)
    return not acting.all()


def _parameters(scene: Scene, choice: int) -> list[Parameter]:
    """Return the coefficients of a choice, of a wave its period, amplitude and phase."""
    effect = scene.joint.choices[choice].candidate.effect
    if effect.id == OSCILLATION:
        return waves.of_oscillation(scene, choice)
    plain = parameters_of(scene, choice)
    return waves.of_drive(scene, choice, plain) if drive_waves.is_short(effect) else plain


def _checks(
    scene: Scene,
    choice: int,
    parameters: Sequence[Parameter],
    bend_of: Callable[[str], tuple[Check, str | None]],
) -> tuple[list[Check], str | None]:
    """Return what is checked of a choice, and what would distinguish a wave from its like.

    A wave looks like another on a grid, or like a bend.
    """
    problem, chosen = scene.problem, scene.joint.choices[choice]
    effect = chosen.candidate.effect
    like = effect.wants or None
    checks = halves(problem, scene.weighed, scene.joint, choice)
    if effect.id == OSCILLATION:
        checks.append(waves.own_period(scene, chosen))
        checks.append(waves.of_a_day(scene, effect, parameters[0]))
    if drive_waves.is_short(effect):
        like = waves.alias(effect, drive_waves.way_of(problem, effect))
        checks.append(waves.throughout(scene, chosen))
    elif waves.may_be_a_bend(effect):
        unbent, like = bend_of(effect.id)
        checks.append(unbent)
    if "k" in effect.member:
        checks.append(waves.everywhere(scene, chosen))
    checks += [
        known(p.value, p.sigma, p.expected, p.name) for p in parameters if p.expected is not None
    ]
    return checks, like


def _between(scene: Scene, chosen: Chosen) -> tuple[str, str]:
    """Return between which times of recordings a step began."""
    covariance, others = scene.weighed.covariance, scene.outcome.others(chosen)
    first, last = began_between(scene.problem, covariance, others, chosen)
    return utc(first), utc(last)


def _single(
    scene: Scene, choice: int, step: Step, bend_of: Callable[[str], tuple[Check, str | None]]
) -> Finding:
    """Return a finding whose coefficients stand as they were fitted.

    `bend_of` is `waves.bend`, asked once for each kind of effect.
    """
    problem, chosen = scene.problem, scene.joint.choices[choice]
    curve = contribution(problem, scene.joint, choice)
    seen = visible(problem, scene.weighed, curve)
    effect, called = chosen.candidate.effect, step.called
    parameters = _parameters(scene, choice)
    checks, like = _checks(scene, choice, parameters, bend_of)
    whole = scene.outcome.chosen
    heldout = held_out(scene, scene.outcome.others(chosen), whole, np.ones(len(curve), bool))
    together = None if effect.id == OSCILLATION else scene.combination(choice)
    mounts = declared(problem.recordings.meta)
    largest = largest_offset(problem.stack, problem.recordings.at)
    if together is not None:
        parameters = [one for one in parameters if not beyond(one, largest)]
    few = len(called.members) <= MOST_MEMBERS
    refuting = [one.words for one in checks if not one.passed]
    named = effect.physical and few and not refuting
    one = len(called.members) == 1 and not called.others and not like
    verdict = ("named" if one else "ambiguous") if named else "unknown"
    since, until = words.moments(effect)
    where = Where(
        # Where other terms move to make room for it, it is not.
        axes(problem, np.where(curve != 0, seen, 0.0)),
        moved_antennas(scene, curve),
        chosen.candidate.region,
        curve=curve_points(problem, effect),
        since=since,
        until=until,
        between=_between(scene, chosen) if since and chosen.scope == "all" else None,
    )
    return Finding(
        effect=effect.id if named else "unknown",
        members=called.members if named else ("unknown",),
        verdict=verdict,
        sentence=words.sentence(
            effect, parameters, where, together, mounts, problem.recordings.at.mount.names
        )
        if named
        else words.nameless(effect, called, few=few),
        where=where,
        parameters=tuple(parameters),
        evidence=evidence_of(step),
        visible_rms=size(scene, seen, curve != 0),
        true_rms=size(scene, centred(scene, curve), curve != 0),
        largest=largest,
        combination=together,
        partial=_partial(problem, curve),
        variant=effect.variant,
        heldout=heldout,
        looks_like=None if named else words.looks_like(effect, called, refuting, step.winner.gain),
        decide_by=_decided(called, like) if named else words.watch(effect),
        checks=tuple(one.words for one in checks),
        curve=seen,
    )


def _decided(called: classes.Name, like: str | None) -> str | None:
    """Return what distinguishes the names of a finding, and a wave from its like on a grid."""
    apart = classes.decide_by(called.members, called.others)
    orders = ", ".join(f"{order:.5g}" for order in called.orders)
    wider = f"it could be k = {orders} as well: observe a wider range of directions"
    return "; ".join(filter(None, (apart, like, orders and wider))) or None
