"""What a scan should show: each antenna's offset as the scans around it tell it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array

#: How far along hour angle scans still tell of each other (one sigma) [h].
WIDTH_H = 1.5

#: A fit pulls in scans of a track within this many of its sigmas; the rest fade out.
FADE = 2.0

#: Pull towards the track's median: for its value, slope, bend and direction's half-difference.
PULL = np.diag([1e-3, 0.02, 0.5, 1e-2])

#: An offset that is alone in its hour angle tells nothing; this many weigh enough.
ENOUGH = 4


def expected_offsets(
    offset: Array,
    weight: Array,
    *,
    hour_angle_h: Array,
    direction: Array,
    scan: NDArray[Any],
    stretch: NDArray[Any],
) -> Array:
    """Return each antenna's offset as the other scans lead to expect it.

    A local parabola in hour angle and a half-difference between forward and
    reverse, fitted robustly to the scans of the same stretch (between two
    settings of the offsets), the scan itself and its other channel left out.

    `offset`, `weight`: offsets [arcmin] and how far each is trusted (0 to 1), shape (rows,
      antennas).
    `hour_angle_h`, `direction`, `scan`, `stretch`: of each row, shape (rows,).
    Returns shape (rows, antennas) [arcmin]; NaN where too few scans are trusted.
    """
    apart_h = hour_angle_h[None, :] - hour_angle_h[:, None]
    tells = (scan[None, :] != scan[:, None]) & (stretch[None, :] == stretch[:, None])
    # (expected row, telling row, antenna)
    base = (np.exp(-0.5 * (apart_h / WIDTH_H) ** 2) * tells)[:, :, None] * weight[None]
    y = np.nan_to_num(offset)
    turned = np.broadcast_to(direction[None, :], apart_h.shape)
    terms = np.stack([np.ones_like(apart_h), apart_h, apart_h**2, turned], axis=2)
    start = np.zeros((*base.shape[::2], 4))
    start[..., 0] = _medians(offset, base > 0)
    fit = start
    for turn in range(12):
        apart = y[None] - np.einsum("erk,eak->era", terms, fit)
        spread = 1.2 if turn >= 4 else np.maximum(1.0, 1.48 * _median_of(np.abs(apart), base > 0))
        fading = base / (1 + (apart / (FADE * spread)) ** 2) ** 2
        normal = np.einsum("era,erk,erl->eakl", fading, terms, terms) + PULL
        right = np.einsum("era,erk,ra->eak", fading, terms, y) + start @ PULL
        fit = np.linalg.solve(normal, right[..., None])[..., 0]
    here = fit[..., 0] + fit[..., 3] * direction[:, None]
    return np.where((base > 0).sum(axis=1) >= ENOUGH, here, np.nan)


def _medians(offset: Array, known: NDArray[np.bool_]) -> Array:
    """Return each antenna's median over the rows known to each row, 0 where none is."""
    return np.nan_to_num(_median_of(np.broadcast_to(offset, known.shape), known)[:, 0])


def _median_of(values: Array, known: NDArray[np.bool_]) -> Array:
    """Return the median along the telling rows, kept as an axis of length 1."""
    with np.errstate(all="ignore"):
        masked = np.ma.masked_array(values, ~known)
        middle = np.ma.median(masked, axis=1, keepdims=True)
    return np.ma.filled(middle, np.nan)
