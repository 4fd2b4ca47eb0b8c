"""The estimate of the covariance: scatter, tails, drift, sessions and sources, in turns.

Every command that fits anything fits it under this covariance. A search also takes out of the
noise what its candidates could explain; a final fit does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import Array
from pyport.least_squares import robust
from pyport.least_squares.gram import spanned
from pyport.least_squares.robust import Refit
from pyport.noise import scatter
from pyport.noise.covariance import Covariance, both_axes
from pyport.noise.estimation import departures
from pyport.noise.estimation.drift import (
    BEYOND,
    Draft,
    Grid,
    beside,
    draft,
    grid_of,
    likeliest,
    within_reach,
)
from pyport.noise.estimation.first import LEAST, fitted, taken_out
from pyport.noise.estimation.frame import Frame, floors_of
from pyport.noise.estimation.likelihood import Departing
from pyport.noise.estimation.pooling import pooled
from pyport.noise.series import Noise, Possible, Series
from pyport.thresholds import (
    ENOUGH_SQUARES,
    FEWEST,
    FIRST_REACH,
    SIGNIFICANT,
)

#: Directions of the departures that add less than this to the variance of unit scatter do not
#: matter beside a drift.
FAINT = 0.03
#: Turns in which departures, drift and scatter are estimated beside each other.
TURNS = 2


def estimate(
    value: Array,
    design: Array,
    given: Frame,
    shapes: Sequence[Array] | None = None,
    like: Covariance | None = None,
    *,
    averaged: bool = True,
    turns: int = TURNS,
) -> Covariance:
    """Estimate the covariance of readings about a model.

    Parameters
    ----------
    value
        The data [rad], shape (m,).
    design
        Columns that are always fitted, shape (m, p); those of other antennas may be zero in a
        series.
    given
        The frame of the recordings.
    shapes
        For each series the columns of what might be found in it, in the order of its rows: the
        noise must not contain what they explain. None for a final fit.
    like
        A covariance whose weights, precision, tails and coupling hold: only how much there is
        of scatter, drift and departures is estimated, so that likelihoods can be compared.
    averaged
        Whether drifts stand as likely as each is, or the likeliest alone.
    turns
        In which departures, drift and scatter are estimated beside each other.
    """
    parts = given.parts
    floors = floors_of(value, given)
    columns, residual = taken_out(design, given, shapes), np.zeros(len(value))
    # Beside known weights residuals tell how repeats scatter, and nothing where there are none.
    if like is None or not all(part.alone for part in parts):
        weights, residual = fitted(value, columns, given)
    covariance = like or _white(given, weights, residual, floors)
    # Noise beside everything that could be found is noise beside the model and those columns.
    wide = design if shapes is None else _joint(columns, parts)
    grid = grid_of(parts)
    # What is improbable counts in an average alone, and only the last turn's is given.
    reach = [within_reach(grid)] * turns
    if averaged:
        reach[-1] = BEYOND
    starts: Sequence[int | None] = [None] * len(parts) if like is None else like.starts
    drifts = _Drifts(value, design, residual, columns, given, floors, grid)
    for beyond in reach:
        found = departures.estimate(covariance, value, wide, given.possible)
        covariance = replace(covariance, departures=found, possible=given.possible)
        drafts = [drifts.drafted(covariance, beyond, n, start) for n, start in enumerate(starts)]
        starts = [one.best for one in drafts]
        noises = drifts.noises(drafts, covariance.weights, averaged=averaged)
        covariance = replace(covariance, noises=tuple(noises), starts=tuple(starts))
        if like is None:
            covariance = _scattered(covariance, value, wide, given, floors)
        else:
            covariance = _with_tails(covariance, like)
    found = departures.estimate(covariance, value, wide, given.possible)
    return replace(covariance, departures=found)


@dataclass(frozen=True)
class _Drifts:
    """What the drift of each series is estimated from.

    The data and the residuals of readings [rad], shape (m,), the columns fitted to all, (m, p), and
    in each series, and the drifts that are tried.
    """

    value: Array
    design: Array
    residual: Array
    columns: Sequence[Array]
    given: Frame
    floors: dict[bool, float]
    grid: Grid

    def drafted(self, covariance: Covariance, beyond: float, n: int, start: int | None) -> Draft:
        """Return how likely each drift of a series is: of its number and the best one known."""
        part = self.given.parts[n]
        rows = part.rows
        return draft(
            self.value[rows],
            self.columns[n],
            _departing(covariance, self.given.possible, n),
            covariance.weights[rows],
            covariance.precision[rows],
            self.residual[rows],
            part,
            self.grid,
            self.floors[part.is_y],
            start,
            beyond,
        )

    def noises(self, drafts: Sequence[Draft], weights: Array, *, averaged: bool) -> list[Noise]:
        """Return the noise of each series, every drift as likely as it is, or the likeliest.

        `weights`: robust ones of all readings, shape (m,).
        """
        parts = self.given.parts
        chances = [beside(drafts, parts, n) for n in range(len(parts))]
        if not averaged:
            chances = [likeliest(one) for one in chances]
        noises = [
            replace(one.noise(chance, self.floors[part.is_y]), centred=self.given.centred)
            for one, chance, part in zip(drafts, chances, parts, strict=True)
        ]
        return pooled(noises, parts, self.value, self.design, weights)


def _white(given: Frame, weights: Array, residual: Array, floors: dict[bool, float]) -> Covariance:
    """Return the covariance of scatter alone, as robust residuals and recorded errors show it."""
    noises = []
    for part in given.parts:
        own, weight = residual[part.rows], weights[part.rows]
        size = float(np.sqrt((weight * own**2).sum() / max(float(weight.sum()), 1.0)))
        noises.append(Noise(0.0, max(size, floors[part.is_y], 1e-14), dof=float(len(own))))
    white = Covariance(tuple(given.parts), tuple(noises), weights, np.ones(len(weights)))
    return white if given.recorded is None else _by_recorded(white, residual, given.recorded)


def _by_recorded(covariance: Covariance, residual: Array, variance: Array) -> Covariance:
    """Weight readings by their recorded errors, as far as these tell the scatter."""
    precision = np.ones(len(variance))
    for part in covariance.parts:
        rows = part.rows[covariance.weights[part.rows] > 0.5]
        if len(rows) > 2:
            added = scatter.added_term(residual[rows], variance[rows])
            total = variance[part.rows] + added
            precision[part.rows] = np.exp(np.mean(np.log(total))) / total
    return replace(covariance, precision=precision)


def _joint(columns: Sequence[Array], parts: Sequence[Series]) -> Array:
    """Return the columns of each series side by side, zero elsewhere; they span the design too."""
    wide = []
    for part, own in zip(parts, columns, strict=True):
        placed = np.zeros((sum(len(each.rows) for each in parts), own.shape[1]))
        placed[part.rows] = own
        wide.append(placed)
    return np.concatenate(wide, axis=1)


def _departing(covariance: Covariance, possible: Possible, n: int) -> Departing:
    """Return what departures do to a series, in units of its scatter and deviations."""
    noise = covariance.noises[n]
    sizes = possible.sizes(covariance.departures) / np.hypot(noise.within, noise.between)
    columns = possible.few[n].scaled(sizes)
    power, vectors = np.linalg.eigh(columns.products())
    return Departing(columns, vectors[:, power <= FAINT])


def _scattered(
    covariance: Covariance, value: Array, design: Array, given: Frame, floors: dict[bool, float]
) -> Covariance:
    """Estimate tails, the variance function and the axes' coupling from whitened residuals.

    Of the pointings that have one reading: means of several have other tails.
    """
    alone = replace(covariance, coupling={})
    white = alone.whiten(np.concatenate([design, value[:, None]], axis=1))
    left = _residual(white)[alone.means]
    weights, precision = covariance.weights.copy(), covariance.precision.copy()
    noises = []
    for part, noise in zip(covariance.parts, covariance.noises, strict=True):
        lone = part.lone
        rows = part.rows[lone]
        if len(rows) < FEWEST:
            noises.append(noise)
            continue
        # Deviations as they would be with full weight.
        deviation = left[rows] / np.sqrt(weights[rows])
        if np.abs(deviation).max() < scatter.NOTHING:
            noises.append(noise)
            continue
        shape, size = scatter.tails(deviation)
        log_variance = scatter.variance_function(
            deviation / size,
            shape.weights(deviation / size),
            [one.columns[part.rows] for one in given.drivers],
            lone,
        )
        if log_variance.any():
            deviation = deviation * np.exp(-log_variance[lone] / 2)
            shape, size = scatter.tails(deviation)
        unit = deviation / size
        weight = shape.weights(unit)
        was = float((left[rows] ** 2).mean())
        more = float(np.sqrt(size**2 * scatter.spread(shape, unit) / max(was, 1e-300)))
        usual = size**2 * float((weight * unit**2).mean())
        tail = float(np.sqrt(scatter.spread(shape, unit) * size**2 / max(usual, 1e-300)))
        between = float(np.hypot(noise.between, noise.within)) * more
        between = float(np.sqrt(max(between**2 - noise.within**2, floors[part.is_y] ** 2)))
        weights[rows] = np.maximum(weight, LEAST)
        precision[part.rows] *= np.exp(-log_variance)
        noises.append(replace(noise, between=between, tail=tail))
    new = replace(alone, noises=tuple(noises), weights=weights, precision=precision)
    return replace(new, coupling=_coupling(new.parts, left))


def _with_tails(covariance: Covariance, like: Covariance) -> Covariance:
    """Widen the scatter of each series by what the tails of another covariance ask for."""
    noises = tuple(
        replace(one, between=one.between * other.tail, tail=other.tail)
        for one, other in zip(covariance.noises, like.noises, strict=True)
    )
    return replace(covariance, noises=noises)


def _coupling(parts: Sequence[Series], left: Array) -> dict[str, float]:
    """Return the correlation of both axes' scatter by antenna, where it is certain.

    `left` (m,) holds whitened residuals; what lies beyond three sigmas counts as three.
    """
    found = {}
    for antenna in dict.fromkeys(part.antenna for part in parts):
        x, y = both_axes(parts, antenna)
        least = min((_rms(left[rows]) for rows in (x, y) if len(rows)), default=0.0)
        if len(x) < ENOUGH_SQUARES or least < scatter.NOTHING:
            continue
        one, other = (np.clip(left[rows] / max(_rms(left[rows]), 1e-300), -3, 3) for rows in (x, y))
        correlation = float((one * other).mean() / np.sqrt((one**2).mean() * (other**2).mean()))
        if abs(correlation) * np.sqrt(len(x)) > SIGNIFICANT:
            found[antenna] = float(np.clip(correlation, -0.95, 0.95))
    return found


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _residual(white: Array) -> Array:
    """Return what least squares leaves of the last column beside all others, shape (n,)."""
    design, data = white[:, :-1], white[:, -1]
    return Refit(design[:, design.any(axis=0)], data).residual(np.ones(len(data)))


def reweighed(covariance: Covariance, value: Array, model: Array, given: Frame) -> Covariance:
    """Return a covariance with the robust weights of readings (m,) beside a model's columns (m, p).

    For data whose noise is known and whose outliers are looked for anew.
    """
    weights = covariance.weights.copy()
    floors = floors_of(value, given)
    for part in covariance.parts:
        own = model[part.rows]
        weights[part.rows] = robust.weights(
            spanned(own[:, own.any(axis=0)])[0], value[part.rows], FIRST_REACH, floors[part.is_y]
        )[0]
    return replace(covariance, weights=weights)
