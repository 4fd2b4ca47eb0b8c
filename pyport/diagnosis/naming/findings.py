"""From choices to findings: where each effect acts, how big it is, what it is called."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.arrays.findings import of_array, taken_apart
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.evidence import at_best
from pyport.diagnosis.joint import contribution, excess_of, largest_offset, visible
from pyport.diagnosis.naming import drives, words
from pyport.diagnosis.naming.drives import of_axis
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
from pyport.diagnosis.searching import turns
from pyport.diagnosis.searching.turns import Step
from pyport.diagnosis.shapes import drive_waves
from pyport.diagnosis.shapes.edges import curve_points
from pyport.diagnosis.shapes.fields import Ground
from pyport.diagnosis.shapes.oscillations import likeliest_period
from pyport.effects.empirical.fields import OSCILLATION
from pyport.effects.mounts import declared
from pyport.runs.stages import stage
from pyport.thresholds import CONVINCING, MOST_MEMBERS

#: So many times its period is what an oscillation may be an overtone of, and overtones of each.
MULTIPLES, OVERTONES = 5, 3


@stage("telling findings")
def collect(scene: Scene) -> list[Finding]:
    """Return the findings, strongest first."""
    found: list[Finding] = []
    first = len(scene.setup.base)
    for n, chosen in enumerate(scene.outcome.chosen):
        step = next(one for one in reversed(scene.outcome.steps) if one.chosen is chosen)
        earlier = scene.outcome.chosen[:n]
        parts = taken_apart(scene, first + n) if "antenna" in chosen.scope else None
        told = of_array(scene, first + n, step, earlier, parts) if parts else []
        # Where neither an antenna's own part nor the common one is significant: as it was fitted.
        told = told or [_single(scene, first + n, step)]
        told = honest(scene, first + n, step, told)
        found += [replace(one, choice=first + n) for one in told]
    return sorted(found, key=lambda one: -one.evidence.delta_bic)


def _partial(setup: Problem, curve: Array) -> bool:
    """Tell whether a curve (m,) acts on some of the readings of its axes only."""
    of_axes = [curve[setup.stack.is_y == is_y] != 0 for is_y in (False, True)]
    acting = np.concatenate([one for one in of_axes if one.any()] or of_axes)
    return not acting.all()


def _single(scene: Scene, choice: int, step: Step) -> Finding:
    """Return a finding whose coefficients stand as they were fitted."""
    setup, chosen = scene.setup, scene.joint.choices[choice]
    curve = contribution(setup, scene.joint, choice)
    seen = visible(setup, scene.weighed, curve)
    effect = chosen.candidate.effect
    of_time = effect.id == OSCILLATION
    of_drive = drive_waves.is_short(effect)
    parameters = (oscillation_parameters if of_time else parameters_of)(scene, choice)
    like = None
    if of_drive:
        parameters = drives.parameters(scene, choice, parameters)
        like = drives.alias(effect, drive_waves.way_of(setup, effect).step)
    called = turns.name(step.winner, step.trials, step.beside)
    checks = halves(setup, scene.weighed, scene.joint, choice)
    if of_time:
        checks.append(_own_period(scene, chosen))
    if of_drive:
        checks.append(drives.throughout(scene, chosen))
    checks += [
        known(p.value, p.sigma, p.expected, p.name) for p in parameters if p.expected is not None
    ]
    whole = scene.outcome.chosen
    others = tuple(one for one in whole if one is not chosen)
    heldout = held_out(scene, others, whole, np.ones(len(curve), bool))
    together = None if of_time else scene.combination(choice)
    mounts = declared(setup.recordings.meta)
    largest = largest_offset(setup)
    if together is not None:
        parameters = [one for one in parameters if not beyond(one, largest)]
    few = len(called.members) <= MOST_MEMBERS
    refuting = [one.words for one in checks if not one.passed]
    named = effect.physical and few and not refuting
    # A wave looks like another on a grid.
    one = len(called.members) == 1 and not called.others and not like
    verdict = ("named" if one else "ambiguous") if named else "unknown"
    where = Where(
        # Where other terms move to make room for it, it is not.
        axes(setup, np.where(curve != 0, seen, 0.0)),
        moved_antennas(scene, curve),
        chosen.candidate.region,
        curve=curve_points(chosen.candidate),
        since=words.since(effect),
    )
    return Finding(
        effect=effect.id if named else "unknown",
        members=called.members if named else ("unknown",),
        verdict=verdict,
        sentence=words.sentence(
            effect, parameters, where, together, mounts, setup.recordings.at.mount.names
        )
        if named
        else words.UNKNOWN,
        where=where,
        parameters=tuple(parameters),
        evidence=evidence_of(step, called),
        visible_rms=size(scene, seen, curve != 0),
        true_rms=size(scene, centred(scene, curve), curve != 0),
        largest=largest,
        combination=together,
        partial=_partial(setup, curve),
        variant=effect.variant,
        heldout=heldout,
        looks_like=None if named else words.looks_like(effect, called, refuting),
        decide_by=_decided(called, like) if named else words.WATCH,
        checks=tuple(one.words for one in checks),
        curve=seen,
    )


def _decided(called: turns.Name, like: str | None) -> str | None:
    """Return what distinguishes the names of a finding, and a wave from its like on a grid."""
    apart = turns.decide_by(called.members, called.others)
    return "; ".join(filter(None, (apart, like))) or None


def _own_period(scene: Scene, chosen: Chosen) -> Check:
    """Check that what is left, folded at the period of an oscillation, repeats no slower.

    Short pulses have overtones as strong as themselves, and one of them may be what was found.
    Beside the oscillation a free curve at a multiple of its period has then more evidence than one
    at the period itself.
    """
    setup, period_s = scene.setup, chosen.candidate.effect.member["period_s"]
    ground = Ground(setup, scene.weighed, scene.outcome.chosen)
    time_s = setup.recordings.at.numbers("time")[setup.stack.row]
    turns_of = 2 * np.pi * (time_s - time_s.min()) / period_s
    upward = setup.stack.is_y[:, None]
    found = []
    for times in range(1, MULTIPLES + 1):
        orders = [n for n in range(1, OVERTONES * times + 1) if n != times]
        angles = turns_of[:, None] * np.array(orders) / times
        waves = np.concatenate([np.sin(angles), np.cos(angles)], axis=1)
        information, _, moments = ground.products(
            np.concatenate([waves * upward, waves * ~upward], axis=1)
        )
        power, vectors = np.linalg.eigh(information)
        found.append(at_best(np.maximum(power, 0.0), vectors.T @ moments)[0])
    best = int(np.argmax(found))
    slower = found[best] - max(found[0], 0.0)
    slow = slower > CONVINCING
    how = f"every {best + 1} periods, evidence {slower:.0f}" if slow else "no slower"
    return Check(not slow, f"what it leaves repeats {how}")


def oscillation_parameters(scene: Scene, choice: int) -> list[Parameter]:
    """Return the period of an oscillation [min], its amplitudes, and phases where one holds.

    The amplitude of a wandering one is the root mean square of those of its stretches, less what
    their errors add. A phase of 0 has the sine begin at the moment that the variant names.
    """
    chosen, setup = scene.joint.choices[choice], scene.setup
    effect = chosen.candidate.effect
    others = [one for one in scene.outcome.chosen if one is not chosen]
    _, sigma, _ = likeliest_period(setup, scene.weighed.covariance, others, effect)
    found = [Parameter("period", effect.member["period_s"] / 60, sigma / 60, "min")]
    where = scene.joint.slice(choice)
    known = scene.joint.solution.known[where]
    value = scene.joint.solution.values[where][known]
    excess = excess_of(scene.joint, len(setup.residual))
    covariance = excess * scene.joint.solution.covariance[where, where][np.ix_(known, known)]
    names = [effect.coefficients[n].name for n in np.array(chosen.candidate.coefficients)[known]]
    for axis in ("xel", "el"):
        own = [n for n, name in enumerate(names) if name.partition("[")[0].endswith(f"_{axis}")]
        if own:
            found += of_axis(axis, value[own], covariance[np.ix_(own, own)], held=len(own) == 2)
    return found
