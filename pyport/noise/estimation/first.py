"""A first look at readings: robust weights, and columns that the noise must not contain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyport.angles import Array
from pyport.least_squares import robust
from pyport.least_squares.gram import spanned
from pyport.least_squares.robust import most_different
from pyport.noise.estimation.frame import Frame, floors_of
from pyport.noise.whitening import NO_WEIGHT
from pyport.thresholds import FIRST_REACH, PER_SHAPE

#: No reading has less weight than this: its deviation can still be computed from its whitened one.
LEAST = 2 * NO_WEIGHT


#: No more shapes than this: the most different ones draw what the others can.
MOST_SHAPES = 30


#: A shape that keeps less of its length beside those taken out is none of its own.
DIFFERENT = 0.05


#: A column whose neighbours in time are this much alike is slow: a drift could pass for it.
SLOW = 0.9


#: So many of the slow ones are taken out: more would leave nothing to tell a drift by.
MOST_SLOW = 8


def taken_out(design: Array, given: Frame, shapes: Sequence[Array] | None) -> list[Array]:
    """Return for each series the columns that its noise must not contain: see `estimate`."""
    columns = []
    for n, part in enumerate(given.parts):
        # What never changes is no drift, whether the model has a constant or lacks one.
        own = np.concatenate([design[part.rows], np.ones((len(part.rows), 1))], axis=1)
        if shapes is None:
            own = spanned(own[:, own.any(axis=0)])[0]
        else:
            own = _rich(own, shapes[n], int(part.pointing.max()) + 1)
        columns.append(own)
    return columns


def fitted(value: Array, columns: Sequence[Array], given: Frame) -> tuple[Array, Array]:
    """Fit columns robustly to each series and return weights and residuals, shape (m,) each."""
    floors = floors_of(value, given)
    weights, residual = np.ones(len(value)), np.zeros(len(value))
    for own, part in zip(columns, given.parts, strict=True):
        weights[part.rows], residual[part.rows], _ = robust.weights(
            own, value[part.rows], FIRST_REACH, floors[part.is_y]
        )
    return np.maximum(weights, LEAST), residual


def _rich(base: Array, shapes: Array, pointings: int) -> Array:
    """Return the base and the main directions of what the candidates could add to it.

    The directions come from the geometry alone, never from the data, so that
    the noise is not whittled down by the search. The result is orthonormal.
    """
    base = base[:, np.any(base != 0, axis=0)]
    orthonormal = spanned(base)[0]
    room = max(0, min(pointings // PER_SHAPE, pointings // 2 - orthonormal.shape[1]))
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
