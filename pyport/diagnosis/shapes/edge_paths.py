"""Edges of any form, averaged over: how big a jump is when its edge is known only so well.

The edge that fits best takes the noise of the readings next to it for itself, and readings on
its wrong side look like outliers. So edges are drawn as they are likely (Gibbs sampling), in
turn with what hangs on them: the model's coefficients, the drift, and which readings are bad.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from pyport.angles import DEG, Array, Codes
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.searching.turns import Outcome
from pyport.diagnosis.shapes.edges import Sky, angles_of, levels_of, sky_of, whole
from pyport.diagnosis.weighing import weigh_alike
from pyport.effects import Effect
from pyport.effects.telescope.structure import FreeEdge, SoftEdge, elsewhere
from pyport.least_squares.gram import inverted
from pyport.noise.series import Noise
from pyport.noise.whitening import FAR, factor, whitening
from pyport.runs.stages import stage
from pyport.thresholds import FEWEST

if TYPE_CHECKING:
    from celerite2 import GaussianProcess


Flags = NDArray[np.bool_]

#: So many edges are drawn, after some that forget where the search had left it.
DRAWS, FORGOTTEN = 60, 15
#: An edge has an elevation of its own in every column of this width [rad]; a degree up or down
#: from one to the next costs so much of the log of how likely it is.
COLUMN, CLIMB = 5 * DEG, 0.7
#: This share of the pointings may be bad; those scatter so many times as far.
BAD, WIDE = 0.05, 10.0
#: A drift before any reading gets this share of its power as noise, so that it can be drawn.
JITTER = 1e-6


@dataclass(frozen=True)
class _Track:
    """One antenna's pointings in elevation: what the model's columns and the data are in each.

    Attributes
    ----------
    columns, data
        Means over each pointing, shapes (n, P) and (n,).
    variance, time, noise
        Of those means; time is None where unknown.
    sky
        In which column of azimuth and on which level of elevation each pointing is.
    """

    columns: Array
    data: Array
    variance: Array
    time: Array | None
    noise: Noise
    sky: Sky

    def believed(self, good: Flags) -> Array:
        """Return the variances where those who are not `good` say nothing, shape (n,)."""
        return np.where(good, self.variance, FAR)

    def whitened(self, above: Flags, good: Flags) -> Array:
        """Return the columns, the jump's and the data with unit scatter, shape (n, P + 2)."""
        both = np.column_stack([self.columns, above, self.data])
        return factor(both, self.believed(good), self.time, self.noise.drifts)[1]

    def drift(self, left: Array, good: Flags, rng: np.random.Generator) -> Array:
        """Draw the drift, given what is left of the data beside model and jump, shape (n,)."""
        if self._prior is None:
            return np.zeros(len(left))
        drawn = self._prior.dot_tril(rng.standard_normal(len(left)))
        variance = self.believed(good)
        off = left - drawn - np.sqrt(variance) * rng.standard_normal(len(left))
        process = self._process(variance)
        return np.asarray(drawn + off - variance * process.apply_inverse(off))

    @cached_property
    def _prior(self) -> GaussianProcess | None:
        """Return the drift before any reading; None where nothing drifts."""
        if self.time is None or not self.noise.drifts:
            return None
        return self._process(np.full(len(self.data), JITTER * self.noise.drift**2))

    def _process(self, variance: Array) -> GaussianProcess:
        from celerite2 import GaussianProcess, terms

        kernel = terms.TermSum(
            *(terms.RealTerm(a=size**2, c=1 / memory) for size, memory in self.noise.drifts)
        )
        process = GaussianProcess(kernel)
        process.compute(self.time, diag=variance)
        return process


@stage("averaging over edges")
def averaged(outcome: Outcome) -> Outcome:
    """Put the middle of all edges that the recordings allow in place of the one that fits best.

    A reading counts as above with the share of the edges that leave it above. The scatter of
    the jump from edge to edge goes into its error. Edges that are straight or wave are left as
    they are: a few numbers hold them; and so are those of what else steps than the second axis.
    """
    for chosen in outcome.chosen:
        effect = chosen.candidate.effect
        edge = effect.edge
        if isinstance(edge, FreeEdge) and _of_second(outcome.problem, effect):
            outcome = _with_middle_edge(outcome, chosen, edge)
    return outcome


def _of_second(problem: Problem, effect: Effect) -> bool:
    """Tell whether a jump moves the second axis alone, by as much in every reading."""
    return np.array_equal(whole(problem, effect), problem.stack.is_y)


def _with_middle_edge(outcome: Outcome, old: Chosen, edge: FreeEdge) -> Outcome:
    found = _drawn(outcome, old, edge)
    if found is None:
        return outcome
    problem = outcome.problem
    columns = np.where(problem.stack.is_y, found.above, 0.0)[:, None]
    candidate = replace(
        old.candidate,
        effect=_jump(old.candidate.effect, found),
        columns=np.array([problem.size]),
    )
    problem = problem.with_columns(columns)
    new = Chosen(candidate, old.scope, found.spread)
    outcome = replace(outcome, problem=problem).exchanged(old, new)
    # The noise is that of the edge which fitted best; readings beside it are judged anew.
    weighed = weigh_alike(problem, outcome.chosen, outcome.weighed.covariance)
    return replace(outcome, weighed=weighed)


def _jump(old: Effect, found: _Drawn) -> Effect:
    edge, soft = found.edge, found.soft
    return elsewhere(old, edge_az_rad=edge.az, edge_el_rad=edge.el, share=soft.member)


@dataclass(frozen=True)
class _Drawn:
    """What draws of an edge have in common.

    Attributes
    ----------
    edge
        The middle of all.
    above
        How many of them leave each reading above, as a share, shape (m,).
    soft
        The same for every place in the sky.
    spread
        Scatter of the jump from one to the next [rad].
    """

    edge: FreeEdge
    above: Array
    soft: SoftEdge
    spread: float


def _drawn(outcome: Outcome, old: Chosen, edge: FreeEdge) -> _Drawn | None:
    """Draw edges; None where one side of them all but empties."""
    problem = outcome.problem
    at, row = angles_of(problem, old.candidate.effect), problem.stack.row
    levels = levels_of(at, old.candidate.effect)
    sky = sky_of(at.az[row], at.el[row], problem.stack.is_y, COLUMN, levels)
    tracks, fixed = _taken_apart(outcome, old, sky)
    rng = np.random.default_rng(problem.seed)
    path = sky.path_of(edge)
    good = [np.ones(len(track.data), bool) for track in tracks]
    paths, jumps = [], []
    for _ in range(FORGOTTEN + DRAWS):
        above = [track.sky.above(path) for track in tracks]
        count = sum(int(one.sum()) for one in above)
        if min(count, sum(map(len, above)) - count) < FEWEST:
            return None
        values, jump = _values(tracks, above, good, fixed, rng)
        likelier = np.zeros(())
        for n, track in enumerate(tracks):
            left = track.data - track.columns @ values[:-1]
            left -= track.drift(left - values[-1] * above[n], good[n], rng)
            scatter = np.sqrt(track.variance)
            below, beyond = left / scatter, (left - values[-1]) / scatter
            likelier = likelier + track.sky.above_each(_log_likely(beyond) - _log_likely(below))
            good[n] = _good(np.where(above[n], beyond, below), rng)
        path = _path(likelier, rng)
        paths.append(path)
        jumps.append(jump)
    paths = paths[FORGOTTEN:]
    return _Drawn(
        sky.edge_of(np.median(paths, axis=0).astype(int)),
        np.mean([sky.above(one) for one in paths], axis=0),
        _soft(sky, np.array(paths)),
        float(np.std(jumps[FORGOTTEN:])),
    )


def _soft(sky: Sky, paths: Codes) -> SoftEdge:
    """Return how many of some edges (draws, columns) leave each place in the sky above."""
    levels = np.arange(len(sky.levels))
    share = np.mean(levels[None, None, :] > paths[:, :, None], axis=0)
    return SoftEdge(sky.start, sky.width, share, float(sky.levels[0]))


def _taken_apart(outcome: Outcome, old: Chosen, sky: Sky) -> tuple[list[_Track], Array]:
    """Return the tracks in elevation, and the products of all that no edge touches."""
    problem, weighed = outcome.problem, outcome.weighed
    others = [one for one in (*problem.base, *outcome.chosen) if one is not old]
    data = np.column_stack([problem.expanded(others), problem.residual])
    white = weighed.covariance.whiten(data)
    tracks = []
    for part, noise in zip(problem.parts, weighed.noises, strict=True):
        if part.is_y:
            first = part.first
            white[weighed.covariance.means.start + first] = 0.0
            # A pointing that was thought all bad may just be beyond the wrong edge.
            weights = weighed.weights[part.rows]
            heaviest = np.zeros(len(first))
            np.maximum.at(heaviest, part.pointing, weights)
            even = weights / np.maximum(heaviest[part.pointing], 1e-12)
            precision = weighed.covariance.precision[part.rows]
            seen = whitening(even, precision, part, noise)
            means, variance = seen.means(data[part.rows]), seen.variance
            own = sky.of(first)
            tracks.append(_Track(means[:, :-1], means[:, -1], variance, part.time, noise, own))
    return tracks, white.T @ white


def _values(
    tracks: Sequence[_Track],
    above: Sequence[Flags],
    good: Sequence[Flags],
    fixed: Array,
    rng: np.random.Generator,
) -> tuple[Array, float]:
    """Draw the coefficients, the jump's last; with them comes the mean that the jump's has.

    The drift is not held here: the noise is correlated by it.
    """
    size = len(fixed)
    normal = np.zeros((size + 1, size + 1))
    order = [*range(size - 1), size]
    normal[np.ix_(order, order)] = fixed
    for track, up, sound in zip(tracks, above, good, strict=True):
        white = track.whitened(up, sound)
        normal += white.T @ white
    covariance = inverted(normal[:-1, :-1])[0]
    mean = covariance @ normal[:-1, -1]
    strength, directions = np.linalg.eigh(covariance)
    steps = np.sqrt(np.maximum(strength, 0.0)) * rng.standard_normal(size)
    return mean + directions @ steps, float(mean[-1])


def _log_likely(off: Array) -> Array:
    """Return the log of how likely numbers this many sigmas off are, bad ones among them."""
    sound = np.log(1 - BAD) - off**2 / 2
    return np.asarray(np.logaddexp(sound, np.log(BAD / WIDE) - (off / WIDE) ** 2 / 2))


def _good(off: Array, rng: np.random.Generator) -> Flags:
    """Draw which pointings are no bad ones."""
    odds = np.log((1 - BAD) * WIDE / BAD) - (off**2 - (off / WIDE) ** 2) / 2
    return np.asarray(rng.random(len(off)) < expit(odds))


def _path(likelier: Array, rng: np.random.Generator) -> Codes:
    """Draw the level of the edge in each column of azimuth, forward filtered, backward sampled.

    `likelier` (columns, levels) holds the log of how likely the readings of a column are with
    its edge on a level. Climbing has the price that it has where the best path is looked for.
    """
    columns, levels = likelier.shape
    step = np.abs(np.arange(levels)[:, None] - np.arange(levels))
    climb = np.exp(-CLIMB * step)
    climb /= climb.sum(axis=1, keepdims=True)
    own = np.exp(likelier - likelier.max(axis=1, keepdims=True))
    forward = np.empty_like(own)
    before = np.full(levels, 1 / levels)
    for n in range(columns):
        forward[n] = before * own[n]
        forward[n] /= forward[n].sum()
        before = forward[n] @ climb
    path = np.empty(columns, int)
    chance = forward[-1]
    for n in reversed(range(columns)):
        path[n] = np.searchsorted(chance.cumsum(), rng.random() * chance.sum())
        if n > 0:
            chance = forward[n - 1] * climb[:, path[n]]
    return path
