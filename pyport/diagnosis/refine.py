"""Refining: the moment of a step and the curve of an edge, from the grid to where they fit best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.case import Chosen, Problem, WhitenedData
from pyport.diagnosis.edges import edges_of
from pyport.diagnosis.view import View, plain_view
from pyport.effects import Effect, catalogue
from pyport.effects.epochs import clock, epoch_step
from pyport.stages import stage
from pyport.thresholds import FEWEST

#: The best moment of each of so many stretches of time is weighed with the drift.
STRETCHES = 24


@stage("refining steps and edges")
def refine(
    setup: Problem, weighed: WhitenedData, chosen: Sequence[Chosen], plain: Chosen
) -> tuple[Problem, Chosen, float, float]:
    """Move the moment or edge of a choice to where it fits best, beside the rest of the model.

    Returns
    -------
    setup, chosen
        The case with the columns of the refined effect added, and the choice;
        both as they were where there is nothing to move.
    more
        By what factor the gain has grown.
    price
        What the further numbers of a moment or a curve must earn.
    """
    effect = plain.candidate.effect
    if plain.scope != "all":
        return setup, plain, 1.0, 0.0
    step = effect.is_change and effect.parameter is not None
    if not step and effect.edge is None:
        return setup, plain, 1.0, 0.0
    view = plain_view(setup, weighed, chosen)
    of_number = np.log(max(len(view.rows), 3))
    if step:
        tried = [(one, float(of_number)) for one in _moments(setup, view, effect)]
    else:
        tried = edges_of(setup, view, effect)
    # A drift pulls as a step does: what was found as if there were none is weighed with it.
    which = list(plain.candidate.coefficients)
    found = [setup.stack.columns(one, setup.recordings.at)[:, which] for one, _ in tried]
    old = setup.columns[:, plain.candidate.columns]
    before, *gains = _gains(setup, weighed, chosen, [old, *found])
    best = int(np.argmax([gain - price for gain, (_, price) in zip(gains, tried, strict=True)]))
    more = gains[best] / max(before, 1e-300)
    price = tried[best][1] - plain.candidate.price
    if more <= 1:
        return setup, plain, 1.0, 0.0
    better, columns = tried[best][0], found[best]
    start = setup.columns.shape[1]
    candidate = replace(
        plain.candidate, effect=better, columns=np.arange(start, start + columns.shape[1])
    )
    wider = replace(setup, columns=np.concatenate([setup.columns, columns], axis=1))
    return wider, Chosen(candidate, plain.scope), more, max(float(price), 0.0)


def _gains(
    setup: Problem, weighed: WhitenedData, chosen: Sequence[Chosen], some: Sequence[Array]
) -> list[float]:
    """Return what each of some blocks of columns (m, k) gains beside the model."""
    model = setup.expanded((*setup.base, *chosen), of=weighed.white)
    white = weighed.covariance.whiten(np.concatenate(some, axis=1))
    both = np.concatenate([white, weighed.white[:, -1:]], axis=1)
    both -= model @ np.linalg.lstsq(model, both, rcond=1e-9)[0]
    gains, start = [], 0
    for columns in some:
        own = both[:, start : start + columns.shape[1]]
        start += columns.shape[1]
        seen = own.T @ both[:, -1]
        gains.append(float(seen @ np.linalg.pinv(own.T @ own, hermitian=True) @ seen))
    return gains


def _moments(setup: Problem, view: View, effect: Effect) -> list[Effect]:
    """Return steps at the moments between two recordings that fit best, one in each stretch."""
    at = setup.recordings.at
    # With every row after the step its columns are those of the effect everywhere.
    whole = catalogue(at.mount)[effect.id]
    always = epoch_step(-1e15, whole, of_order=True)
    columns = setup.stack.columns(always, at)[view.rows] * view.root[:, None]
    time = clock(at)[setup.stack.row][view.rows]
    order = np.argsort(time, kind="stable")
    time, columns = time[order], columns[order]
    since = _from_the_end(columns[:, :, None] * columns[:, None, :])
    crossed = _from_the_end(view.basis[order][:, :, None] * columns[:, None, :])
    seen = _from_the_end(columns * view.left[order][:, None])
    information = since - crossed.transpose(0, 2, 1) @ crossed
    there = np.flatnonzero(np.diff(time, prepend=time[0]) > 0)
    there = there[(there >= FEWEST) & (there <= len(time) - FEWEST)]
    if len(there) == 0:
        return [effect]
    values = (np.linalg.pinv(information[there], hermitian=True) @ seen[there][:, :, None])[:, :, 0]
    gains = (values * seen[there]).sum(axis=1)
    stretches = np.array_split(np.arange(len(there)), min(STRETCHES, len(there)))
    best = [int(there[one[np.argmax(gains[one])]]) for one in stretches]
    of_order = effect.changes_with == "order"
    return [epoch_step(float(time[n - 1] + time[n]) / 2, whole, of_order=of_order) for n in best]


def _from_the_end(values: Array) -> Array:
    """Return sums from each row to the last."""
    return np.asarray(values[::-1].cumsum(axis=0)[::-1])
