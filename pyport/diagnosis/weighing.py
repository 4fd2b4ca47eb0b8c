"""Weighing: the noise that a choice of effects leaves, and everything whitened by it.

While the search goes on every candidate is held against one noise. What changes with time can
pass for noise and noise for it, so before a change is accepted both worlds are fitted whole: one
where nights, sources and drifts do it all, and one with the change and what is left for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen, Problem, measurements
from pyport.diagnosis.evidence import Evidence, Projection
from pyport.diagnosis.trial import at_best, shown
from pyport.least_squares.gram import beyond, spanned
from pyport.noise import common_mode
from pyport.noise.covariance import Covariance
from pyport.noise.estimation.estimate import estimate, reweighed
from pyport.noise.series import Noise
from pyport.runs.stages import stage
from pyport.thresholds import ENOUGH_ANTENNAS, VISIBLE

DRAWS = 300


@dataclass(frozen=True)
class WhitenedData:
    """The evidence, weighed with the noise that a choice of effects leaves.

    Attributes
    ----------
    covariance
        Of the readings.
    white
        All columns and the data, whitened, shape (M, K + 1): see `Covariance.whiten`.
    evidence
        Their products.
    """

    covariance: Covariance
    white: Array
    evidence: Evidence

    @property
    def noises(self) -> tuple[Noise, ...]:
        """Return the noise of each series."""
        return self.covariance.noises

    @property
    def weights(self) -> Array:
        """Return the robust weights of the readings, shape (m,)."""
        return self.covariance.weights

    @property
    def used(self) -> NDArray[np.bool_]:
        """Tell which readings are no outliers, shape (m,)."""
        return self.covariance.used


@stage("whitening")
def weigh(
    problem: Problem, chosen: Sequence[Chosen] = (), *, searching: bool = True
) -> WhitenedData:
    """Fit the noise that is left beside the model and some effects, and weigh everything by it.

    See `noise` for `searching`. Beside what stands in the end nobody asks what noise alone would
    do: none is drawn.
    """
    covariance = noise(problem, chosen, searching=searching)
    draws = DRAWS if searching or not chosen else 0
    return _weighed(problem, chosen, covariance, covariance.whiten(problem.whole), draws)


@stage("whitening")
def weigh_model(
    problem: Problem, chosen: Sequence[Chosen], *, searching: bool = True
) -> WhitenedData:
    """Return what `weigh` does for what looks at the model and the data alone.

    No other column is whitened: they are zero. An array's common mode asks for all.
    """
    if problem.blocks.antennas >= ENOUGH_ANTENNAS:
        return weigh(problem, chosen, searching=searching)
    covariance = noise(problem, chosen, searching=searching)
    choices = (*problem.base, *chosen)
    own, _ = whitened(problem, covariance, choices)
    # Column by column in memory: no page of those that stay zero is touched.
    white = np.zeros((len(own), problem.size + 1), order="F")
    white[:, np.concatenate([*(one.candidate.columns for one in choices), [problem.size]])] = own
    return _weighed(problem, chosen, covariance, white, DRAWS)


def whitened(
    problem: Problem, covariance: Covariance, choices: Sequence[Chosen]
) -> tuple[Array, list[Chosen]]:
    """Return some choices' columns and the data, whitened, and the choices of those columns."""
    needed = [one.candidate.columns for one in choices]
    columns = problem.picked(np.concatenate([np.zeros(0, np.intp), *needed]))
    starts = np.cumsum([0, *map(len, needed)])
    own = [
        replace(one, candidate=replace(one.candidate, columns=np.arange(low, high)))
        for one, (low, high) in zip(choices, pairwise(starts), strict=True)
    ]
    return covariance.whiten(np.concatenate([columns, problem.residual[:, None]], axis=1)), own


def _weighed(
    problem: Problem, chosen: Sequence[Chosen], covariance: Covariance, white: Array, draws: int
) -> WhitenedData:
    evidence = Evidence(
        white,
        np.resize(problem.block, len(white)),
        np.resize(problem.stack.is_y, len(white)).astype(np.intp),
        problem.blocks,
        common=_common_excess(problem, (*problem.base, *chosen), white, covariance),
        numbers=len(np.unique(measurements(problem))),
        draws=draws,
        dof=np.array([covariance.dof[one] for one in np.unique(problem.blocks.antenna)]),
        rng=np.random.default_rng(problem.seed),
    )
    return WhitenedData(covariance, white, evidence)


def projection(problem: Problem, weighed: WhitenedData, chosen: Sequence[Chosen]) -> Projection:
    """Return the evidence with the model and what is chosen projected out."""
    return weighed.evidence.beside([problem.part(one) for one in (*problem.base, *chosen)])


@stage("whitening")
def weigh_alike(problem: Problem, chosen: Sequence[Chosen], known: Covariance) -> WhitenedData:
    """Return what `weigh` does with the noise that is known; only outliers are looked for anew."""
    design = problem.expanded([*problem.base, *chosen])
    covariance = reweighed(known, problem.residual, design, problem.frame)
    problem.memory[key_of(chosen, searching=True)] = covariance, tuple(chosen)
    return weigh(problem, chosen)


def by_columns(chosen: Sequence[Chosen]) -> list[Chosen]:
    """Return choices in the order of their columns: rounding must not tell who came first."""
    return sorted(chosen, key=lambda one: (tuple(one.candidate.columns), one.scope))


def key_of(chosen: Sequence[Chosen], *, searching: bool) -> tuple[object, ...]:
    """Return what the noise beside some effects is remembered by."""
    return (searching, *sorted((id(one.candidate), one.scope) for one in chosen))


@stage("fitting noise")
def noise(problem: Problem, chosen: Sequence[Chosen], *, searching: bool = True) -> Covariance:
    """Estimate the noise beside some effects, or remember it.

    Columns that join the design later do not touch it. While a search goes on, what its
    candidates could explain is no noise; in a final fit (`searching` false) it is.
    """

    def estimated() -> Covariance:
        design = problem.expanded([*problem.base, *by_columns(chosen)])
        shapes = problem.possible if searching else None
        return estimate(problem.residual, design, problem.frame, shapes)

    return problem.remembered(key_of(chosen, searching=searching), chosen, estimated)


def _common_excess(
    problem: Problem, fitted: Sequence[Chosen], white: Array, covariance: Covariance
) -> common_mode.Excess:
    """Return how much more scans scatter in common than independent antennas would."""
    if problem.blocks.antennas < ENOUGH_ANTENNAS:
        return common_mode.Excess()
    model = spanned(problem.expanded(fitted, of=white))[0]
    candidates = problem.lasting
    columns = [np.zeros(0, np.intp), *(one.columns for one in candidates)]
    data = white[:, np.append(np.concatenate(columns), len(white.T) - 1)]
    left = data - model @ (model.T @ data)
    shown = np.linalg.norm(left, axis=0) > VISIBLE * np.linalg.norm(data, axis=0)
    left = (left * shown)[covariance.means]
    explained = np.split(left[:, :-1], np.cumsum([len(one) for one in columns[1:]])[:-1], axis=1)
    offset = covariance.whiten(np.ones((len(problem.residual), 1)))[covariance.means, 0]
    return common_mode.excess(left[:, -1], offset, explained, model[covariance.means], problem.scan)


@dataclass(frozen=True)
class View:
    """Weighted readings with a model projected out, each as if alone: drifts are passed over.

    Attributes
    ----------
    rows
        The readings that count, shape (n,).
    root
        Root of their weights, shape (n,).
    basis
        Orthonormal columns that span the model, shape (n, p).
    left
        What the model leaves of the data, weighted, shape (n,).
    """

    rows: Codes
    root: Array
    basis: Array
    left: Array


def plain_view(problem: Problem, covariance: Covariance, chosen: Sequence[Chosen]) -> View:
    """Return the readings beside a model, outliers left out."""
    rows = np.flatnonzero(covariance.used)
    root = np.sqrt(covariance.weights[rows]) / covariance.scatter[rows]
    model = problem.expanded((*problem.base, *chosen))[rows] * root[:, None]
    basis = spanned(model)[0]
    data = problem.residual[rows] * root
    return View(rows, root, basis, data - basis @ (basis.T @ data))


def left_beside(
    problem: Problem, covariance: Covariance, chosen: Sequence[Chosen], columns: Array
) -> tuple[Array, Array]:
    """Return columns (m, k) whitened, and what the model leaves of them and of the data.

    The model is the base and what is chosen; both are of M rows, the data the last column.
    """
    white, choices = whitened(problem, covariance, (*problem.base, *chosen))
    model = problem.expanded(choices, of=white)
    own = covariance.whiten(columns)
    both = np.concatenate([own, white[:, -1:]], axis=1)
    return own, beyond(model, both)


def shown_beside(
    problem: Problem,
    covariance: Covariance,
    chosen: Sequence[Chosen],
    candidates: Sequence[Candidate],
) -> list[tuple[Array, Array]]:
    """Return what the data show of each candidate beside the model and what is chosen: `shown`."""
    places = [one.columns for one in candidates]
    own, left = left_beside(problem, covariance, chosen, problem.picked(np.concatenate(places)))
    length = np.linalg.norm(own, axis=0)
    starts = np.cumsum([0, *map(len, places)])
    return [shown(left[:, low:up], length[low:up], left[:, -1]) for low, up in pairwise(starts)]


def best_shown(
    problem: Problem,
    covariance: Covariance,
    chosen: Sequence[Chosen],
    candidates: Sequence[Candidate],
) -> Candidate:
    """Return the candidate that shows best beside the model, its price paid."""
    seen = shown_beside(problem, covariance, chosen, candidates)
    worth = [
        at_best(*each)[0] - one.price if len(each[0]) else -np.inf
        for each, one in zip(seen, candidates, strict=True)
    ]
    return candidates[int(np.argmax(worth))]
