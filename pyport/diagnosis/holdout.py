"""Held-out data: the only proof that a better fit is more than a more flexible one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.folds import FEWEST_STRETCHES, Folds
from pyport.diagnosis.joint import rms
from pyport.diagnosis.naming.finding import HeldOut
from pyport.diagnosis.searching.changes import columns_anew
from pyport.diagnosis.weighing import WhitenedData, whitened
from pyport.least_squares import robust
from pyport.least_squares.gram import Gram, Solution
from pyport.noise.coefficients import tempered
from pyport.noise.covariance import Covariance
from pyport.runs.stages import stage
from pyport.thresholds import CLIP, GROSS

#: A prediction is open when more than this share of its columns is what the fit leaves open.
OPEN = 1e-4


@stage("holding data out")
def residuals(
    problem: Problem,
    weighed: WhitenedData,
    chosen: Sequence[Chosen],
    partition: Folds,
    whole: Sequence[Chosen] = (),
) -> Array:
    """Return each reading less what a fit without its fold predicts [rad], shape (m,).

    What was chosen from the data is chosen anew without the fold, beside the `whole` of what was
    chosen. NaN where the other folds do not determine the prediction. They are remembered.
    """
    whole = whole or chosen
    identities = tuple(map(id, chosen)), tuple(map(id, whole)), id(weighed.covariance)
    key = "unseen", *identities, partition.fold.tobytes(), partition.departing
    return problem.remembered(
        key,
        (*chosen, *whole, weighed.covariance),
        lambda: _residuals(problem, weighed, chosen, partition, whole),
    )


def _residuals(
    problem: Problem,
    weighed: WhitenedData,
    chosen: Sequence[Chosen],
    partition: Folds,
    whole: Sequence[Chosen],
) -> Array:
    left = np.full(len(problem.residual), np.nan)
    if problem.blocks.antennas > 1:
        solutions = _of_products(problem, weighed, chosen, partition)
    else:
        solutions = _of_others(problem, weighed, chosen, partition, whole)
    for one, columns, solution, covariance, curve in solutions:
        rows = np.flatnonzero(partition.fold == one)
        unknown = _left_open(solution, columns[rows])
        predicted = columns @ solution.values + curve
        if partition.departing and covariance is not None:
            predicted += covariance.departed(problem.residual - predicted)
        left[rows] = np.where(unknown, np.nan, (problem.residual - predicted)[rows])
    return left


#: A fold, the columns of the fit, the solution without it, the covariance of the others, and what
#: they predict beside the fit.
_Solutions = Iterator[tuple[int, Array, Solution, Covariance | None, Array]]


def _of_products(
    problem: Problem, weighed: WhitenedData, chosen: Sequence[Chosen], partition: Folds
) -> _Solutions:
    """Yield the solutions of an array: a fold is taken off the products of the whole.

    Its readings hang together too little for it to matter that those left out were there when
    the others were whitened.
    """
    columns = problem.expanded((*problem.base, *chosen))
    noise = tempered(weighed.covariance)
    white, choices = whitened(problem, noise, (*problem.base, *chosen))
    for one, solution, _ in _without_each(problem, white, choices, partition):
        yield one, columns, solution, None, np.zeros(len(columns))


def _of_others(
    problem: Problem,
    weighed: WhitenedData,
    chosen: Sequence[Chosen],
    partition: Folds,
    whole: Sequence[Chosen],
) -> _Solutions:
    """Yield the solutions of a single antenna: a fold has no weight in them, nor in the choices."""
    base = problem.expanded(problem.base)
    for one in np.unique(partition.fold):
        weights = np.where(partition.fold == one, 0.0, weighed.weights)
        covariance = replace(weighed.covariance, weights=weights)
        key = "anew", *map(id, whole), id(weighed.covariance), partition.fold.tobytes(), int(one)
        make = partial(columns_anew, problem, covariance, whole)
        found = problem.remembered(key, (*whole, weighed.covariance), make) if chosen else ()
        anew = dict(zip(map(id, whole), found, strict=True)) if chosen else {}
        parts = [(problem.base, base), *(((each,), anew[id(each)].columns) for each in chosen)]
        columns = np.concatenate([own for _, own in parts], axis=1)
        known = [np.resize(problem.precision(some), own.shape[1]) for some, own in parts]
        curves = [anew[id(each)].curve for each in chosen]
        curve = np.sum(
            [np.zeros(len(base)), *(some for some in curves if some is not None)], axis=0
        )
        data = np.concatenate([columns, (problem.residual - curve)[:, None]], axis=1)
        products = tempered(covariance).products(data)
        yield int(one), columns, Solution.of(products, np.concatenate(known)), covariance, curve


@stage("holding data out")
def unseen_misfit(
    problem: Problem, weighed: WhitenedData, chosen: Sequence[Chosen], partition: Folds
) -> float:
    """Return the whitened sum of squares of predictions of data left out, each at most `CLIP`.

    Noise and outliers weigh in it as they do in the fit, and what cannot be
    predicted counts as far off.
    """
    white, choices = whitened(problem, weighed.covariance, (*problem.base, *chosen))
    columns = problem.expanded(choices, of=white)
    total = 0.0
    for _, solution, rows in _without_each(problem, white, choices, partition):
        left = white[rows, -1] - columns[rows] @ solution.values
        unknown = _left_open(solution, columns[rows])
        total += float(np.where(unknown, CLIP, np.minimum(left**2, CLIP)).sum())
    return total / weighed.evidence.common.factor


def _left_open(solution: Solution, columns: Array) -> NDArray[np.bool_]:
    """Tell which predictions a fit leaves open, from the columns of what is predicted, (n, P).

    Coefficients that are not determined one by one may be so together: at one elevation
    nobody tells a zero from sag, and the offset there is known all the same.
    """
    if solution.known.all():
        return np.zeros(len(columns), bool)
    beyond = columns - columns @ (solution.covariance @ solution.normal)
    return np.asarray(np.linalg.norm(beyond, axis=1) > OPEN * np.linalg.norm(columns, axis=1), bool)


def _without_each(
    problem: Problem, white: Array, choices: Sequence[Chosen], partition: Folds
) -> Iterator[tuple[int, Solution, Codes]]:
    """Yield each fold, the solution without it, and the fold's rows of the whitened columns.

    A fold is taken off the sufficient statistics of the whole; nothing is fitted anew.
    """
    parts = [problem.part(one) for one in choices]
    block = np.resize(problem.block, len(white))
    fold = np.resize(partition.fold, len(white))
    whole = Gram.of(white, block, len(problem.blocks)).matrices
    known = problem.precision(choices)
    for one in np.unique(partition.fold):
        rows = np.flatnonzero(fold == one)
        own = Gram.of(white[rows], block[rows], len(problem.blocks)).matrices
        yield int(one), Gram(whole - own).solve(parts, known), rows


@dataclass(frozen=True)
class Unseen:
    """Residuals of readings that the fit had not seen, before and after [rad], shape (m,) each.

    `stretch` (m,) numbers what was left out together: a fold within a session; `counted` (m,)
    tells which readings were predicted by both and are no gross errors.
    """

    partition: Folds
    stretch: Codes
    before: Array
    after: Array
    counted: NDArray[np.bool_]

    def rms(self) -> tuple[float, float]:
        """Return the plain rms before and after, over all readings that count [rad]."""
        return rms(self.before[self.counted]), rms(self.after[self.counted])

    def compared(self, rows: NDArray[np.bool_], floor: Array) -> HeldOut:
        """Return the plain rms over some rows (m,), and that of the scatter alone (m,)."""
        both = rows & self.counted
        return HeldOut(
            self.partition.scheme,
            rms(self.before[both]),
            rms(self.after[both]),
            rms(floor[both]),
            self.fall_sigma(both, FEWEST_STRETCHES),
            int((rows & ~self.counted).sum()),
        )

    def fall_sigma(self, rows: NDArray[np.bool_], fewest: int) -> float | None:
        """Return the error of the fall of the rms [rad] over some rows (m,), by stretches.

        They are drawn independently; None where there are fewer than `fewest`.
        """
        stretch = np.unique(self.stretch[rows], return_inverse=True)[1]
        count = int(stretch.max(initial=-1)) + 1
        if count < fewest:
            return None
        before, after = self.before[rows], self.after[rows]
        share = before**2 / max(rms(before), 1e-300) - after**2 / max(rms(after), 1e-300)
        # The derivative of each rms by its mean square is one over twice the rms.
        share = (share - share.mean()) / (2 * len(share))
        sums = np.bincount(stretch, share, count)
        return float(np.sqrt(count / (count - 1) * np.sum(sums**2)))


def unseen(
    problem: Problem,
    weighed: tuple[WhitenedData, WhitenedData],
    before: tuple[Chosen, ...],
    after: tuple[Chosen, ...],
    partition: Folds,
) -> Unseen:
    """Predict what was left out with and without some effects, each under its own noise.

    A reading is a gross error when both predictions miss it by more than `GROSS` times the
    scatter that the readings of the other folds have about theirs.
    """
    added = {*map(id, before)} <= {*map(id, after)}
    first = residuals(problem, weighed[0], before, partition, after if before and added else ())
    second = residuals(problem, weighed[1], after, partition)
    finite = np.isfinite(first) & np.isfinite(second)
    nearest = np.where(finite, np.minimum(np.abs(first), np.abs(second)), np.inf)
    counted = finite.copy()
    for series in np.unique(problem.series):
        inside = problem.series == series
        for fold in np.unique(partition.fold[inside]):
            own = inside & (partition.fold == fold)
            others = inside & (partition.fold != fold) & finite
            if others.any():
                counted[own] &= nearest[own] <= GROSS * robust.scale(nearest[others])
    number = problem.session * (partition.fold.max() + 1) + partition.fold
    stretch = np.unique(number, return_inverse=True)[1]
    return Unseen(partition, stretch, first, second, counted)
