"""Findings of an array: what each antenna has, and what all antennas share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.joint import sigmas, visible
from pyport.diagnosis.naming import classes, words
from pyport.diagnosis.naming.finding import Evidence, Finding, Where
from pyport.diagnosis.naming.scene import (
    Scene,
    axes,
    centred,
    evidence_of,
    halves,
    held_out,
    noisy_antennas,
    scaled,
    size,
)
from pyport.diagnosis.searching.turns import Step
from pyport.thresholds import SEVERAL, SIGNIFICANT


@dataclass(frozen=True)
class CommonAndOwn:
    """A coefficient of many antennas, taken apart.

    Attributes
    ----------
    sessions, common, common_sigma
        The part that all antennas share, session by session, shape (S,).
    antennas, own, own_sigma
        Each antenna's own part, shape (A,), zero on average.
    spread
        Scatter of the own parts beyond their errors.
    chi_squared, dof
        Of the common part being the same in all sessions.
    """

    sessions: tuple[str, ...]
    common: Array
    common_sigma: Array
    antennas: tuple[str, ...]
    own: Array
    own_sigma: Array
    spread: float
    chi_squared: float
    dof: int

    @property
    def has_common(self) -> bool:
        """Tell whether any session's common part stands out of its error."""
        return bool(np.any(np.abs(self.common) > SIGNIFICANT * self.common_sigma))

    @property
    def changes(self) -> bool:
        """Tell whether the common part changes from session to session."""
        from scipy.stats import chi2

        return self.dof > 0 and bool(chi2.sf(self.chi_squared, self.dof) < 1e-3)


def split(
    antenna: NDArray[np.str_], session: NDArray[np.str_], value: Array, sigma: Array
) -> CommonAndOwn:
    """Take coefficients apart into a common part per session and an own part per antenna.

    Parameters
    ----------
    antenna, session
        Labels of each coefficient, shape (n,).
    value, sigma
        The coefficients and their errors, shape (n,); errors must be finite and above zero.

    Returns
    -------
    CommonAndOwn
        The own parts are random about zero with a scatter found from the data
        (DerSimonian & Laird 1986), so that one precise antenna does not define
        what is common to all.
    """
    antennas, a = np.unique(antenna, return_inverse=True)
    sessions, s = np.unique(session, return_inverse=True)
    spread = _spread(s, value, sigma)
    weight = 1 / (sigma**2 + spread**2)
    common = np.bincount(s, weight * value) / np.bincount(s, weight)
    for _ in range(200):
        left = np.bincount(a, (value - common[s]) / sigma**2) / np.bincount(a, 1 / sigma**2)
        left -= np.mean(left)
        updated = np.bincount(s, weight * (value - left[a])) / np.bincount(s, weight)
        if np.allclose(updated, common, rtol=0, atol=1e-6 * sigma.min()):
            break
        common = updated
    common_sigma = np.sqrt(
        1 / np.bincount(s, 1 / sigma**2) + spread**2 / np.maximum(np.bincount(s), 1)
    )
    own_sigma = np.sqrt(1 / np.bincount(a, 1 / sigma**2) + 1 / (1 / sigma**2).sum())
    # Sessions share the antennas, so the spread of own parts drops out of their differences.
    difference_sigma = np.sqrt(1 / np.bincount(s, 1 / sigma**2))
    mean = np.average(common, weights=1 / difference_sigma**2)
    chi_squared = float((((common - mean) / difference_sigma) ** 2).sum())
    return CommonAndOwn(
        tuple(map(str, sessions)),
        common,
        common_sigma,
        tuple(map(str, antennas)),
        left,
        own_sigma,
        spread,
        chi_squared,
        len(sessions) - 1,
    )


def _spread(s: NDArray[np.intp], value: Array, sigma: Array) -> float:
    """Return the scatter of antennas about their session's mean beyond their errors."""
    weight = 1 / sigma**2
    mean = np.bincount(s, weight * value) / np.bincount(s, weight)
    excess = float((weight * (value - mean[s]) ** 2).sum()) - (len(value) - s.max() - 1)
    total = weight.sum() - (np.bincount(s, weight**2) / np.bincount(s, weight)).sum()
    return float(np.sqrt(max(0.0, excess / max(total, 1e-300))))


#: Columns this parallel are one and the same.
PARALLEL = 0.999


def of_array(
    scene: Scene, choice: int, step: Step, earlier: Sequence[Chosen], parts: CommonAndOwn
) -> list[Finding]:
    """Return what each antenna has, and what all antennas share, as two findings.

    One session cannot tell an antenna's own part from its share of the common
    one: its first finding then gives the sum.
    """
    own = _own(scene, choice, step, earlier, parts)
    shared = _shared(scene, choice, step, earlier, parts) if parts.has_common else None
    return [one for one in (own, shared) if one is not None]


def _own(
    scene: Scene, choice: int, step: Step, earlier: Sequence[Chosen], parts: CommonAndOwn
) -> Finding | None:
    """Return the part of each antenna; None where no antenna stands out."""
    problem, chosen = scene.problem, scene.joint.choices[choice]
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
    rows = np.isin(problem.antenna, standing)
    of_antenna = dict(zip(parts.antennas, value, strict=True))
    column = problem.picked(chosen.candidate.columns[:1])[:, 0]
    curve = column * np.array([of_antenna.get(str(name), 0.0) for name in problem.antenna])
    seen = visible(problem, scene.weighed, curve)
    checks = halves(problem, scene.weighed, scene.joint, choice)
    return Finding(
        effect=effect.id,
        members=step.called.members,
        verdict="named" if len(step.called.members) == 1 else "ambiguous",
        sentence=words.own(effect, parameters, standing, len(parts.antennas)),
        where=Where(axes(problem, seen), {"antenna": standing}),
        parameters=tuple(parameters),
        evidence=evidence_of(step),
        visible_rms=size(scene, seen, rows),
        true_rms=size(scene, centred(scene, curve), rows),
        variant=effect.variant,
        heldout=held_out(scene, earlier, (*earlier, chosen), rows),
        decide_by=classes.decide_by(step.called.members),
        checks=tuple(one.words for one in checks),
        curve=seen,
    )


def _shared(
    scene: Scene, choice: int, step: Step, earlier: Sequence[Chosen], parts: CommonAndOwn
) -> Finding:
    """Return the part that all antennas share, under the name of what they would share it for."""
    problem, chosen = scene.problem, scene.joint.choices[choice]
    several = len(parts.sessions) > 1
    sessions = (
        problem.blocks.session[problem.block] if several else np.zeros(len(problem.block), int)
    )
    amount = parts.common[np.unique(sessions, return_inverse=True)[1]]
    curve = problem.picked(chosen.candidate.columns[:1])[:, 0] * amount
    seen = visible(problem, scene.weighed, curve)
    partner = _partner(scene, chosen.candidate)
    ratio = _ratio(problem, partner, chosen.candidate)
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
        where=Where(axes(problem, seen)),
        parameters=tuple(parameters),
        evidence=_gain_of(step, common),
        visible_rms=size(scene, seen, curve != 0),
        true_rms=size(scene, centred(scene, curve), curve != 0),
        heldout=held_out(scene, earlier, (*earlier, common), np.abs(curve) > 0),
        decide_by=classes.decide_by(members),
        curve=seen,
    )


def taken_apart(scene: Scene, choice: int) -> CommonAndOwn | None:
    """Take what each antenna has of its own apart; None where that makes no sense."""
    chosen, problem = scene.joint.choices[choice], scene.problem
    if len(chosen.candidate.columns) != 1:
        return None
    groups = problem.blocks.groups(chosen.scope)
    blocks = np.unique(groups, return_index=True)[1]
    where = scene.joint.slice(choice)
    sigma = sigmas(scene.joint)[where]
    noisy = noisy_antennas(problem, scene.floor)
    good = scene.joint.solution.known[where] & (sigma > 0)
    good &= ~np.isin(problem.blocks.antenna[blocks], noisy)
    if len(np.unique(problem.blocks.antenna[blocks][good])) < SEVERAL:
        return None
    session = problem.blocks.session[blocks]
    if "session" not in chosen.scope:
        session = np.full(len(blocks), "")
    return split(
        problem.blocks.antenna[blocks][good],
        session[good],
        scene.joint.solution.values[where][good],
        sigma[good],
    )


def _partner(scene: Scene, candidate: Candidate) -> Candidate:
    """Return the effect that all antennas would share and that draws the same curve, if any."""
    column = scene.problem.picked(candidate.columns[:1])[:, 0]
    for other in scene.problem.candidates:
        if other.effect.common == "antenna" or len(other.columns) != 1:
            continue
        rival = scene.problem.picked(other.columns[:1])[:, 0]
        product = abs(float(column @ rival))
        if product > PARALLEL * np.linalg.norm(column) * np.linalg.norm(rival):
            return other
    return candidate


def _ratio(problem: Problem, partner: Candidate, candidate: Candidate) -> float:
    """Return how many of the candidate's units one unit of the partner's coefficient is worth."""
    column = problem.picked(candidate.columns[:1])[:, 0]
    return float(problem.picked(partner.columns[:1])[:, 0] @ column / (column @ column))


def _gain_of(step: Step, chosen: Chosen) -> Evidence:
    """Return the evidence of a narrower choice, as it was tried in the same turn."""
    same = [
        trial
        for trial in step.trials
        if trial.candidate is chosen.candidate and trial.scope == chosen.scope
    ]
    whole = evidence_of(step)
    return replace(whole, delta_bic=same[0].delta_bic) if same else whole
