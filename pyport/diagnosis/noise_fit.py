"""Fitting the noise: robust, with every shape that physics could give taken out first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.noise import (
    DRIFT_GAIN,
    ENOUGH_FOR_DRIFT,
    TUKEY,
    Noise,
    Series,
    by_pointing,
    decorrelate,
)
from pyport.fitting import robust
from pyport.fitting.stacking import Codes

#: Pointings for each shape that may be taken out before the noise is read off.
POINTINGS_PER_SHAPE = 4
#: The array's usual noise counts as this many deviations where an antenna has few of its own.
PRIOR_DOF = 6.0
#: Antennas from which on there is a usual noise.
ENOUGH_ANTENNAS = 5


def fit(
    value: Array, base: Array, shapes: Array, parts: Sequence[Series]
) -> tuple[list[Noise], Array]:
    """Fit the noise of each series.

    Parameters
    ----------
    value
        The data [rad], shape (m,).
    base
        Columns of the model that is always fitted, shape (m, p); columns of
        other antennas may be zero in a series.
    shapes
        Columns of every candidate, shape (m, K): the noise must not contain what they explain.
    parts
        The series.

    Returns
    -------
    noises
        One for each series.
    weights
        Robust weights of the readings, shape (m,).
    """
    weights = np.ones(len(value))
    noises = []
    of_axis = np.zeros(len(value), bool)
    for part in parts:
        of_axis[part.rows] = part.is_y
    floors = {is_y: robust.rounding(value[of_axis == is_y]) for is_y in (False, True)}
    for part in parts:
        columns = _rich(base[part.rows], shapes[part.rows], int(part.pointing.max()) + 1)
        floor = floors[part.is_y]
        weights[part.rows], residual = robust.weights(columns, value[part.rows], TUKEY, floor)
        noises.append(_fit_series(value, columns, weights, residual, part, floor))
    return _moderated(noises, parts), weights


def _moderated(noises: list[Noise], parts: Sequence[Series]) -> list[Noise]:
    """Draw the noise of antennas with few recordings toward what is usual in the array.

    A scale from few deviations is a rough one, and one that comes out small by
    chance makes its antenna outvote all others. The variances are averaged
    with the array's median, which counts as `PRIOR_DOF` deviations (Smyth 2004).
    """
    found = list(noises)
    for is_y in (False, True):
        own = [n for n, part in enumerate(parts) if part.is_y == is_y]
        if len(own) < ENOUGH_ANTENNAS:
            continue
        usual = float(np.median([noises[n].floor for n in own]))
        for n in own:
            noise = noises[n]
            shrunk = (noise.dof * noise.floor**2 + PRIOR_DOF * usual**2) / (noise.dof + PRIOR_DOF)
            if noise.floor > usual or noise.floor == 0:
                continue
            factor = float(np.sqrt(shrunk)) / noise.floor
            found[n] = replace(
                noise,
                within=noise.within * factor,
                between=noise.between * factor,
                drift=noise.drift * factor,
                dof=noise.dof + PRIOR_DOF,
            )
    return found


def _rich(base: Array, shapes: Array, pointings: int) -> Array:
    """Return the base and the main directions of what the candidates could add to it.

    The directions come from the geometry alone, never from the data, so that
    the noise is not whittled down by the search.
    """
    base = base[:, np.any(base != 0, axis=0)]
    room = max(0, min(pointings // POINTINGS_PER_SHAPE, pointings // 2 - base.shape[1]))
    orthonormal = np.linalg.qr(base)[0] if base.shape[1] else base
    length = np.linalg.norm(shapes, axis=0)
    new = shapes - orthonormal @ (orthonormal.T @ shapes)
    left = np.linalg.norm(new, axis=0)
    new = new[:, left > 1e-3 * np.maximum(length, 1e-300)]
    new = new / np.linalg.norm(new, axis=0)
    if room == 0 or new.shape[1] == 0:
        return base
    return np.concatenate([base, _most_different(new, room)], axis=1)


def _most_different(columns: Array, room: int) -> Array:
    """Return up to `room` orthonormal directions, each from the column least like those before."""
    from scipy.linalg import qr

    directions, triangle, _ = qr(columns, mode="economic", pivoting=True)
    kept = int((np.abs(np.diag(triangle)) > 0.05).sum())
    return directions[:, : min(room, kept)]


def _fit_series(
    value: Array, columns: Array, weights: Array, residual: Array, part: Series, floor: float
) -> Noise:
    """Fit within, between and drift of one series by restricted maximum likelihood."""
    count = np.bincount(part.pointing)
    weight = weights[part.rows]
    within = _within(residual, weight, part, count, floor)
    data = np.concatenate([columns, value[part.rows][:, None]], axis=1)
    pointings = len(count)
    dof = max(1.0, pointings - np.linalg.matrix_rank(columns))
    start = max(robust.scale(residual, floor), floor, 1e-12) * np.sqrt(pointings / dof)

    def lack(between: float, drift: float = 0.0, time_s: float | None = None) -> float:
        return _restricted(data, weight, part, Noise(within, between, drift, time_s))

    from scipy.optimize import minimize, minimize_scalar

    low = 0.05 * max(floor, 1e-3 * start)
    white = minimize_scalar(
        lambda log: lack(np.exp(log)), bounds=(np.log(low), np.log(5 * start)), method="bounded"
    )
    noise = Noise(within, float(np.exp(white.x)), dof=dof, how=_how(count))
    if part.time is None or dof < ENOUGH_FOR_DRIFT:
        return noise
    gaps = np.diff(part.time)
    usual = float(np.median(gaps[gaps < 1e8])) or 1.0
    best = min(
        (
            minimize(
                lambda p: lack(*np.exp(np.clip(p, -60, 60))),
                [np.log(noise.between / 1.5), np.log(noise.between / 1.5), np.log(usual * steps)],
                method="Nelder-Mead",
                options={"xatol": 0.02, "fatol": 0.05, "maxiter": 150},
            )
            for steps in (5.0, 50.0)
        ),
        key=lambda result: result.fun,
    )
    if white.fun - best.fun < DRIFT_GAIN:
        return noise
    between, drift, time_s = np.exp(best.x)
    return Noise(within, float(between), float(drift), float(time_s), dof, _how(count))


def _how(count: Codes) -> str:
    return "replicates" if count.max() > 1 else "reml"


def _within(residual: Array, weight: Array, part: Series, count: Codes, floor: float) -> float:
    """Return the scatter of readings about their pointing's mean; zero where each stands alone."""
    spare = (count - 1)[count > 1].sum()
    if spare < 3:
        return 0.0
    total = np.maximum(np.bincount(part.pointing, weight), 1e-12)
    mean = np.bincount(part.pointing, weight * residual) / total
    deviation = residual - mean[part.pointing]
    used = (count[part.pointing] > 1) & (weight > 0.5)
    share = np.sqrt(
        used.sum() / max(1.0, spare * used.sum() / max(1, (count[part.pointing] > 1).sum()))
    )
    return max(robust.scale(deviation[used]) * float(share), floor / 2, 1e-12)


def _restricted(data: Array, weights: Array, part: Series, noise: Noise) -> float:
    """Return minus twice the restricted log-likelihood of the pointings' means."""
    means, variance, _ = by_pointing(data, weights, part, noise)
    white = decorrelate(means, variance, part, noise)
    log_det = _log_determinant(variance, part, noise)
    gram = white.T @ white
    design, right = gram[:-1, :-1], gram[:-1, -1]
    scale = 1 / np.sqrt(np.maximum(np.diag(design), 1e-300))
    eigenvalues, vectors = np.linalg.eigh(design * np.outer(scale, scale))
    good = eigenvalues > 1e-9 * eigenvalues[-1] if len(eigenvalues) else eigenvalues > 0
    projected = (vectors[:, good].T @ (scale * right)) / np.sqrt(eigenvalues[good])
    misfit = gram[-1, -1] - projected @ projected
    return float(log_det + np.log(eigenvalues[good]).sum() - 2 * np.log(scale).sum() + misfit)


def _log_determinant(variance: Array, part: Series, noise: Noise) -> float:
    """Return the logarithm of the determinant of the means' covariance."""
    if noise.drift == 0 or noise.time_s is None or part.time is None:
        return float(np.log(variance).sum())
    from celerite2 import driver

    n = len(variance)
    d, w = np.empty(n), np.empty((n, 1))
    power, ones = noise.drift**2, np.ones((n, 1))
    driver.factor(
        part.time, np.array([1 / noise.time_s]), variance + power, power * ones, ones, d, w
    )
    return float(np.log(d).sum())
