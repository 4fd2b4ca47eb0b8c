"""The model that a fit completes."""

from __future__ import annotations

import numpy as np

from pyport.fitting.fit import Fit
from pyport.models.complete import Left, Solved, complete
from pyport.models.model import Model


def completed(fit: Fit) -> Model:
    """Return the model with the fitted values in its terms; see `pyport.models`."""
    solved, start = [], 0
    for one in fit.coefficients:
        known = np.isfinite(one.value)
        change = np.where(known, one.value - np.array(one.term.given(one.labels)), 0.0)
        places = range(start, start + len(known))
        sigma = np.where(known, one.sigma, 0.0)
        solved.append(Solved(one.term, one.labels, change, sigma, places, known.tolist()))
        start += len(known)
    left = Left(fit.residual, fit.noise.used, fit.stack)
    return complete(fit.model, fit.recordings, solved, fit.covariance, by="fit", left=left)
