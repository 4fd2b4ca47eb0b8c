"""Common mode: noise that all antennas of an array share from scan to scan.

A gust over the site or a late clock tick moves all antennas at once. An effect
that is common to all of them meets that noise undiminished, however many
antennas there are, so its evidence is divided by what the shared part adds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import Array, Codes
from pyport.least_squares.gram import spanned
from pyport.thresholds import ENOUGH_ANTENNAS, FEWEST, PER_SHAPE

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


def excess(left: Array, weight: Array, explained: Sequence[Array], scan: Codes) -> Excess:
    """Return how much more scans scatter in common than independent antennas would.

    Beside whatever explains most of that: noise is what is left of the best explanation. Beside
    the model alone an effect of all antennas would be a noise that hides it.

    Parameters
    ----------
    left
        Whitened residuals of the pointings' means, shape (m,), zero where there is none.
    weight
        What one radian of a common offset does to each of them (one over its
        scatter), shape (m,), zero where there is none.
    explained
        Whitened columns of each candidate beside the model, shape (m, k).
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

    def in_common(values: Array) -> Array:
        return np.bincount(scan[there], (values * weight)[there])[scans] / size

    mean, least = in_common(left), Excess(np.inf)
    for columns in (np.zeros((len(left), 0)), *explained):
        drawn = [in_common(one) for one in columns.T]
        basis = spanned(np.stack([*drawn, np.zeros(len(scans))], axis=1)[:, : len(drawn)])[0]
        if basis.shape[1] > len(scans) // PER_SHAPE:
            continue
        rest, spare = mean - basis @ (basis.T @ mean), len(scans) - basis.shape[1]
        typical = float(np.median(rest**2)) / _MEDIAN_SQUARE * len(scans) / spare
        if typical < least.factor:
            least = Excess(typical, float(spare))
    return replace(least, factor=max(1.0, least.factor))
