"""Edges: the curve in the sky at which an offset jumps, from the grid to where it fits best."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array, Codes
from pyport.diagnosis.case import Problem
from pyport.diagnosis.weighing import View
from pyport.effects import Circumstances, Effect
from pyport.effects.base import AXES
from pyport.effects.telescope.structure import Edge, FreeEdge, elsewhere
from pyport.thresholds import FEWEST

#: First steps of the search for a waving edge: its height, and how it waves with azimuth. [rad]
_FIRST = np.array([4, 4, 4, 2, 2]) * DEG
_ROUNDS = 6
#: A free edge has an elevation of its own in every column of this width [rad], one of these [deg];
#: in the angles of other axes as many as they reach.
COLUMN = 10 * DEG
LEVELS = np.arange(0.0, 92.0, 1.0)
#: What a free edge must gain for every level that it climbs from one column to the next.
CLIMB = 0.7
#: Turns between the best edge for a jump and the best jump for an edge.
ROUNDS = 12


def edges_of(problem: Problem, view: View, effect: Effect) -> list[tuple[Effect, float]]:
    """Return the step across the curve that fits best, and how many numbers the curve has.

    The curve waves once and twice with azimuth; its five numbers are moved one
    after the other by steps that halve, since the gain is no smooth function of them.
    """
    at, row = angles_of(problem, effect), problem.stack.row[view.rows]
    az, el = at.az[row], at.el[row]
    size = whole(problem, effect)[view.rows]
    moved = size != 0
    wave = np.stack([np.ones(len(az)), np.cos(az), np.sin(az), np.cos(2 * az), np.sin(2 * az)])

    def gain(shape: Array) -> float:
        above = moved & (el >= shape @ wave)
        if min(above.sum(), (moved & ~above).sum()) < FEWEST:
            return 0.0
        column = above * size * view.root
        length = column @ column - ((view.basis.T @ column) ** 2).sum()
        return float((column @ view.left) ** 2 / max(length, 1e-12))

    of_number = np.log(max(len(view.rows), 3))
    found = [(effect, float(of_number))]
    free = _free(view, az, el, size, levels_of(at, effect))
    if free is not None:
        edge, turns = free
        jump = elsewhere(effect, edge_az_rad=edge.az, edge_el_rad=edge.el)
        found.append((jump, float(of_number) * (1 + turns)))
    start = _start(effect, wave)
    if start is None:
        if effect.acts_in == AXES:
            cut = _cut(view, az, size)
            found += [(elsewhere(effect, beyond_az_rad=one), float(of_number)) for one in cut]
        return found
    straight = np.where(np.arange(len(start)) == 0, start, 0.0)
    best = climbed(gain, straight, _FIRST[:1])
    for waves, first in ((3, start), (5, None)):
        wavier = climbed(gain, best if first is None else first, _FIRST[:waves])
        # Each further wave must earn its two numbers, as any coefficient must.
        if gain(wavier) > gain(best) + 2 * of_number:
            best = wavier
    numbers = max(1, int(np.count_nonzero(best)))
    jump = elsewhere(effect, wave_rad=tuple(map(float, best)))
    return [*found, (jump, float(of_number) * numbers)]


def angles_of(problem: Problem, effect: Effect) -> Circumstances:
    """Return the circumstances whose `az` and `el` an edge is a curve in."""
    at = problem.recordings.at
    return at.axes if effect.acts_in == AXES else at


def levels_of(at: Circumstances, effect: Effect) -> Array:
    """Return the levels that an edge may have in these angles [deg]."""
    if effect.acts_in != AXES:
        return LEVELS
    return np.arange(np.floor(at.el.min() / DEG), np.ceil(at.el.max() / DEG) + 1)


def whole(problem: Problem, effect: Effect) -> Array:
    """Return what a jump of one is in each reading when all are above its edge, shape (m,)."""
    at = replace(problem.recordings.at, fine=None)
    return problem.stack.columns(elsewhere(effect, above_el_rad=-np.inf), at)[:, 0]


@dataclass(frozen=True)
class Sky:
    """Readings sorted into columns of azimuth and levels of elevation.

    Attributes
    ----------
    column, level
        Of each reading; one on level n is above an edge on any lower level, shape (m,).
    columns
        How many columns there are.
    start, width
        Azimuth at which the first column begins, and how wide each is [rad].
    levels
        Elevations that an edge may have [deg].
    """

    column: Codes
    level: Codes
    columns: int
    start: float
    width: float
    levels: Array

    def of(self, rows: Codes) -> Sky:
        """Return the same of some of the readings."""
        return replace(self, column=self.column[rows], level=self.level[rows])

    def above(self, path: Codes) -> NDArray[np.bool_]:
        """Tell which readings are above an edge with a level in each column, shape (m,)."""
        return np.asarray(self.level > path[self.column])

    def above_each(self, values: Array) -> Array:
        """Return sums of values (m,) above each level in each column, (columns, levels)."""
        total = np.zeros((self.columns, len(self.levels) + 1))
        np.add.at(total, (self.column, self.level), values)
        return np.asarray(total[:, ::-1].cumsum(axis=1)[:, ::-1][:, 1:])

    @property
    def centres(self) -> Array:
        """Return the azimuth of the middle of each column [rad]."""
        return np.asarray(self.start + (np.arange(self.columns) + 0.5) * self.width)

    def edge_of(self, path: Codes) -> FreeEdge:
        """Return the curve through the middles of the columns."""
        return FreeEdge(tuple(self.centres), tuple(self.levels[path] * DEG))

    def path_of(self, edge: Edge) -> Codes:
        """Return the level in each column that is nearest to a curve."""
        el = np.clip(edge(self.centres) / DEG, self.levels[0], self.levels[-1])
        return np.rint((el - self.levels[0]) / (self.levels[1] - self.levels[0])).astype(int)


def sky_of(az: Array, el: Array, counted: NDArray[np.bool_], width: float, levels: Array) -> Sky:
    """Sort readings (m,) into columns that begin where those that are `counted` begin."""
    column = np.floor(az / width).astype(int)
    first, last = int(column[counted].min()), int(column[counted].max())
    level = ((el / DEG - levels[0]) / (levels[1] - levels[0])).astype(int) + 1
    return Sky(
        np.clip(column - first, 0, last - first),
        np.clip(level, 0, len(levels) - 1),
        last - first + 1,
        first * width,
        width,
        levels,
    )


def _cut(view: View, az: Array, size: Array) -> list[float]:
    """Return the first angle beyond which a jump fits best, none where one side is too empty."""
    order = np.argsort(az, kind="stable")
    az, column = az[order], (size * view.root)[order]
    beyond = np.column_stack([view.basis[order], view.left[order], column]) * column[:, None]
    beyond = beyond[::-1].cumsum(axis=0)[::-1]
    length = beyond[:, -1] - (beyond[:, :-2] ** 2).sum(axis=1)
    count = (column != 0).cumsum()
    there = np.flatnonzero(np.diff(az, prepend=az[0]) > 0)
    there = there[(count[there - 1] >= FEWEST) & (count[-1] - count[there - 1] >= FEWEST)]
    if len(there) == 0:
        return []
    best = there[np.argmax(beyond[there, -2] ** 2 / np.maximum(length[there], 1e-12))]
    return [float(az[best - 1] + az[best]) / 2]


def _free(
    view: View, az: Array, el: Array, size: Array, levels: Array
) -> tuple[FreeEdge, float] | None:
    """Return the edge of any form that fits best, and how many numbers its form is worth.

    The sky is cut into columns of azimuth; each has its own elevation from
    which on the offset is there, and going up or down from one column to the
    next has its price (Viterbi's path through all columns).
    """
    rows = np.flatnonzero(size)
    if len(rows) < 4 * FEWEST:
        return None
    root, left = (view.root * size)[rows], view.left[rows]
    sky = sky_of(az, el, size != 0, COLUMN, levels).of(rows)
    weight = root**2
    mass = sky.above_each(weight)
    scatter = float(np.median(1 / np.abs(root)))
    best: tuple[float, Codes] | None = None
    for sign in (1.0, -1.0):
        jump, share = sign * 1.5 * scatter, 0.4
        path = np.zeros(sky.columns, int)
        for _ in range(ROUNDS):
            pull = sky.above_each(root * (left + jump * share * root))
            new = _path(jump**2 * mass - 2 * jump * pull)
            if np.array_equal(new, path):
                break
            path = new
            above = sky.above(path)
            if min(above.sum(), (~above).sum()) < FEWEST:
                break
            share = float(weight[above].sum() / weight.sum())
            centred = (above - share) * root
            jump = float(centred @ left / (centred @ centred))
        above = sky.above(path)
        if min(above.sum(), (~above).sum()) < FEWEST or jump * sign <= 0:
            continue
        gain = jump**2 * float((((above - above.mean()) * root) ** 2).sum())
        score = gain - CLIMB * float(np.abs(np.diff(path)).sum())
        if best is None or score > best[0]:
            best = score, path
    if best is None:
        return None
    path = best[1]
    climbed = float(np.abs(np.diff(levels[path])).sum())
    # Each step of ten degrees up or down is a number of its own.
    return sky.edge_of(path), climbed / 10


def _path(cost: Array) -> Codes:
    """Return the level in each column that costs least altogether, climbing included."""
    levels = np.arange(cost.shape[1])
    climb = CLIMB * np.abs(levels[:, None] - levels)
    total, back = cost[0], []
    for own in cost[1:]:
        ways = total[:, None] + climb
        back.append(np.argmin(ways, axis=0))
        total = ways.min(axis=0) + own
    path = [int(np.argmin(total))]
    for before in reversed(back):
        path.append(int(before[path[-1]]))
    return np.array(path[::-1])


def climbed(gain: Callable[[Array], float], start: Array, step: Array) -> Array:
    """Return where the gain is highest, moving numbers, one after the other, by steps that halve.

    The first steps are for as many of the numbers (k,) as are moved; the others stay.
    """
    best, most = start, gain(start)
    for _ in range(_ROUNDS):
        moved = True
        while moved:
            moved = False
            for n in range(len(step)):
                for sign in (1, -1):
                    trial = best.copy()
                    trial[n] += sign * step[n]
                    if (score := gain(trial)) > most:
                        best, most, moved = trial, score, True
        step = step / 2
    return best


def _start(effect: Effect, wave: Array) -> Array | None:
    """Return the wave that is nearest to an edge; None for one that is no function of azimuth."""
    if effect.edge is None:
        return None
    curve = effect.edge(np.arctan2(wave[2], wave[1]))
    if not np.isfinite(curve).all():
        return None
    return np.asarray(np.linalg.lstsq(wave.T, curve, rcond=1e-9)[0])


def curve_points(problem: Problem, effect: Effect) -> tuple[tuple[float, float], ...] | None:
    """Return points (azimuth, elevation) [deg] along the edge of a jump; None without one."""
    edge = effect.edge
    if edge is None:
        return None
    at = problem.recordings.at
    first = 0.0 if effect.acts_in != AXES else -np.pi
    low, high = edge.span if isinstance(edge, FreeEdge) else (first, first + 2 * np.pi)
    az = np.arange(np.ceil(low / DEG / 5) * 5, high / DEG, 5.0)
    el = edge(az * DEG) / DEG
    if not np.isfinite(el).all():
        return None
    if effect.acts_in == AXES:
        az, el = at.mount.sky(az * DEG, el * DEG, at.frame)
        az, el = az[el > 0] / DEG % 360, el[el > 0] / DEG
    return tuple((float(a), float(e)) for a, e in zip(az, el, strict=True))
