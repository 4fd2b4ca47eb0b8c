"""The rms that is printed, and what it is of: one definition for every command.

Per axis it is the root of the mean square of what is left in that axis. On the sky it is the root
of the mean of x^2 + y^2 over pointings that measured both axes, the square root of two larger
where both axes scatter alike. Excluded outliers do not count. Both divide by the number of offsets
or pointings: nothing is taken off for the fitted terms, as TPOINT's sky rms has it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.effects.base import Circumstances
from pyport.recordings.schema import Stack

PER_AXIS = "root mean square per axis, outliers excluded, not reduced for fitted terms"
ON_SKY = (
    "root of the mean of x^2 + y^2 over pointings with both axes, outliers excluded, not reduced "
    "for fitted terms (as TPOINT's sky rms)"
)


def largest_offset(data: Stack, at: Circumstances) -> float:
    """Return the largest offset of either axis as it reads the telescope [rad].

    Of the first axis that is x over the cosine of the second: x / cos E.
    """
    cosine = np.cos(at.axes.el) * at.side
    reading = np.where(data.is_y, 1.0, np.maximum(cosine[data.row], 1e-3))
    return float((np.abs(data.value) / reading).max(initial=0.0))


def axis_rms(
    data: Stack, residual: Array, used: NDArray[np.bool_], *, is_y: bool
) -> tuple[float, int] | None:
    """Return the rms of one axis [rad] and over how many offsets; None where there are none."""
    rows = used & (data.is_y == is_y)
    if not rows.any():
        return None
    return float(np.sqrt(np.mean(residual[rows] ** 2))), int(rows.sum())


def sky_rms(data: Stack, residual: Array, used: NDArray[np.bool_]) -> tuple[float, int] | None:
    """Return the rms on the sky [rad] and over how many pointings; None where none has both axes.

    `data`: the m measured numbers.
    `residual`, `used`: what is left of each [rad], and whether it is no outlier, shape (m,).
    """
    across = np.flatnonzero(used & ~data.is_y)
    along = np.flatnonzero(used & data.is_y)
    both, x, y = np.intersect1d(data.row[across], data.row[along], return_indices=True)
    if len(both) == 0:
        return None
    squares = residual[across[x]] ** 2 + residual[along[y]] ** 2
    return float(np.sqrt(squares.mean())), len(both)
