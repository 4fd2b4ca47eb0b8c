"""Disagreements of the axes: effects whose coefficients come out different from each alone.

A tilt of the mount, or a turn of the sky, moves cross-elevation and elevation in a
fixed ratio. Where the axes, each by itself, ask for different ones, no value of the
coefficients fits both: something acts on one axis alone and passes for the effect.
Fields without a name are left out of the model here, for they would draw just that.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.weighing import WhitenedData, weigh
from pyport.effects.circumstances import utc
from pyport.fitting.two_axes import UNLIKELY, Difference, difference
from pyport.least_squares.gram import spanned
from pyport.runs.stages import stage
from pyport.thresholds import MOSTLY, SIGNIFICANT

Mask = NDArray[np.bool_]
#: So many causes are named that would take most of the disagreement away.
MOST_CAUSES = 3


@dataclass(frozen=True)
class Half:
    """Half of the recordings, its name in words, and what both axes say there."""

    name: str
    axes: Difference | None


@dataclass(frozen=True)
class Halves:
    """Two halves, and how far each axis alone differs between them."""

    halves: tuple[Half, Half]
    in_x: Difference | None
    in_y: Difference | None


@dataclass(frozen=True)
class Disagreement:
    """An effect whose coefficients come out different from the two axes.

    Attributes
    ----------
    chosen
        The effect in the model.
    labels
        For each coefficient of it the group that shares it, "" for all.
    found
        What each axis says: cross-elevation first.
    splits
        The same, half by half of the sky and of the time.
    causes
        Other effects that, fitted besides, take most of it away, with the chance of what
        they leave; the one that gains most comes first.
    """

    chosen: Chosen
    labels: tuple[str, ...]
    found: Difference
    splits: tuple[Halves, ...]
    causes: tuple[tuple[str, Difference], ...]


@stage("comparing axes")
def disagreements(
    problem: Problem, weighed: WhitenedData, chosen: Sequence[Chosen]
) -> tuple[Disagreement, ...]:
    """Return the effects of the model, and of what was named, on which the axes disagree.

    Parameters
    ----------
    problem, weighed
        The case, weighed beside everything chosen.
    chosen
        What the search added to the model; fields without a name are passed over.
    """
    named = tuple(one for one in chosen if one.candidate.effect.physical)
    choices = (*problem.base, *named)
    ground = _Ground(
        problem, weighed if len(named) == len(chosen) else weigh(problem, named), choices
    )
    compared = [(one, ground.compare(one)) for one in choices]
    testable = [(one, found) for one, found in compared if found is not None]
    return tuple(
        ground.located(one, found)
        for one, found in testable
        if found.p_value < UNLIKELY / len(testable)
    )


class _Ground:
    """The case weighed beside the model and everything named."""

    def __init__(self, problem: Problem, weighed: WhitenedData, choices: tuple[Chosen, ...]):
        self.problem, self.weighed, self.choices = problem, weighed, choices
        self.is_y = problem.stack.is_y
        self.data = self.weighed.white[:, -1]
        self.dof = float(self.weighed.evidence.dof.sum())

    def others(self, one: Chosen) -> Array:
        """Return everything but one effect, of unit scatter."""
        rest = [each for each in self.choices if each is not one]
        return self.problem.expanded(rest, of=self.weighed.white)

    def compare(self, one: Chosen, others: Array | None = None) -> Difference | None:
        """Return what both axes say of an effect over all recordings; None if it is of one."""
        acts = self.problem.expanded([one]) != 0
        if not np.any(acts[self.is_y].any(axis=0) & acts[~self.is_y].any(axis=0)):
            return None
        rest = self.others(one) if others is None else others
        across, along = self._acting(one, ~self.is_y, self.is_y)
        return difference(rest, across, along, self.data, self.dof)

    def _acting(self, one: Chosen, *where: Mask) -> list[Array]:
        """Return an effect as it acts on each of some parts of the readings, of unit scatter."""
        own = self.problem.expanded([one])
        return [self.weighed.covariance.whiten(own * part[:, None]) for part in where]

    def located(self, one: Chosen, found: Difference) -> Disagreement:
        """Return a disagreement with where it is and what would take it away."""
        names = self.problem.blocks.names(one.scope)
        return Disagreement(
            one,
            tuple(names[place // len(one.candidate.columns)] for place in found.of),
            found,
            tuple(self._split(one, *cut) for cut in cuts(self.problem).values()),
            tuple(self._causes(one, found)),
        )

    def _split(self, one: Chosen, names: tuple[str, str], first: Mask) -> Halves:
        """Compare both axes in each half, and both halves in each axis."""
        y = self.is_y
        quarters = self._acting(one, first & ~y, first & y, ~first & ~y, ~first & y)
        others = self.others(one)

        def compared(a: Array, b: Array, *rest: Array) -> Difference | None:
            beside = np.concatenate([others, *rest], axis=1)
            return difference(beside, a, b, self.data, self.dof)

        xx, xy, yx, yy = quarters
        halves = (
            Half(names[0], compared(xx, xy, yx, yy)),
            Half(names[1], compared(yx, yy, xx, xy)),
        )
        return Halves(halves, compared(xx, yx, xy, yy), compared(xy, yy, xx, yx))

    def _causes(self, one: Chosen, found: Difference) -> Iterator[tuple[str, Difference]]:
        """Yield what takes most of a disagreement away and is worth its coefficients."""
        others, white = self.others(one), self.weighed.white
        own = self.problem.expanded([one], of=white)
        alone = np.concatenate([others, own], axis=1)
        causes: dict[str, tuple[float, Difference]] = {}
        for candidate in self.problem.candidates:
            more = self.problem.expanded([Chosen(candidate, "all")], of=white)
            gain = _gain(alone, more, self.data)
            if gain < SIGNIFICANT**2 * more.shape[1]:
                continue
            left = self.compare(one, np.concatenate([others, more], axis=1))
            if left is None or len(left.of) < len(found.of) or left.chi2 > MOSTLY * found.chi2:
                continue
            if gain > causes.get(candidate.effect.id, (0.0, left))[0]:
                causes[candidate.effect.id] = gain, left
        best = sorted(causes.items(), key=lambda item: -item[1][0])[:MOST_CAUSES]
        for name, (_, left) in best:
            yield name, left


def _gain(model: Array, more: Array, data: Array) -> float:
    """Return by how much more columns lower the sum of squares that a model leaves."""
    basis = spanned(model)[0]
    beside = np.concatenate([more, data[:, None]], axis=1)
    beside -= basis @ (basis.T @ beside)
    columns, left = beside[:, :-1], beside[:, -1]
    return float(left @ columns @ np.linalg.lstsq(columns, left, rcond=1e-9)[0])


def cuts(problem: Problem) -> dict[str, tuple[tuple[str, str], Mask]]:
    """Return the names of two halves of the readings and which are of the first, shape (m,).

    By what they are cut: elevation, azimuth and, where that is known, time.
    """
    at, row = problem.recordings.at, problem.stack.row
    middle = float(np.median(at.el))
    degrees = f"{np.degrees(middle):.0f} deg of elevation"
    found = {
        "elevation": ((f"below {degrees}", f"above {degrees}"), (at.el <= middle)[row]),
        "azimuth": (("in the east", "in the west"), (np.sin(at.az) > 0)[row]),
    }
    time = at.times
    if time is not None and np.ptp(time) > 0:
        middle = float(np.median(time))
        when = utc(middle)
        found["time"] = (f"before {when}", f"after {when}"), (time <= middle)[row]
    return found
