"""Picking columns that differ: the few that draw most of what the many can."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array

#: Columns whose squared lengths differ by less than this share are equally different: the first
#: of them is picked, so that no rounding of one machine or another chooses.
TIE = 1e-6


def most_different(columns: Array, room: int, least: float) -> Array:
    """Return orthonormal directions, each of the column least like those before it.

    Gram and Schmidt with pivoting. The columns' products tell which to pick, so
    that they are read once and not once for each pick.

    `columns`: columns of about unit length, shape (n, k).
    `room`: no more directions than this.
    `least`: what must be left of a column's length for it to count as different.
    Returns shape (n, at most room).
    """
    room = min(room, *columns.shape)
    left = (columns**2).sum(axis=0)
    products = columns.T @ columns
    factor = np.zeros((room, columns.shape[1]))
    picks: list[int] = []
    for n in range(room):
        pick = int(np.argmax(left >= (1 - TIE) * left.max()))
        if left[pick] < least**2:
            break
        factor[n] = products[pick] - factor[:n, pick] @ factor[:n]
        factor[n] /= np.sqrt(left[pick])
        left = left - factor[n] ** 2
        picks.append(pick)
    return np.linalg.qr(columns[:, picks])[0]
