"""Terms picked automatically: what a program does that tries a long list and keeps the best.

The list holds every harmonic of azimuth and elevation and every product of the two, in
each result. Terms are added one by one, always the one that lowers the rms
most. It stands here to be judged: picked anew without the readings that it
is to predict, it shows what picking costs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.effects.base import Circumstances

#: Multiples of azimuth and of elevation in the list.
MOST = 8
#: A term must keep this share of its length beside those picked before it.
NEW = 1e-3


def listed(at: Circumstances) -> Array:
    """Return all shapes on the list at n pointings, shape (n, K)."""
    turns = np.arange(1, MOST + 1)
    around = np.concatenate([np.sin(turns * at.az[:, None]), np.cos(turns * at.az[:, None])], 1)
    up = np.concatenate([np.sin(turns * at.el[:, None]), np.cos(turns * at.el[:, None])], 1)
    both = (around[:, :, None] * up[:, None, :]).reshape(len(at), -1)
    return np.concatenate([around, up, both], axis=1)


def columns(at: Circumstances, row: NDArray[np.intp], is_y: NDArray[np.bool_]) -> Array:
    """Return the terms in azimuth, in cross-elevation and in elevation, shape (m, 3 K)."""
    shapes = listed(at)[row]
    results = (np.cos(at.axes.el) * at.side)[row] * ~is_y, ~is_y * 1.0, is_y * 1.0
    return np.concatenate([shapes * one[:, None] for one in results], axis=1)


def pick(model: Array, terms: Array, value: Array, count: int) -> list[int]:
    """Return which terms (m, K) lower the rms most beside a model (m, p), one after another."""
    basis, _, _ = np.linalg.svd(
        model / np.maximum(np.linalg.norm(model, axis=0), 1e-300), full_matrices=False
    )
    left = value - basis @ (basis.T @ value)
    terms = terms / np.maximum(np.linalg.norm(terms, axis=0), 1e-300)
    terms = terms - basis @ (basis.T @ terms)
    found: list[int] = []
    for _ in range(min(count, len(value) - basis.shape[1] - 1)):
        length = np.linalg.norm(terms, axis=0)
        drop = np.where(length > NEW, np.abs(terms.T @ left) / np.maximum(length, NEW), 0.0)
        best = int(np.argmax(drop))
        if drop[best] == 0:
            break
        found.append(best)
        own = terms[:, best] / length[best]
        left = left - own * (own @ left)
        terms = terms - np.outer(own, own @ terms)
    return found
