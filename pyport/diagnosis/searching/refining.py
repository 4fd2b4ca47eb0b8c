"""Refining: the moment of a step, or the curve of an edge, moved to where it fits best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.shapes.edges import edges_of
from pyport.diagnosis.weighing import View, WhitenedData, left_beside, plain_view
from pyport.effects import Effect, catalogue
from pyport.effects.empirical.epochs import epoch_step
from pyport.noise.covariance import Covariance
from pyport.recordings.sky import clock
from pyport.runs.stages import stage
from pyport.thresholds import FEWEST, SIGNIFICANT

#: The best moment of each of so many stretches of time is weighed with the drift.
STRETCHES = 24

Rows = NDArray[np.intp]


@stage("refining steps and edges")
def refine(
    problem: Problem, covariance: Covariance, chosen: Sequence[Chosen], plain: Chosen
) -> tuple[Problem, Chosen, float, float]:
    """Move the moment or edge of a choice to where it fits best, beside the rest of the model.

    A step may step back where that earns its second moment.

    Returns
    -------
    problem, chosen
        The case with the columns of the refined effect added, and the choice;
        both as they were where there is nothing to move.
    more
        By what factor the gain has grown.
    price
        What the further numbers of a moment or a curve must earn.
    """
    effect = plain.candidate.effect
    if plain.scope != "all":
        return problem, plain, 1.0, 0.0
    step = effect.is_change and effect.parameter is not None
    if not step and effect.edge is None:
        return problem, plain, 1.0, 0.0
    view = plain_view(problem, covariance, chosen)
    tried = (_steps if step else edges_of)(problem, view, effect)
    if not tried:
        return problem, plain, 1.0, 0.0
    # A drift pulls as a step does: what was found as if there were none is weighed with it.
    which = list(plain.candidate.coefficients)
    found = [problem.stack.columns(one, problem.recordings.at)[:, which] for one, _ in tried]
    old = problem.picked(plain.candidate.columns)
    before, *gains = _gains(problem, covariance, chosen, [old, *found])
    best = int(np.argmax([gain - price for gain, (_, price) in zip(gains, tried, strict=True)]))
    more = gains[best] / max(before, 1e-300)
    price = tried[best][1] - plain.candidate.price
    if more <= 1:
        return problem, plain, 1.0, 0.0
    return *problem.with_member(plain, tried[best][0]), more, max(float(price), 0.0)


def _gains(
    problem: Problem, covariance: Covariance, chosen: Sequence[Chosen], some: Sequence[Array]
) -> list[float]:
    """Return what each of some blocks of columns (m, k) gains beside the model."""
    _, left = left_beside(problem, covariance, chosen, np.concatenate(some, axis=1))
    gains = []
    for low, up in pairwise(np.cumsum([0, *(columns.shape[1] for columns in some)])):
        own = left[:, low:up]
        seen = own.T @ left[:, -1]
        gains.append(float(seen @ np.linalg.pinv(own.T @ own, hermitian=True) @ seen))
    return gains


@dataclass(frozen=True)
class _Shown:
    """What readings show of an effect that acts in some of them: sums from each to the last.

    Attributes
    ----------
    information
        Of its columns, shape (m + 1, k, k).
    crossed
        With the directions of the model, shape (m + 1, p, k).
    seen
        With what the model leaves, shape (m + 1, k).
    """

    information: Array
    crossed: Array
    seen: Array

    @classmethod
    def of(cls, columns: Array, basis: Array, left: Array) -> _Shown:
        """Return the sums of columns (m, k) beside a model's directions (m, p) and what it leaves.

        `left` is of shape (m,).
        """
        terms = (
            columns[:, :, None] * columns[:, None, :],
            basis[:, :, None] * columns[:, None, :],
            columns * left[:, None],
        )
        return cls(*(np.concatenate([np.cumsum(t[::-1], axis=0)[::-1], 0 * t[:1]]) for t in terms))

    def gains(self, first: Rows, behind: Rows) -> Array:
        """Return what the effect gains in the readings from `first` to before `behind`, (n,)."""
        crossed = self.crossed[first] - self.crossed[behind]
        seen = self.seen[first] - self.seen[behind]
        free = self.information[first] - self.information[behind]
        free = free - crossed.transpose(0, 2, 1) @ crossed
        values = (np.linalg.pinv(free, hermitian=True) @ seen[:, :, None])[:, :, 0]
        return np.asarray((values * seen).sum(axis=1))


def _steps(problem: Problem, view: View, effect: Effect) -> list[tuple[Effect, float]]:
    """Return steps between two recordings, one in each stretch, and the price of their moments.

    Each stands there twice: as it fits best, and as it fits best with a step back.
    """
    at = problem.recordings.at
    # With every row after the step its columns are those of the effect everywhere.
    always = epoch_step(-1e15, catalogue(at.mount)[effect.id], of_order=True)
    columns = problem.stack.columns(always, at)[view.rows] * view.root[:, None]
    time = clock(at)[problem.stack.row][view.rows]
    order = np.argsort(time, kind="stable")
    time, end = time[order], len(time)
    shown = _Shown.of(columns[order], view.basis[order], view.left[order])
    there = np.flatnonzero(np.diff(time, prepend=time[0]) > 0)
    there = there[(there >= FEWEST) & (there <= end - FEWEST)]
    gains = shown.gains(there, np.full(len(there), end))
    stretches = np.array_split(np.arange(len(there)), min(STRETCHES, max(len(there), 1)))
    starts = [int(there[one[np.argmax(gains[one])]]) for one in stretches if len(one)]
    session = problem.session[view.rows][order]
    # A zero that is moved may come back; a part of the mount that changed stays as it is.
    back = [] if effect.change_of else [_back(shown, there, n, session) for n in starts]
    pairs = [*((n, end) for n in starts), *sorted(set(filter(None, back)))]
    # A moment is one more number; that to step back at is chosen among all readings.
    price = float(np.log(max(end, 3)))
    return [
        (_moved(problem, effect, _midway(time, n), _midway(time, m)), price * (1 + 2 * (m < end)))
        for n, m in pairs
    ]


def _midway(time: Array, n: int) -> float:
    """Return the moment between a recording and the one before it; behind the last it is never."""
    return float(time[n - 1] + time[n]) / 2 if n < len(time) else np.inf


def _moved(problem: Problem, effect: Effect, since: float, until: float) -> Effect:
    """Return the step of an effect at other moments."""
    whole = catalogue(problem.recordings.at.mount)[effect.id]
    return epoch_step(since, whole, until, of_order=effect.changes_with == "order")


def _back(shown: _Shown, there: Rows, first: int, session: Codes) -> tuple[int, int] | None:
    """Return the best reading for a step near one, and for its step back in the same session.

    `there`: the readings that may be first, before or behind which there is a step; `session`: of
    each reading. None without room.
    """
    own = np.flatnonzero(session == session[first])
    near = there[(there >= own[0]) & (there <= own[-1] + 1)]
    behind = near[near >= first + FEWEST]
    if len(behind) == 0:
        return None
    last = int(behind[np.argmax(shown.gains(np.full(len(behind), first), behind))])
    before = near[near <= last - FEWEST]
    return int(before[np.argmax(shown.gains(before, np.full(len(before), last)))]), last


def began_between(
    problem: Problem, covariance: Covariance, others: Sequence[Chosen], one: Chosen
) -> tuple[float, float]:
    """Return the recordings between which a step began, by their time or number.

    Of the `STRETCHES` moments on either side of it those that explain the readings nearly as well,
    by less than `SIGNIFICANT` sigma, are as likely to be the one.
    """
    effect, at = one.candidate.effect, problem.recordings.at
    time = np.unique(clock(at)[problem.stack.row])
    time = time[np.isfinite(time)]
    now = int(np.searchsorted(time, effect.parameter or 0.0))
    near = np.arange(max(1, now - STRETCHES), min(len(time), now + STRETCHES + 1))
    near = near[time[near] < effect.until]
    which = list(one.candidate.coefficients)
    steps = [_moved(problem, effect, _midway(time, n), effect.until) for n in near.tolist()]
    columns = [problem.stack.columns(step, at)[:, which] for step in steps]
    gains = np.array(_gains(problem, covariance, others, columns))
    likely = near[gains >= gains[near == now] - SIGNIFICANT**2]
    return float(time[likely[0] - 1]), float(time[likely[-1]])


def past_outliers(
    problem: Problem, weighed: WhitenedData, one: Chosen
) -> tuple[Problem, list[Chosen]]:
    """Return a step moved to before and to behind the outliers next to it, and their case.

    A reading on the wrong side of a large step is an outlier, and no longer says where it belongs.
    """
    effect = one.candidate.effect
    if effect.parameter is None or not effect.is_change or one.scope != "all":
        return problem, []
    moved: list[Chosen] = []
    time = clock(problem.recordings.at)[problem.stack.row]
    moments = np.unique(time)
    sound = np.flatnonzero(~np.isin(moments, time[~weighed.used]))
    now = int(np.searchsorted(moments, effect.parameter))
    before, behind = sound[sound < now] + 1, sound[sound >= now]
    for n in {*before[-1:].tolist(), *behind[:1].tolist()} - {now}:
        step = _moved(problem, effect, _midway(moments, n), effect.until)
        problem, other = problem.with_member(one, step)
        moved.append(other)
    return problem, moved
