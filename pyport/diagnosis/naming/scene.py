"""What findings are read from, and their numbers: size, axes, evidence, held-out gain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.disagreements import cuts
from pyport.diagnosis.folds import folds
from pyport.diagnosis.holdout import unseen
from pyport.diagnosis.joint import Joint, combined, contribution, rms, sigmas, without_found
from pyport.diagnosis.naming.classes import agrees
from pyport.diagnosis.naming.finding import Evidence, HeldOut, Parameter
from pyport.diagnosis.searching.turns import Outcome, Step
from pyport.diagnosis.weighing import WhitenedData
from pyport.effects.base import Coefficient
from pyport.fitting.combinations import Combination
from pyport.fitting.soundness import neglected
from pyport.least_squares.gram import Gram, Part
from pyport.thresholds import AXIS_SHARE, GROSS, REFUTES, SAME_STRENGTH


@dataclass(frozen=True)
class Scene:
    """What the findings are read from: the case, its last weighing and the joint fit.

    `share` says how much each reading counts in an rms: one, none for outliers and noisy antennas,
    less where an antenna is noisier than is usual.
    """

    problem: Problem
    outcome: Outcome
    joint: Joint
    share: Array
    floor: Array

    @property
    def weighed(self) -> WhitenedData:
        """Return the last weighing."""
        return self.outcome.weighed

    @cached_property
    def combinations(self) -> tuple[Combination, ...]:
        """Return what the joint fit knows of coefficients that it does not know alone."""
        return combined(self.problem, self.joint)

    @cached_property
    def neglected(self) -> float:
        """Return what the model's terms, which only add up, lose of offsets, rms [rad]."""
        problem, value = self.problem, without_found(self.problem, self.joint)
        left = rms(problem.residual - self.joint.predicted, self.share)
        return neglected(problem.stack, problem.recordings.at, value, self.weighed.used, left)

    def combination(self, choice: int) -> Combination | None:
        """Return the combination that a choice's coefficients are known in, None if alone."""
        where = self.joint.slice(choice)
        own = range(where.start, where.stop)
        return next((c for c in self.combinations if any(n in own for n in c.places)), None)


def scene(problem: Problem, outcome: Outcome, joint: Joint) -> Scene:
    """Return the scene of a finished search."""
    floor = outcome.weighed.covariance.scatter
    quiet = np.isin(problem.antenna, noisy_antennas(problem, floor), invert=True)
    counted = outcome.weighed.used & quiet
    # Plain within an antenna: only one that is noisier than usual counts less in an array's rms.
    antenna = problem.blocks.groups("antenna")[problem.block]
    own = np.array([np.median(floor[antenna == n]) for n in range(antenna.max(initial=-1) + 1)])
    usual = np.median(floor[counted]) if counted.any() else 1.0
    if len(own) > 1:
        share = np.minimum(1.0, (usual / np.maximum(own, 1e-300)) ** 2)[antenna]
    else:
        share = np.ones(len(floor))
    share = np.where(counted, share, 0.0)
    return Scene(problem, outcome, joint, share, floor)


def noisy_antennas(problem: Problem, floor: Array) -> list[str]:
    """Name the antennas whose noise drowns whatever the others show."""
    names = np.unique(problem.antenna)
    own = np.array([np.median(floor[problem.antenna == name]) for name in names])
    return [str(name) for name in names[own > GROSS * np.median(own)]]


def parameters_of(scene: Scene, choice: int) -> list[Parameter]:
    """Return a choice's coefficients, one for each group that shares them."""
    chosen = scene.joint.choices[choice]
    where = scene.joint.slice(choice)
    value = scene.joint.solution.values[where]
    sigma = np.hypot(sigmas(scene.joint)[where], chosen.spread)
    known = scene.joint.solution.known[where]
    names = scene.problem.blocks.names(chosen.scope)
    width = len(chosen.candidate.columns)
    found = []
    for group, name in enumerate(names):
        for n, which in enumerate(chosen.candidate.coefficients):
            at = group * width + n
            if known[at]:
                label = f"[{name}]" if name else ""
                coefficient = chosen.candidate.effect.coefficients[which]
                found += scaled(coefficient, [label], value[at : at + 1], sigma[at : at + 1])
    return found


def scaled(
    coefficient: Coefficient, labels: Sequence[str], values: Array, sigma: Array
) -> list[Parameter]:
    """Return values in the unit that a coefficient is reported in, one for each label."""
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


def size(scene: Scene, curve: Array, rows: NDArray[np.bool_]) -> float:
    """Return the rms of a curve over some of the readings that count [rad]."""
    return rms(curve[rows], scene.share[rows])


def centred(scene: Scene, curve: Array) -> Array:
    """Return a curve (m,) less its mean in each axis of each antenna: a zero would take that."""
    problem, out = scene.problem, curve.copy()
    count = np.bincount(problem.series, scene.share)
    total = np.bincount(problem.series, scene.share * curve)
    out -= np.divide(total, count, out=np.zeros_like(total), where=count > 0)[problem.series]
    return out


def axes(problem: Problem, seen: Array) -> tuple[str, ...]:
    """Name the axes in which a curve shows."""
    across, along = rms(seen[~problem.stack.is_y]), rms(seen[problem.stack.is_y])
    most = max(across, along)
    shown = (("xel", across), ("el", along))
    return tuple(name for name, size in shown if size > AXIS_SHARE * most)


def moved_antennas(scene: Scene, curve: Array) -> dict[str, list[str]]:
    """Name the antennas that a curve moves, where it does not move all."""
    antennas = scene.problem.antenna
    moved = np.unique(antennas[curve != 0])
    return {} if len(moved) == len(np.unique(antennas)) else {"antenna": [str(m) for m in moved]}


def evidence_of(step: Step) -> Evidence:
    """Return the evidence of a turn, with the best effect outside the class."""
    runner = step.called.runner_up
    return Evidence(
        step.p_value,
        step.winner.delta_bic,
        None if runner is None else runner.candidate.effect.id,
        None if runner is None else runner.delta_bic,
    )


def held_out(
    scene: Scene, before: Sequence[Chosen], after: Sequence[Chosen], rows: NDArray[np.bool_]
) -> HeldOut:
    """Compare predictions of unseen readings with and without an effect."""
    problem, weighed = scene.problem, scene.weighed
    new = [one for one in after if not any(one is old for old in before)]
    partition = folds(problem, weighed, new)
    found = unseen(problem, (weighed, weighed), tuple(before), tuple(after), partition)
    return found.compared(rows, weighed.covariance.floor)


@dataclass(frozen=True)
class Check:
    """A check, whether it was passed, and its outcome in words."""

    passed: bool
    words: str


def halves(problem: Problem, weighed: WhitenedData, joint: Joint, choice: int) -> list[Check]:
    """Compare an effect's strength in halves of the data, and in the session that differs most."""
    split, sessions = _halves(problem), _sessions(problem)
    found = _strengths(problem, weighed, joint, choice, split | sessions)
    apart = sorted(sessions.keys() & found, key=lambda one: (-found[one].sigmas, one))
    shown = [*(one for one in split if one in found), *apart[:1]]
    return [_compared(label, found[label]) for label in shown]


@dataclass(frozen=True)
class Strength:
    """By what share of the rest's strength a part's exceeds it, and its sigma."""

    extra: float
    sigma: float

    @property
    def sigmas(self) -> float:
        """Return how far from none that is."""
        return abs(self.extra) / self.sigma


def _strengths(
    problem: Problem,
    weighed: WhitenedData,
    joint: Joint,
    choice: int,
    masks: dict[str, NDArray[np.bool_]],
) -> dict[str, Strength]:
    """Return an effect's strength in parts of the data, everything else refitted.

    The fitted curve of the effect gets a second coefficient that acts in one part only, and is
    divided by that of the rest; of the same strength, it is zero.
    """
    curve = contribution(problem, joint, choice)
    parts = {one: curve * mask for one, mask in masks.items() if curve[mask].any()}
    parts = {one: part for one, part in parts.items() if (part != curve).any()}
    others = problem.expanded([c for n, c in enumerate(joint.choices) if n != choice])
    columns = [others, np.stack([curve, *parts.values(), problem.residual], axis=1)]
    white = weighed.covariance.whiten(np.concatenate(columns, axis=1))
    gram = Gram.of(white, np.zeros(len(white), np.intp), 1)
    base = np.arange(others.shape[1] + 1)
    found = {}
    for n, label in enumerate(parts, start=len(base)):
        solution = gram.solve([Part(np.append(base, n), np.zeros(1, np.intp))])
        if solution.known[-2:].all():
            rest, more = solution.values[-2:].tolist()
            own, sigma = np.sqrt(np.diag(solution.covariance)[-2:]).tolist()
            # The rest may have nothing of it: then its error is what the part is compared with.
            rest = math.copysign(max(abs(rest), own), rest)
            found[label] = Strength(more / rest, sigma / abs(rest))
    return found


def _compared(label: str, found: Strength) -> Check:
    differs = found.sigmas > REFUTES and abs(found.extra) > SAME_STRENGTH
    words = f"strength in {label}: {1 + found.extra:+.2f} +- {found.sigma:.2f} of the rest's"
    return Check(not differs, words)


def _sessions(problem: Problem) -> dict[str, NDArray[np.bool_]]:
    """Return the readings of each session."""
    session, names = problem.session, problem.session_names
    return {f"session {names[session == one][0]}": session == one for one in np.unique(session)}


def _halves(problem: Problem) -> dict[str, NDArray[np.bool_]]:
    """Return the halves that the readings can be split into."""
    first = {by: rows for by, (_, rows) in cuts(problem).items()}
    found = {
        "the upper half in elevation": ~first["elevation"],
        "the eastern half of the sky": first["azimuth"],
    }
    if "time" in first:
        found["the later half"] = ~first["time"]
    if problem.stack.is_y.any() and not problem.stack.is_y.all():
        found[f"{problem.recordings.at.mount.names[1]} offsets"] = problem.stack.is_y
    return found


def known(value: float, sigma: float, expected: float, what: str) -> Check:
    """Compare a coefficient with the value that physics fixes."""
    words = f"{what} = {value:.4g} +- {sigma:.2g}, physics says {expected:.4g}"
    return Check(agrees(value, sigma, expected), words)
