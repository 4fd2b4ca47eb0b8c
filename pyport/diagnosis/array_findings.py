"""Findings of an array: what each antenna has, and what all antennas share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.diagnosis import identify, words
from pyport.diagnosis.array import Split, split
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen, Problem, WhitenedData
from pyport.diagnosis.finding import Evidence, Finding, Where
from pyport.diagnosis.identify import agrees
from pyport.diagnosis.joint import Joint, contribution, sigmas, visible
from pyport.diagnosis.scene import (
    Scene,
    axes,
    centred,
    evidence_of,
    held_out,
    noisy_antennas,
    scaled,
    size,
)
from pyport.diagnosis.steps import Step
from pyport.least_squares.gram import Gram
from pyport.thresholds import REFUTES, SAME_STRENGTH, SEVERAL, SIGNIFICANT


@dataclass(frozen=True)
class Check:
    """A check, whether it was passed, and its outcome in words."""

    passed: bool
    words: str


def halves(setup: Problem, weighed: WhitenedData, joint: Joint, choice: int) -> list[Check]:
    """Compare an effect's strength in halves of the data, with everything else refitted.

    The fitted curve of the effect gets a second coefficient that acts in one
    half only; one means the same strength, so the second must come out zero.
    """
    curve = contribution(setup, joint, choice)
    found = []
    for label, mask in _halves(setup).items():
        if np.abs(curve[mask]).max(initial=0) == 0 or np.abs(curve[~mask]).max(initial=0) == 0:
            continue
        others = setup.expanded([c for n, c in enumerate(joint.choices) if n != choice])
        columns = np.concatenate(
            [others, curve[:, None], (curve * mask)[:, None], setup.residual[:, None]], axis=1
        )
        white = weighed.covariance.whiten(columns)
        found.append(_compare(white, label))
    return [check for check in found if check is not None]


def _compare(white: Array, label: str) -> Check | None:
    from pyport.least_squares.gram import Part

    gram = Gram.of(white, np.zeros(len(white), np.intp), 1)
    size = white.shape[1] - 1
    solution = gram.solve([Part(np.arange(size), np.zeros(1, np.intp))])
    if not solution.known[-2:].all():
        return None
    extra, sigma = solution.values[-1], float(np.sqrt(solution.covariance[-1, -1]))
    differs = abs(extra) > REFUTES * sigma and abs(extra) > SAME_STRENGTH
    words = f"strength in {label}: {1 + extra:+.2f} +- {sigma:.2f} of the rest's"
    return Check(not differs, words)


def _halves(setup: Problem) -> dict[str, NDArray[np.bool_]]:
    """Return the halves that the readings can be split into."""
    at, row = setup.recordings.at, setup.stack.row
    found = {
        "the upper half in elevation": (at.el > np.median(at.el))[row],
        "the eastern half of the sky": (np.sin(at.az) > 0)[row],
    }
    if "time" in at:
        time = np.asarray(at.column("time"), float)
        if np.isfinite(time).all() and np.ptp(time) > 0:
            found["the later half"] = (time > np.median(time))[row]
    if setup.stack.is_y.any() and not setup.stack.is_y.all():
        found["elevation"] = setup.stack.is_y
    return found


def known(value: float, sigma: float, expected: float, what: str) -> Check:
    """Compare a coefficient with the value that physics fixes."""
    words = f"{what} = {value:.4g} +- {sigma:.2g}, physics says {expected:.4g}"
    return Check(agrees(value, sigma, expected), words)


#: Columns this parallel are one and the same.
PARALLEL = 0.999


def of_array(
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
    parameters = scaled(coefficient, labels, value, parts.own_sigma)
    antennas = setup.blocks.antenna[setup.block]
    rows = np.isin(antennas, standing)
    of_antenna = dict(zip(parts.antennas, value, strict=True))
    column = setup.columns[:, chosen.candidate.columns[0]]
    curve = column * np.array([of_antenna.get(str(name), 0.0) for name in antennas])
    seen = visible(setup, scene.weighed, curve)
    called = identify.name(step.winner, step.trials, step.beside)
    checks = halves(setup, scene.weighed, scene.joint, choice)
    return Finding(
        effect=effect.id,
        members=called.members,
        verdict="named" if len(called.members) == 1 else "ambiguous",
        sentence=words.own(effect, parameters, standing, len(parts.antennas)),
        where=Where(axes(setup, seen), {"antenna": standing}),
        parameters=tuple(parameters),
        evidence=evidence_of(step, called),
        visible_rms=size(scene, seen, rows),
        true_rms=size(scene, centred(scene, curve), rows),
        variant=effect.variant,
        heldout=held_out(scene, earlier, (*earlier, chosen), rows),
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
    parameters = scaled(
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
        where=Where(axes(setup, seen)),
        parameters=tuple(parameters),
        evidence=_gain_of(step, common, identify.name(step.winner, step.trials, step.beside)),
        visible_rms=size(scene, seen, curve != 0),
        true_rms=size(scene, centred(scene, curve), curve != 0),
        heldout=held_out(scene, earlier, (*earlier, common), np.abs(curve) > 0),
        decide_by=identify.decide_by(members),
        curve=seen,
    )


def taken_apart(scene: Scene, choice: int) -> Split | None:
    """Take a choice with one coefficient per antenna apart; None where that makes no sense."""
    chosen, setup = scene.joint.choices[choice], scene.setup
    if "antenna" not in chosen.scope or len(chosen.candidate.columns) != 1:
        return None
    groups = setup.blocks.groups(chosen.scope)
    blocks = np.unique(groups, return_index=True)[1]
    where = scene.joint.slice(choice)
    sigma = sigmas(scene.joint, len(setup.residual))[where]
    noisy = noisy_antennas(setup, scene.floor)
    good = scene.joint.solution.known[where] & (sigma > 0)
    good &= ~np.isin(setup.blocks.antenna[blocks], noisy)
    if len(np.unique(setup.blocks.antenna[blocks][good])) < SEVERAL:
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


def _ratio(setup: Problem, partner: Candidate, candidate: Candidate) -> float:
    """Return how many of the candidate's units one unit of the partner's coefficient is worth."""
    column = setup.columns[:, candidate.columns[0]]
    return float(setup.columns[:, partner.columns[0]] @ column / (column @ column))


def _gain_of(step: Step, chosen: Chosen, called: identify.Name) -> Evidence:
    """Return the evidence of a narrower choice, as it was tried in the same turn."""
    same = [
        trial
        for trial in step.trials
        if trial.candidate is chosen.candidate and trial.scope == chosen.scope
    ]
    whole = evidence_of(step, called)
    if not same:
        return whole
    return Evidence(whole.p_value, same[0].delta_bic, whole.runner_up, whole.runner_up_delta_bic)
