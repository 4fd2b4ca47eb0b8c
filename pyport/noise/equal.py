"""Readings that all count alike, as least squares without weights has them."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.noise.covariance import Covariance
from pyport.noise.estimate import Frame
from pyport.noise.whitening import Noise


def equal(value: Array, design: Array, given: Frame) -> Covariance:
    """Return the covariance of readings with one scatter, that of what a fit leaves.

    What TPOINT and the Field System's `error` do: their published rms and coefficients come
    out digit for digit.

    Parameters
    ----------
    value, design
        The data [rad], shape (m,), and the columns that are fitted, shape (m, p).
    given
        The frame of the recordings.
    """
    solution, _, rank, _ = np.linalg.lstsq(design, value, rcond=1e-9)
    left = value - design @ solution
    scatter = float(np.sqrt((left**2).sum() / max(len(value) - int(rank), 1)))
    noise = Noise(within=max(scatter, 1e-12), between=0.0)
    every = np.ones(len(value))
    return Covariance(given.parts, (noise,) * len(given.parts), every, every)
