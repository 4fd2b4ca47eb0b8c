"""Fitting the noise: robust, with every shape that physics could give taken out first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.noise import APART, TUKEY, Noise, Series
from pyport.diagnosis.noise_drift import beside, draft, grid_of
from pyport.fitting import robust
from pyport.fitting.pivoting import most_different

#: Pointings for each shape that may be taken out before the noise is read off.
POINTINGS_PER_SHAPE = 4
#: No more shapes than this: the most different ones draw what the others can.
MOST_SHAPES = 80
#: A shape that keeps less of its length beside those taken out is none of its own.
DIFFERENT = 0.05
#: A column whose neighbours in time are this much alike is slow: a drift could pass for it.
SLOW = 0.9
#: So many of the slow ones are taken out: more would leave nothing to tell a drift by.
MOST_SLOW = 8
#: Sessions of so many pointings on average have their own constants taken out first.
POINTINGS_PER_SESSION = 12
#: The array's usual noise counts as this many deviations where an antenna has few of its own.
PRIOR_DOF = 6.0
#: Antennas from which on there is a usual noise.
ENOUGH_ANTENNAS = 5


def fit(
    value: Array, base: Array, shapes: Sequence[Array], parts: Sequence[Series]
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
        For each series the columns of every candidate that shows in it, in the order of its
        rows: the noise must not contain what they explain.
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
    floors = _floors(value, parts)
    grid = grid_of(parts)
    drafts = []
    for part, possible in zip(parts, shapes, strict=True):
        known = np.concatenate([base[part.rows], _of_sessions(part)], axis=1)
        columns = _rich(known, possible, int(part.pointing.max()) + 1)
        floor = floors[part.is_y]
        weights[part.rows], residual, _ = robust.weights(columns, value[part.rows], TUKEY, floor)
        given = value[part.rows], columns, weights[part.rows], residual
        drafts.append(draft(*given, part, grid, floor))
    noises = [
        one.noise(beside(drafts, parts, n), floors[parts[n].is_y]) for n, one in enumerate(drafts)
    ]
    return _moderated(noises, parts), weights


def weights(value: Array, model: Array, parts: Sequence[Series]) -> Array:
    """Return robust weights of the readings (m,) beside a model's columns (m, p), by series."""
    found = np.ones(len(value))
    floors = _floors(value, parts)
    for part in parts:
        own = model[part.rows]
        known = np.concatenate([own[:, own.any(axis=0)], _of_sessions(part)], axis=1)
        floor = floors[part.is_y]
        found[part.rows] = robust.weights(_orthonormal(known), value[part.rows], TUKEY, floor)[0]
    return found


def _floors(value: Array, parts: Sequence[Series]) -> dict[bool, float]:
    """Return the scatter that rounding makes in either axis [rad]."""
    of_axis = np.zeros(len(value), bool)
    for part in parts:
        of_axis[part.rows] = part.is_y
    return {is_y: robust.rounding(value[of_axis == is_y]) for is_y in (False, True)}


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
            more = float(np.sqrt(shrunk)) / noise.floor
            found[n] = replace(
                noise,
                within=noise.within * more,
                between=noise.between * more,
                drifts=tuple((amplitude * more, time) for amplitude, time in noise.drifts),
                dof=noise.dof + PRIOR_DOF,
            )
    return found


def _of_sessions(part: Series) -> Array:
    """Return a column for each session but the first.

    A drift must show within the sessions: from one to the next it could pass
    for anything that was moved in between.
    """
    if part.time is None:
        return np.zeros((len(part.rows), 0))
    session = np.concatenate([[0], np.cumsum(np.diff(part.time) > APART / 2)])[part.pointing]
    count = int(session.max())
    if (count + 1) * POINTINGS_PER_SESSION > len(part.time):
        return np.zeros((len(part.rows), 0))
    return (session[:, None] == np.arange(1, count + 1)).astype(float)


def _rich(base: Array, shapes: Array, pointings: int) -> Array:
    """Return the base and the main directions of what the candidates could add to it.

    The directions come from the geometry alone, never from the data, so that
    the noise is not whittled down by the search. The result is orthonormal.
    """
    base = base[:, np.any(base != 0, axis=0)]
    orthonormal = _orthonormal(base)
    room = max(0, min(pointings // POINTINGS_PER_SHAPE, pointings // 2 - orthonormal.shape[1]))
    new = shapes - orthonormal @ (orthonormal.T @ shapes)
    left = np.linalg.norm(new, axis=0)
    kept = left > 1e-3 * np.linalg.norm(shapes, axis=0)
    if room == 0 or not kept.any():
        return orthonormal
    new = new[:, kept] / left[kept]
    room = min(room, MOST_SHAPES)
    slow = np.einsum("nk,nk->k", new[1:], new[:-1]) > SLOW
    first = most_different(new[:, slow], min(room // 2, MOST_SLOW), DIFFERENT)
    rest = new[:, ~slow] - first @ (first.T @ new[:, ~slow])
    second = most_different(rest, room - first.shape[1], DIFFERENT)
    return np.concatenate([orthonormal, first, second], axis=1)


def _orthonormal(columns: Array) -> Array:
    """Return orthonormal directions that span the columns."""
    if columns.shape[1] == 0:
        return columns
    length = np.linalg.norm(columns, axis=0)
    directions, strength, _ = np.linalg.svd(columns / length, full_matrices=False)
    return np.asarray(directions[:, strength > 1e-9 * strength[0]])
