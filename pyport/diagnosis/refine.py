"""Refining: the moment of a step and the curve of an edge, from the grid to where they fit best."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import DEG, Array
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen, Setup, Weighed
from pyport.diagnosis.evidence import Trial
from pyport.diagnosis.noise import whiten
from pyport.effects import CATALOGUE, Effect
from pyport.effects.epochs import epoch_step
from pyport.effects.structure import curved_jump
from pyport.fitting.stacking import Codes

#: Fewer readings than this on either side of a step or an edge decide nothing.
FEWEST = 8
#: The best moment of each of so many stretches of time is weighed with the drift.
STRETCHES = 24
#: First steps of the search for an edge: its height, and how it waves with azimuth. [rad]
_FIRST = np.array([4, 4, 4, 2, 2]) * DEG
_ROUNDS = 6


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


def refine(
    setup: Setup, weighed: Weighed, chosen: Sequence[Chosen], winner: Trial
) -> tuple[Setup, Chosen, float, float]:
    """Move a winner's moment or edge to where it fits best, beside the rest of the model.

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
    effect, plain = winner.candidate.effect, Chosen(winner.candidate, winner.scope)
    if winner.scope != "all":
        return setup, plain, 1.0, 0.0
    step = effect.id.startswith("epoch") and effect.parameter is not None
    if not step and not (effect.id == "subreflector_jump" and effect.edge is not None):
        return setup, plain, 1.0, 0.0
    view = plain_view(setup, weighed, chosen)
    tried, numbers = (_moments(setup, view, effect), 1) if step else _edges(setup, view, effect)
    # A drift pulls as a step does: what was found as if there were none is weighed with it.
    which = list(winner.candidate.coefficients)
    found = [setup.stack.columns(one, setup.recordings.at)[:, which] for one in tried]
    old = setup.columns[:, winner.candidate.columns]
    before, *gains = _gains(setup, weighed, chosen, [old, *found])
    best = int(np.argmax(gains))
    more = gains[best] / max(before, 1e-300)
    price = numbers * np.log(max(len(view.rows), 3)) - 2 * np.log(winner.candidate.choices)
    if more <= 1:
        return setup, plain, 1.0, 0.0
    better, columns = tried[best], found[best]
    start = setup.columns.shape[1]
    candidate = replace(
        winner.candidate, effect=better, columns=np.arange(start, start + columns.shape[1])
    )
    wider = replace(setup, columns=np.concatenate([setup.columns, columns], axis=1))
    return wider, Chosen(candidate, winner.scope), more, max(float(price), 0.0)


def _gains(
    setup: Setup, weighed: Weighed, chosen: Sequence[Chosen], some: Sequence[Array]
) -> list[float]:
    """Return what each of some blocks of columns (m, k) gains beside the model."""
    model = setup.expanded((*setup.base, *chosen), of=weighed.white)
    white = whiten(np.concatenate(some, axis=1), weighed.weights, setup.parts, weighed.noises)
    both = np.concatenate([white, weighed.white[:, -1:]], axis=1)
    both -= model @ np.linalg.lstsq(model, both, rcond=1e-9)[0]
    gains, start = [], 0
    for columns in some:
        own = both[:, start : start + columns.shape[1]]
        start += columns.shape[1]
        seen = own.T @ both[:, -1]
        gains.append(float(seen @ np.linalg.pinv(own.T @ own, hermitian=True) @ seen))
    return gains


def plain_view(setup: Setup, weighed: Weighed, chosen: Sequence[Chosen]) -> View:
    """Return the readings beside a model, outliers left out."""
    scatter = np.ones(len(setup.residual))
    for part, noise in zip(setup.parts, weighed.noises, strict=True):
        scatter[part.rows] = noise.floor
    rows = np.flatnonzero(weighed.used)
    root = np.sqrt(weighed.weights[rows]) / scatter[rows]
    model = setup.expanded((*setup.base, *chosen))[rows] * root[:, None]
    model = model / np.maximum(np.linalg.norm(model, axis=0), 1e-300)
    basis, strength, _ = np.linalg.svd(model, full_matrices=False)
    basis = basis[:, strength > 1e-9 * strength.max(initial=1e-300)]
    data = setup.residual[rows] * root
    return View(rows, root, basis, data - basis @ (basis.T @ data))


def _moments(setup: Setup, view: View, effect: Effect) -> list[Effect]:
    """Return steps at the moments between two recordings that fit best, one in each stretch."""
    at = setup.recordings.at
    # With every row after the step its columns are those of the effect everywhere.
    always = epoch_step(0.0, CATALOGUE[effect.id])
    long_ago = replace(at, columns={**at.columns, "time": np.ones(len(at))})
    columns = setup.stack.columns(always, long_ago)[view.rows] * view.root[:, None]
    time = at.numbers("time")[setup.stack.row][view.rows]
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
    return [epoch_step(float(time[n - 1] + time[n]) / 2, CATALOGUE[effect.id]) for n in best]


def _from_the_end(values: Array) -> Array:
    """Return sums from each row to the last."""
    return np.asarray(values[::-1].cumsum(axis=0)[::-1])


def _edges(setup: Setup, view: View, effect: Effect) -> tuple[list[Effect], int]:
    """Return the step across the curve that fits best, and how many numbers the curve has.

    The curve waves once and twice with azimuth; its five numbers are moved one
    after the other by steps that halve, since the gain is no smooth function of them.
    """
    at, row = setup.recordings.at, setup.stack.row[view.rows]
    az, el = at.az[row], at.el[row]
    is_y = setup.stack.is_y[view.rows]
    wave = np.stack([np.ones(len(az)), np.cos(az), np.sin(az), np.cos(2 * az), np.sin(2 * az)])

    def gain(shape: Array) -> float:
        above = is_y & (el >= shape @ wave)
        if min(above.sum(), (is_y & ~above).sum()) < FEWEST:
            return 0.0
        column = above * view.root
        length = column @ column - ((view.basis.T @ column) ** 2).sum()
        return float((column @ view.left) ** 2 / max(length, 1e-12))

    start = _start(effect, wave)
    if start is None:
        return [effect], 1
    # Each further wave must earn its two numbers, as any coefficient must.
    price = 2 * np.log(max(len(view.rows), 3))
    straight = np.where(np.arange(len(start)) == 0, start, 0.0)
    best = _climbed(gain, straight, 1)
    for waves, first in ((3, start), (5, None)):
        wavier = _climbed(gain, best if first is None else first, waves)
        if gain(wavier) > gain(best) + price:
            best = wavier
    return [curved_jump(tuple(map(float, best)))], max(1, int(np.count_nonzero(best)))


def _climbed(gain: Callable[[Array], float], start: Array, numbers: int) -> Array:
    """Return where the gain is highest, moving the first `numbers` by steps that halve."""
    best, most, step = start, gain(start), _FIRST.copy()
    for _ in range(_ROUNDS):
        moved = True
        while moved:
            moved = False
            for n in range(numbers):
                for sign in (1, -1):
                    trial = best.copy()
                    trial[n] += sign * step[n]
                    if (score := gain(trial)) > most:
                        best, most, moved = trial, score, True
        step /= 2
    return best


def _start(effect: Effect, wave: Array) -> Array | None:
    """Return the wave that is nearest to an edge; None for one that is no function of azimuth."""
    if effect.edge is None:
        return None
    curve = effect.edge(np.arctan2(wave[2], wave[1]))
    if not np.isfinite(curve).all():
        return None
    return np.asarray(np.linalg.lstsq(wave.T, curve, rcond=1e-9)[0])


def curve_points(candidate: Candidate) -> tuple[tuple[float, float], ...] | None:
    """Return points (azimuth, elevation) [deg] along the edge of a jump; None without one."""
    edge = candidate.effect.edge
    if edge is None:
        return None
    az = np.arange(0.0, 360.0, 5.0)
    el = edge(az * DEG) / DEG
    if not np.isfinite(el).all():
        return None
    return tuple((float(a), float(e)) for a, e in zip(az, el, strict=True))
