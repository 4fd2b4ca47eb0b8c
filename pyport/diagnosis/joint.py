"""The joint fit: the model and everything that was found, refitted together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc

from pyport.angles import Array, Codes
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.weighing import WhitenedData
from pyport.fitting.combinations import MOST_COEFFICIENTS, Combination, combinations
from pyport.fitting.soundness import largest_offset
from pyport.fitting.two_axes import as_unlikely
from pyport.least_squares.gram import Solution, inverted
from pyport.noise.coefficients import solve


@dataclass(frozen=True)
class Joint:
    """A fit of the base and of some choices.

    Attributes
    ----------
    choices
        What was fitted, the base first.
    solution
        Values and covariance; sigmas are widened when more is left than noise.
    starts
        Where each choice's coefficients begin.
    predicted
        What the fit predicts for each reading [rad], shape (m,).
    """

    choices: tuple[Chosen, ...]
    solution: Solution
    starts: Codes
    predicted: Array

    def slice(self, choice: int) -> slice:
        """Return where a choice's coefficients stand."""
        return slice(int(self.starts[choice]), int(self.starts[choice + 1]))


def fit(problem: Problem, weighed: WhitenedData, chosen: Sequence[Chosen]) -> Joint:
    """Fit the base and the chosen effects together."""
    choices = (*problem.base, *chosen)
    columns = problem.expanded(choices)
    known = problem.precision(choices)
    solution = solve(weighed.covariance, columns, problem.residual, known)
    starts = np.cumsum([0, *(problem.part(one).size for one in choices)])
    return Joint(choices, solution, starts, columns @ solution.values)


def sigmas(joint: Joint) -> Array:
    """Return one-sigma errors; more scatter than the fitted noise widens them."""
    variance = np.maximum(np.diag(joint.solution.covariance), 0) * excess_of(joint)
    return np.asarray(np.sqrt(variance), float)


def distance(joint: Joint, choice: int) -> float:
    """Return how far a choice's coefficients together are from zero [sigma].

    The deviation of a normal that is as unlikely; infinite where none of them is known.
    """
    where = joint.slice(choice)
    values = joint.solution.values[where]
    inverse, rank, _, _ = inverted(joint.solution.covariance[where, where])
    if rank == 0:
        return np.inf
    return as_unlikely(chdtrc(rank, float(values @ inverse @ values) / excess_of(joint)))


def excess_of(joint: Joint) -> float:
    """Return how many times the variance of the fitted noise is left."""
    return max(1.0, joint.solution.residual / max(1, len(joint.predicted) - joint.solution.rank))


def combined(problem: Problem, joint: Joint) -> tuple[Combination, ...]:
    """Return what a joint fit knows of coefficients that it does not know alone.

    What a search drew freely (fields, curves of no name) has coefficients that nobody reads.
    """
    kept: list[int] = []
    names, coefficients = [], []
    for n, chosen in enumerate(joint.choices):
        if n >= len(problem.base) and not chosen.candidate.effect.physical:
            continue
        width = len(chosen.candidate.columns)
        for group, label in enumerate(problem.blocks.names(chosen.scope)):
            for k, which in enumerate(chosen.candidate.coefficients):
                coefficient = chosen.candidate.effect.coefficients[which]
                kept.append(int(joint.starts[n]) + group * width + k)
                names.append(coefficient.name + (f"[{label}]" if label else ""))
                coefficients.append(coefficient)
    if not 1 < len(kept) <= MOST_COEFFICIENTS:
        return ()
    excess = excess_of(joint)
    found = combinations(
        names,
        coefficients,
        problem.expanded(joint.choices)[:, kept],
        joint.solution.values[kept],
        joint.solution.covariance[np.ix_(kept, kept)] * excess,
        largest_offset(problem.stack, problem.recordings.at),
    )
    return tuple(replace(one, places=tuple(kept[n] for n in one.places)) for one in found)


def contribution(problem: Problem, joint: Joint, choice: int) -> Array:
    """Return what one choice adds to each reading [rad], shape (m,)."""
    return problem.expanded([joint.choices[choice]]) @ joint.solution.values[joint.slice(choice)]


def without_found(problem: Problem, joint: Joint) -> Array:
    """Return the offsets less what was found beside the model [rad], shape (m,)."""
    found = range(len(problem.base), len(joint.choices))
    return problem.stack.value - sum(contribution(problem, joint, one) for one in found)


def visible(problem: Problem, weighed: WhitenedData, curve: Array) -> Array:
    """Return what is left of a curve (m,) after the base took its share."""
    base = problem.expanded(problem.base)
    if base.shape[1] == 0:
        return curve
    used = weighed.used
    return curve - base @ np.linalg.lstsq(base[used], curve[used], rcond=1e-9)[0]


def rms(values: Array, share: Array | None = None) -> float:
    """Return the root mean square, 0 of nothing; `share` says how much each value counts."""
    if share is None:
        share = np.ones(len(values))
    total = float(share.sum())
    return float(np.sqrt((share * values**2).sum() / total)) if total > 0 else 0.0
