"""From choices to findings: where each effect acts, how big it is, what it is called."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pyport.diagnosis import array_findings, identify, oscillating, words
from pyport.diagnosis.array_findings import of_array, taken_apart
from pyport.diagnosis.edges import curve_points
from pyport.diagnosis.finding import Finding, Where, beyond
from pyport.diagnosis.joint import contribution, largest_offset, visible
from pyport.diagnosis.scene import (
    Scene,
    axes,
    centred,
    evidence_of,
    held_out,
    moved_antennas,
    parameters_of,
    size,
)
from pyport.diagnosis.steps import Step
from pyport.diagnosis.verdict import honest
from pyport.effects.mounts import declared
from pyport.effects.oscillation import OSCILLATION
from pyport.stages import stage
from pyport.thresholds import MOST_MEMBERS


@stage("telling findings")
def collect(scene: Scene) -> list[Finding]:
    """Return the findings, strongest first."""
    found: list[Finding] = []
    first = len(scene.setup.base)
    for n, chosen in enumerate(scene.outcome.chosen):
        step = next(one for one in reversed(scene.outcome.steps) if one.chosen is chosen)
        earlier = scene.outcome.chosen[:n]
        parts = taken_apart(scene, first + n)
        if parts is None:
            told = [_single(scene, first + n, step)]
        else:
            told = of_array(scene, first + n, step, earlier, parts)
        told = honest(scene, first + n, step, told)
        found += [replace(one, choice=first + n) for one in told]
    return sorted(found, key=lambda one: -one.evidence.delta_bic)


def _single(scene: Scene, choice: int, step: Step) -> Finding:
    """Return a finding whose coefficients stand as they were fitted."""
    setup, chosen = scene.setup, scene.joint.choices[choice]
    curve = contribution(setup, scene.joint, choice)
    seen = visible(setup, scene.weighed, curve)
    effect = chosen.candidate.effect
    of_time = effect.id == OSCILLATION
    parameters = (oscillating.parameters if of_time else parameters_of)(scene, choice)
    called = identify.name(step.winner, step.trials, step.beside)
    checks = array_findings.halves(setup, scene.weighed, scene.joint, choice)
    checks += [
        array_findings.known(p.value, p.sigma, p.expected, p.name)
        for p in parameters
        if p.expected is not None
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
    named = effect.physical and few and all(one.passed for one in checks)
    one = len(called.members) == 1 and not called.others
    verdict = ("named" if one else "ambiguous") if named else "unknown"
    where = Where(
        axes(setup, seen),
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
        variant=effect.variant,
        heldout=heldout,
        looks_like=None if named else words.looks_like(effect, called),
        decide_by=identify.decide_by(called.members, called.others) if named else words.WATCH,
        checks=tuple(one.words for one in checks),
        curve=seen,
    )
