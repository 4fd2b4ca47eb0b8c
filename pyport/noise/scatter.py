"""Scatter: heavy tails, and how the scatter grows with what the recordings tell.

Both are read off standardised residuals. Tails are Student's t, its degrees of freedom averaged
over what the residuals allow (Lange, Little & Taylor 1989, JASA 84, 881), or normal with some
gross errors (Tukey 1960), whichever is likelier. The variance is a
log-linear function of elevation, azimuth, session, time and wind, each shrunk as its own
likelihood asks for (Harvey 1976, Econometrica 44, 461; MacKay 1992, Neural Comp. 4, 415).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from pyport.angles import Array
from pyport.effects.circumstances import mostly_known
from pyport.recordings.schema import Recordings, Stack, group
from pyport.thresholds import ENOUGH_SQUARES, LEAST_GROSS, MOST_GROSS

#: Degrees of freedom of Student's t that are weighed against each other; the last is normal.
DEGREES = np.array([2.0, 3.0, 4.0, 6.0, 10.0, 20.0, 50.0, np.inf])
#: Standardised deviations below this are rounding: there is nothing to estimate.
NOTHING = 1e-6
#: Bumps in time, and turns of azimuth, that a variance may follow.
BUMPS, TURNS = 10, 2
#: Rounds of scoring; a scale that changes by less than this share has settled.
ROUNDS, SETTLED = 12, 1e-3
#: A group of the variance function whose coefficients scatter by less than this is left out:
#: it changes weights by less than two per cent.
FLAT = 0.02
#: The log-variance may move by no more than this either way: a factor of 20 in scatter.
MOST = 6.0
#: Terms added to the recorded errors that are weighed, over the median recorded variance.
ADDED = np.array([0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0])


@dataclass(frozen=True)
class Tails:
    """The distribution of deviations of unit scale.

    Attributes
    ----------
    inverse
        One over the degrees of freedom of Student's t; zero is normal.
    gross, width
        Share of gross errors, and their scale; with any of them the others are normal.
    """

    inverse: float = 0.0
    gross: float = 0.0
    width: float = 1.0

    def weights(self, deviation: Array) -> Array:
        """Return the weight of each standardised deviation: one at zero, less further out."""
        if self.gross > 0:
            sound = self._sound(deviation)
            return np.asarray(sound + (1 - sound) / self.width**2)
        return np.asarray(1 / (1 + self.inverse * deviation**2))

    def slope(self, deviation: Array) -> Array:
        """Return the derivative of weight times deviation."""
        if self.gross > 0:
            sound, more = self._sound(deviation), 1 - 1 / self.width**2
            return self.weights(deviation) - deviation**2 * more**2 * sound * (1 - sound)
        square = self.inverse * deviation**2
        return np.asarray((1 - square) / (1 + square) ** 2)

    def _sound(self, deviation: Array) -> Array:
        """Return the probability that each deviation is no gross error."""
        more = deviation**2 * (1 - 1 / self.width**2) / 2
        odds = np.log(self.gross / (1 - self.gross) / self.width) + np.minimum(more, 700)
        return np.asarray(1 / (1 + np.exp(odds)))


def tails(deviation: Array) -> tuple[Tails, float]:
    """Return the tails of deviations (n,) and their scale.

    Each number of degrees of freedom has the scale that suits it best; their inverses are
    averaged as likely as each is, so that few deviations do not choose between extremes.
    """
    if float(np.abs(deviation).max(initial=0.0)) < NOTHING:
        return Tails(), 1.0
    scale = np.ones(len(DEGREES))
    likelihood = np.empty(len(DEGREES))
    start = float(np.median(np.abs(deviation)) / 0.6745) or 1.0
    for n, degrees in enumerate(DEGREES):
        if np.isinf(degrees):
            scale[n] = float(np.sqrt(np.mean(deviation**2))) or 1.0
            one = -0.5 * np.log(2 * np.pi) - 0.5 * (deviation / scale[n]) ** 2
        else:
            scale[n] = _scale(deviation, degrees, start)
            square = (deviation / scale[n]) ** 2 / degrees
            constant = gammaln((degrees + 1) / 2) - gammaln(degrees / 2)
            one = constant - 0.5 * np.log(np.pi * degrees) - (degrees + 1) / 2 * np.log1p(square)
        likelihood[n] = float(one.sum()) - len(deviation) * np.log(scale[n])
    mixed, size, among = _gross_errors(deviation, start)
    # One number more than Student's t has: the share of gross errors and their scale.
    if mixed.gross < MOST_GROSS and among - 0.5 * np.log(len(deviation)) > likelihood.max():
        return mixed, size
    chance = np.exp(likelihood - likelihood.max())
    chance /= chance.sum()
    inverse = float(chance @ (1 / DEGREES))
    if inverse < 1 / DEGREES[-2] / 2:
        return Tails(), float(scale[-1])
    return Tails(inverse), _scale(deviation, 1 / inverse, start)


def _gross_errors(deviation: Array, scale: float) -> tuple[Tails, float, float]:
    """Return normal deviations with gross errors among them, their scale and log-likelihood."""
    gross, wide = 0.05, 10.0 * scale
    square = deviation**2
    for _ in range(100):
        sound = np.log1p(-gross) - np.log(scale) - square / (2 * scale**2)
        other = np.log(gross) - np.log(wide) - square / (2 * wide**2)
        total = np.logaddexp(sound, other)
        share = np.exp(sound - total)
        new = float(np.sqrt(share @ square / max(float(share.sum()), 1e-300)))
        gross = float(np.clip((1 - share).mean(), 1e-6, MOST_GROSS))
        wide = float(np.sqrt((1 - share) @ square / max(float((1 - share).sum()), 1e-300)))
        done = abs(new - scale) <= SETTLED * scale
        scale = max(new, 1e-300)
        wide = max(wide, LEAST_GROSS * scale)
        if done:
            break
    likelihood = float(total.sum()) - 0.5 * np.log(2 * np.pi) * len(deviation)
    return Tails(0.0, gross, wide / scale), scale, likelihood


def _scale(deviation: Array, degrees: float, scale: float) -> float:
    """Return the likeliest scale of Student's t."""
    for _ in range(50):
        weight = (degrees + 1) / (degrees + (deviation / scale) ** 2)
        new = float(np.sqrt(np.mean(weight * deviation**2)))
        if abs(new - scale) <= SETTLED * scale:
            return new
        scale = max(new, 1e-300)
    return scale


def spread(tails: Tails, unit: Array) -> float:
    """Return the variance, over the square of the scale, that weighted least squares must assume.

    Coefficients of an M-estimate scatter by E[psi^2] / E[psi']^2 where the weights' own
    least squares would say 1 / E[w] (Huber 1981, Robust Statistics, section 7.6); `unit` (n,)
    are the deviations over their scale.
    """
    weight = tails.weights(unit)
    slope = max(float(tails.slope(unit).mean()), 0.1)
    return float(weight.mean()) * float((weight**2 * unit**2).mean()) / slope**2


@dataclass(frozen=True)
class Driver:
    """Something that the variance may follow: its name, and its columns for each row (n, k)."""

    name: str
    columns: Array


def drivers(recordings: Recordings) -> tuple[Driver, ...]:
    """Return what the scatter of these recordings may follow, centred and scaled to unity."""
    at = recordings.at
    found = [Driver("elevation", -np.log(np.maximum(np.sin(at.el), 0.02))[:, None])]
    turns = [f(k * at.az) for k in range(1, TURNS + 1) for f in (np.cos, np.sin)]
    found.append(Driver("azimuth", np.stack(turns, axis=1)))
    session, names = group(recordings, ("session",))
    if len(names) > 1:
        found.append(Driver("session", (session[:, None] == np.arange(len(names))).astype(float)))
    time = at.times
    if time is not None and np.ptp(time) > 0:
        rank = np.argsort(np.argsort(time, kind="stable"), kind="stable") / max(len(time), 1)
        centres = np.linspace(0, 1, BUMPS)
        bumps = np.exp(-0.5 * ((rank[:, None] - centres) * (BUMPS - 1)) ** 2)
        found.append(Driver("time", bumps))
    if "wind_speed_m_s" in at:
        wind = np.asarray(at.column("wind_speed_m_s"), float)
        if mostly_known(wind):
            usual = np.nanmean(wind)
            found.append(Driver("wind", np.where(np.isfinite(wind), wind, usual)[:, None]))
    return tuple(
        Driver(one.name, _standardised(one.columns)) for one in found if np.ptp(one.columns) > 0
    )


def _standardised(columns: Array) -> Array:
    centred = columns - columns.mean(axis=0)
    size = float(np.sqrt((centred**2).sum(axis=1).mean()))
    return centred / max(size, 1e-300)


def variance_function(
    deviation: Array, weight: Array, some: Sequence[Array], of: NDArray[np.bool_]
) -> Array:
    """Return the log-variance of each reading (m,), zero on average over the deviations.

    Parameters
    ----------
    deviation, weight
        Standardised deviations (n,) of some readings and their robust weights.
    some
        Columns of each driver at all readings, (m, k).
    of
        Which readings the deviations are of, shape (m,).
    """
    if len(deviation) < ENOUGH_SQUARES or not some:
        return np.zeros(len(of))
    square = weight * deviation**2
    every = np.concatenate([np.ones((len(of), 1)), *some], axis=1)
    columns = every[of]
    kind = np.repeat(np.arange(len(some)), [one.shape[1] for one in some])
    values = np.zeros(columns.shape[1])
    values[0] = np.log(max(float(square.mean()), 1e-300))
    prior = np.full(len(some), 0.1)
    # A square about its mean has a variance of 2 for normal deviations.
    normal = columns.T @ columns / 2
    for _ in range(ROUNDS):
        log_variance = np.clip(columns @ values - values[0], -MOST, MOST) + values[0]
        working = np.clip(square * np.exp(-log_variance), 0, 20) - 1 + log_variance
        penalty = np.concatenate([[0.0], 1 / np.maximum(prior[kind], 1e-12)])
        covariance = np.linalg.inv(normal + np.diag(penalty))
        values = covariance @ (columns.T @ working / 2)
        own = values[1:]
        known = 1 - np.diag(covariance)[1:] * penalty[1:]
        for n in range(len(some)):
            one = kind == n
            prior[n] = float(own[one] @ own[one]) / max(float(known[one].sum()), 1e-6)
        prior = np.clip(prior, 1e-10, 10.0)
    share = [np.std(columns[:, 1:][:, kind == n] @ own[kind == n]) for n in range(len(some))]
    kept = np.concatenate([[False], np.array(share)[kind] > FLAT])
    log_variance = np.clip(every[:, kept] @ values[kept], -MOST, MOST)
    return np.asarray(log_variance - log_variance[of].mean())


def recorded(recordings: Recordings, data: Stack) -> Array | None:
    """Return the recorded variance of each reading over the median of its axis, shape (m,).

    None where fewer than half of the readings have an error that is above zero; the others
    count as usual.
    """
    sigma = data.spread(recordings.sigma_x, recordings.sigma_y)
    good = np.isfinite(sigma) & (sigma > 0)
    if 2 * good.sum() < len(sigma) or np.ptp(sigma[good]) == 0:
        return None
    found = np.ones(len(sigma))
    for is_y in (False, True):
        of_axis = good & (data.is_y == is_y)
        if of_axis.any():
            found[of_axis] = (sigma[of_axis] / np.median(sigma[of_axis])) ** 2
    return found


def added_term(deviation: Array, variance: Array) -> float:
    """Return the likeliest variance to add to recorded ones, over their median.

    Deviations (n,) scatter by recorded variances (n,) and the added one together, times a scale.
    """
    lack = []
    for added in ADDED:
        total = variance + added
        lack.append(
            float(np.log(total).sum())
            + len(deviation) * float(np.log(max(float(np.mean(deviation**2 / total)), 1e-300)))
        )
    return float(ADDED[int(np.argmin(lack))])
