"""From choices to findings: where each effect acts, how big it is, what it is called."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.diagnosis import check, holdout, identify, words
from pyport.diagnosis.array import ENOUGH_ANTENNAS, SIGNIFICANT, Split, split
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen, Setup, Weighed
from pyport.diagnosis.finding import Evidence, Finding, HeldOut, Parameter, Where
from pyport.diagnosis.joint import Joint, contribution, rms, sigmas, visible
from pyport.diagnosis.refine import curve_points
from pyport.diagnosis.search import Outcome, Step
from pyport.effects.base import Coefficient

#: An axis belongs to a finding when it shows this share of what the other axis shows.
AXIS_SHARE = 0.2
#: An antenna that scatters by this many times the array's median tells nothing.
WILD = 10.0
#: Columns this parallel are one and the same.
PARALLEL = 0.999


@dataclass(frozen=True)
class Scene:
    """What the findings are read from: the case, its last weighing and the joint fit.

    `counted` tells which readings count in an rms: no outliers, no wild antennas.
    `share` says how much: one, less where an antenna is noisier than is usual.
    """

    setup: Setup
    outcome: Outcome
    joint: Joint
    counted: NDArray[np.bool_]
    share: Array
    floor: Array
    seed: int

    @property
    def weighed(self) -> Weighed:
        """Return the last weighing."""
        return self.outcome.weighed


def scene(setup: Setup, outcome: Outcome, joint: Joint, seed: int) -> Scene:
    """Return the scene of a finished search."""
    floor = np.zeros(len(setup.residual))
    for part, noise in zip(setup.parts, outcome.weighed.noises, strict=True):
        floor[part.rows] = noise.floor
    quiet = np.isin(setup.blocks.antenna[setup.block], wild_antennas(setup, floor), invert=True)
    counted = outcome.weighed.used & quiet
    usual = np.median(floor[counted]) if counted.any() else 1.0
    share = np.where(counted, np.minimum(1.0, (usual / np.maximum(floor, 1e-300)) ** 2), 0.0)
    return Scene(setup, outcome, joint, counted, share, floor, seed)


def wild_antennas(setup: Setup, floor: Array) -> list[str]:
    """Name the antennas whose noise drowns whatever the others show."""
    antennas = setup.blocks.antenna[setup.block]
    names = np.unique(antennas)
    if len(names) < ENOUGH_ANTENNAS:
        return []
    own = np.array([np.median(floor[antennas == name]) for name in names])
    return [str(name) for name in names[own > WILD * np.median(own)]]


def collect(scene: Scene) -> list[Finding]:
    """Return the findings, strongest first."""
    found: list[Finding] = []
    first = len(scene.setup.base)
    for n, chosen in enumerate(scene.outcome.chosen):
        step = next(one for one in reversed(scene.outcome.steps) if one.chosen is chosen)
        earlier = scene.outcome.chosen[:n]
        parts = _split(scene, first + n)
        if parts is None:
            found.append(_single(scene, first + n, step, earlier))
        else:
            found += _of_array(scene, first + n, step, earlier, parts)
    return sorted(found, key=lambda one: -one.evidence.delta_bic)


def _single(scene: Scene, choice: int, step: Step, earlier: Sequence[Chosen]) -> Finding:
    """Return a finding whose coefficients stand as they were fitted."""
    setup, chosen = scene.setup, scene.joint.choices[choice]
    curve = contribution(setup, scene.joint, choice)
    seen = visible(setup, scene.weighed, curve)
    effect = chosen.candidate.effect
    parameters = _parameters(scene, choice)
    called = identify.name(step.winner, step.trials, step.beside)
    checks = check.halves(setup, scene.weighed, scene.joint, choice)
    checks += [
        check.known(p.value, p.sigma, p.expected, p.name)
        for p in parameters
        if p.expected is not None
    ]
    heldout = _heldout(scene, earlier, (*earlier, chosen), np.abs(curve) > 0)
    named = effect.physical and all(one.passed for one in checks)
    verdict = ("named" if len(called.members) == 1 else "ambiguous") if named else "unknown"
    where = Where(
        _axes(setup, seen),
        _subset(scene, curve),
        chosen.candidate.region,
        curve=curve_points(chosen.candidate),
        since=words.since(effect),
    )
    return Finding(
        effect=effect.id if named else "unknown",
        members=called.members if named else ("unknown",),
        verdict=verdict,
        sentence=words.sentence(effect, parameters, where) if named else words.UNKNOWN,
        where=where,
        parameters=tuple(parameters),
        evidence=_evidence(step, called),
        visible_rms=_size(scene, seen, curve != 0),
        true_rms=_size(scene, curve, curve != 0),
        variant=effect.variant,
        heldout=heldout,
        looks_like=None if named else words.looks_like(effect, called),
        decide_by=identify.decide_by(called.members) if named else words.WATCH,
        checks=tuple(one.words for one in checks),
        curve=seen,
    )


def _of_array(
    scene: Scene, choice: int, step: Step, earlier: Sequence[Chosen], parts: Split
) -> list[Finding]:
    """Return what each antenna has, and what all antennas share, as two findings.

    One session cannot tell an antenna's own part from its share of the common
    one: its first finding then gives the sum.
    """
    own = _own(scene, choice, step, earlier, parts)
    shared = _shared(scene, choice, step, earlier, parts) if parts.has_common else None
    return [one for one in (own, shared) if one is not None]


def _own(
    scene: Scene, choice: int, step: Step, earlier: Sequence[Chosen], parts: Split
) -> Finding | None:
    """Return the part of each antenna; None where no antenna stands out."""
    setup, chosen = scene.setup, scene.joint.choices[choice]
    effect = chosen.candidate.effect
    several = len(parts.sessions) > 1
    value = parts.own if several else parts.own + parts.common[0]
    out = np.abs(value) > SIGNIFICANT * parts.own_sigma
    standing = [name for name, there in zip(parts.antennas, out, strict=True) if there]
    if not standing:
        return None
    labels = [f"[{name}]" for name in parts.antennas]
    coefficient = effect.coefficients[chosen.candidate.coefficients[0]]
    parameters = _scaled(coefficient, labels, value, parts.own_sigma)
    antennas = setup.blocks.antenna[setup.block]
    rows = np.isin(antennas, standing)
    of_antenna = dict(zip(parts.antennas, value, strict=True))
    column = setup.columns[:, chosen.candidate.columns[0]]
    curve = column * np.array([of_antenna.get(str(name), 0.0) for name in antennas])
    seen = visible(setup, scene.weighed, curve)
    called = identify.name(step.winner, step.trials, step.beside)
    checks = check.halves(setup, scene.weighed, scene.joint, choice)
    return Finding(
        effect=effect.id,
        members=called.members,
        verdict="named" if len(called.members) == 1 else "ambiguous",
        sentence=words.own(effect, parameters, standing, len(parts.antennas)),
        where=Where(_axes(setup, seen), {"antenna": standing}),
        parameters=tuple(parameters),
        evidence=_evidence(step, called),
        visible_rms=_size(scene, seen, rows),
        true_rms=_size(scene, curve, rows),
        variant=effect.variant,
        heldout=_heldout(scene, earlier, (*earlier, chosen), rows),
        decide_by=identify.decide_by(called.members),
        checks=tuple(one.words for one in checks),
        curve=seen,
    )


def _shared(
    scene: Scene, choice: int, step: Step, earlier: Sequence[Chosen], parts: Split
) -> Finding:
    """Return the part that all antennas share, under the name of what they would share it for."""
    setup, chosen = scene.setup, scene.joint.choices[choice]
    several = len(parts.sessions) > 1
    sessions = setup.blocks.session[setup.block] if several else np.zeros(len(setup.block), int)
    amount = parts.common[np.unique(sessions, return_inverse=True)[1]]
    curve = setup.columns[:, chosen.candidate.columns[0]] * amount
    seen = visible(setup, scene.weighed, curve)
    partner = _partner(scene, chosen.candidate)
    ratio = _ratio(setup, partner, chosen.candidate)
    parameters = _scaled(
        partner.effect.coefficients[partner.coefficients[0]],
        [f"[{name}]" if name else "" for name in parts.sessions],
        parts.common / ratio,
        parts.common_sigma / abs(ratio),
    )
    members = tuple(dict.fromkeys([partner.effect.id, chosen.candidate.effect.id]))
    if parts.changes:
        members = members[:1]
    common = Chosen(chosen.candidate, "session" if several else "all")
    return Finding(
        effect=members[0],
        members=members,
        verdict="named" if len(members) == 1 else "ambiguous",
        sentence=words.common(partner.effect, parameters, several=several),
        where=Where(_axes(setup, seen)),
        parameters=tuple(parameters),
        evidence=_gain_of(step, common, identify.name(step.winner, step.trials, step.beside)),
        visible_rms=_size(scene, seen, curve != 0),
        true_rms=_size(scene, curve, curve != 0),
        heldout=_heldout(scene, earlier, (*earlier, common), np.abs(curve) > 0),
        decide_by=identify.decide_by(members),
        curve=seen,
    )


def _split(scene: Scene, choice: int) -> Split | None:
    """Take a choice with one coefficient per antenna apart; None where that makes no sense."""
    chosen, setup = scene.joint.choices[choice], scene.setup
    if "antenna" not in chosen.scope or len(chosen.candidate.columns) != 1:
        return None
    groups = setup.blocks.groups(chosen.scope)
    blocks = np.unique(groups, return_index=True)[1]
    where = scene.joint.slice(choice)
    sigma = sigmas(scene.joint, len(setup.residual))[where]
    wild = wild_antennas(setup, scene.floor)
    good = scene.joint.solution.known[where] & (sigma > 0)
    good &= ~np.isin(setup.blocks.antenna[blocks], wild)
    if len(np.unique(setup.blocks.antenna[blocks][good])) < ENOUGH_ANTENNAS:
        return None
    session = setup.blocks.session[blocks]
    if "session" not in chosen.scope:
        session = np.full(len(blocks), "")
    return split(
        setup.blocks.antenna[blocks][good],
        session[good],
        scene.joint.solution.values[where][good],
        sigma[good],
    )


def _partner(scene: Scene, candidate: Candidate) -> Candidate:
    """Return the effect that all antennas would share and that draws the same curve, if any."""
    column = scene.setup.columns[:, candidate.columns[0]]
    for other in scene.setup.candidates:
        if other.effect.common == "antenna" or len(other.columns) != 1:
            continue
        rival = scene.setup.columns[:, other.columns[0]]
        product = abs(float(column @ rival))
        if product > PARALLEL * np.linalg.norm(column) * np.linalg.norm(rival):
            return other
    return candidate


def _ratio(setup: Setup, partner: Candidate, candidate: Candidate) -> float:
    """Return how many of the candidate's units one unit of the partner's coefficient is worth."""
    column = setup.columns[:, candidate.columns[0]]
    return float(setup.columns[:, partner.columns[0]] @ column / (column @ column))


def _parameters(scene: Scene, choice: int) -> list[Parameter]:
    """Return a choice's coefficients, one for each group that shares them."""
    chosen = scene.joint.choices[choice]
    where = scene.joint.slice(choice)
    value = scene.joint.solution.values[where]
    sigma = sigmas(scene.joint, len(scene.setup.residual))[where]
    known = scene.joint.solution.known[where]
    names = scene.setup.blocks.names(chosen.scope)
    width = len(chosen.candidate.columns)
    found = []
    for group, name in enumerate(names):
        for n, which in enumerate(chosen.candidate.coefficients):
            at = group * width + n
            if known[at]:
                label = f"[{name}]" if name else ""
                coefficient = chosen.candidate.effect.coefficients[which]
                found += _scaled(coefficient, [label], value[at : at + 1], sigma[at : at + 1])
    return found


def _scaled(
    coefficient: Coefficient, labels: Sequence[str], values: Array, sigma: Array
) -> list[Parameter]:
    return [
        Parameter(
            coefficient.name + label,
            float(value / coefficient.scale),
            float(error / coefficient.scale),
            coefficient.unit,
            coefficient.expected,
        )
        for label, value, error in zip(labels, values, sigma, strict=True)
    ]


def _size(scene: Scene, curve: Array, rows: NDArray[np.bool_]) -> float:
    """Return the rms of a curve over some of the readings that count [rad]."""
    return rms(curve[rows], scene.share[rows])


def _axes(setup: Setup, seen: Array) -> tuple[str, ...]:
    """Name the axes in which a curve shows."""
    across, along = rms(seen[~setup.stack.is_y]), rms(seen[setup.stack.is_y])
    most = max(across, along)
    shown = (("xel", across), ("el", along))
    return tuple(name for name, size in shown if size > AXIS_SHARE * most)


def _subset(scene: Scene, curve: Array) -> dict[str, list[str]]:
    """Name the antennas that a curve moves, where it does not move all."""
    antennas = scene.setup.blocks.antenna[scene.setup.block]
    moved = np.unique(antennas[curve != 0])
    return {} if len(moved) == len(np.unique(antennas)) else {"antenna": [str(m) for m in moved]}


def _evidence(step: Step, called: identify.Name) -> Evidence:
    runner = called.runner_up
    return Evidence(
        step.p_value,
        step.winner.delta_bic,
        None if runner is None else runner.candidate.effect.id,
        None if runner is None else runner.delta_bic,
    )


def _gain_of(step: Step, chosen: Chosen, called: identify.Name) -> Evidence:
    """Return the evidence of a narrower choice, as it was tried in the same turn."""
    same = [
        trial
        for trial in step.trials
        if trial.candidate is chosen.candidate and trial.scope == chosen.scope
    ]
    whole = _evidence(step, called)
    if not same:
        return whole
    return Evidence(whole.p_value, same[0].delta_bic, whole.runner_up, whole.runner_up_delta_bic)


def _heldout(
    scene: Scene,
    before: Sequence[Chosen],
    after: Sequence[Chosen],
    rows: NDArray[np.bool_],
) -> HeldOut:
    """Compare predictions of unseen readings with and without an effect."""
    partition = holdout.folds(scene.setup, after, scene.seed)
    first = holdout.residuals(scene.setup, scene.weighed, before, partition)
    second = holdout.residuals(scene.setup, scene.weighed, after, partition)
    both = rows & scene.counted & np.isfinite(first) & np.isfinite(second)
    share = scene.share[both]
    return HeldOut(
        partition.scheme,
        rms(first[both], share),
        rms(second[both], share),
        rms(scene.floor[both], share),
    )
