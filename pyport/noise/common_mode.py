"""Common mode: noise that all antennas of an array share from scan to scan.

A gust over the site or a late clock tick moves all antennas at once. An effect
that is common to all of them meets that noise undiminished, however many
antennas there are, so its evidence is divided by what the shared part adds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pyport.angles import Array, Codes
from pyport.least_squares.robust import most_different
from pyport.thresholds import ENOUGH_ANTENNAS, FEWEST, PER_SHAPE

#: A curve that keeps less of its length beside others is none of its own.
DIFFERENT = 1e-3
#: The median of the square of a standard normal number.
_MEDIAN_SQUARE = 0.4549364231195724


@dataclass(frozen=True)
class Excess:
    """By what factor scans scatter in common more than independent antennas would.

    `factor` is 1 where the antennas are independent or cannot be compared;
    `dof` says from how many deviations it is known.
    """

    factor: float = 1.0
    dof: float = np.inf


def excess(left: Array, weight: Array, shapes: Array, scan: Codes) -> Excess:
    """Return how much more scans scatter in common than independent antennas would.

    Parameters
    ----------
    left
        Whitened residuals of the pointings' means, shape (m,), zero where there is none.
    weight
        What one radian of a common offset does to each of them (one over its
        scatter), shape (m,), zero where there is none.
    shapes
        Whitened columns of every candidate, shape (m, K).
    scan
        The scan of each, shape (m,).
    """
    there = weight > 0
    antennas = np.bincount(scan[there])
    total = np.bincount(scan[there], weight[there] ** 2)
    scans = np.flatnonzero(antennas >= ENOUGH_ANTENNAS)
    if len(scans) < FEWEST:
        return Excess()
    size = np.sqrt(total[scans])
    mean = np.bincount(scan[there], (left * weight)[there])[scans] / size
    drawn = np.stack(
        [np.bincount(scan[there], (c * weight)[there])[scans] for c in shapes.T], axis=1
    )
    curves = _directions(drawn / size[:, None], len(scans) // PER_SHAPE)
    rest = mean - curves @ (curves.T @ mean)
    spare = len(scans) - curves.shape[1]
    typical = float(np.median(rest**2)) / _MEDIAN_SQUARE * len(scans) / spare
    return Excess(max(1.0, typical), float(spare))


def _directions(curves: Array, room: int) -> Array:
    """Return up to `room` orthonormal directions that the curves span, the most different first."""
    length = np.linalg.norm(curves, axis=0)
    kept = length > 1e-9 * max(float(length.max(initial=0)), 1e-300)
    if not kept.any() or room == 0:
        return np.zeros((len(curves), 0))
    return most_different(curves[:, kept] / length[kept], room, DIFFERENT)
