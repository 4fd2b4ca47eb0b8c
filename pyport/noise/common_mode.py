"""Common mode: noise that all antennas of an array share from scan to scan.

A gust over the site or a late clock tick moves all antennas at once. An effect
that is common to all of them meets that noise undiminished, however many
antennas there are, so its evidence is divided by what the shared part adds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from pyport.angles import Array, Codes
from pyport.least_squares.gram import spanned
from pyport.thresholds import ENOUGH_ANTENNAS, FEWEST, PER_SHAPE


@dataclass(frozen=True)
class Excess:
    """By what factor scans scatter in common more than independent antennas would.

    `factor` is 1 where the antennas are independent or cannot be compared;
    `dof` says from how many deviations it is known.
    """

    factor: float = 1.0
    dof: float = np.inf


def excess(
    left: Array, weight: Array, explained: Sequence[Array], model: Array, scan: Codes
) -> Excess:
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
        What the model leaves of each candidate's whitened columns, shape (m, k).
    model
        Orthonormal directions that span the model, shape (m, p): what it has fitted is missing.
    scan
        The scan of each, shape (m,).
    """
    there = np.flatnonzero(weight)
    scans = np.flatnonzero(np.bincount(scan[there]) >= ENOUGH_ANTENNAS)
    there = there[np.isin(scan[there], scans)]
    place = np.searchsorted(scans, scan[there])
    share = weight[there] / np.sqrt(np.bincount(place, weight[there] ** 2))[place]
    common = csr_array((share, (place, there)), shape=(len(scans), len(left)))
    mean = common @ left
    spare = len(scans) - np.sum((common @ model) ** 2)
    if len(scans) < FEWEST or spare < 1:
        return Excess()
    starts = np.cumsum([one.shape[1] for one in explained])[:-1]
    least = Excess(mean @ mean / spare, spare)
    for columns in np.split(common @ np.concatenate(explained, axis=1), starts, axis=1):
        basis = spanned(columns)[0]
        beside = spare - basis.shape[1]
        if basis.shape[1] > spare / PER_SHAPE:
            continue
        rest = mean - basis @ (basis.T @ mean)
        if rest @ rest / beside < least.factor:
            least = Excess(rest @ rest / beside, beside)
    return replace(least, factor=max(1.0, least.factor))
