"""The readings as they stand beside a model, each weighed as if it were alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array, Codes
from pyport.diagnosis.case import Chosen, Problem, WhitenedData


@dataclass(frozen=True)
class View:
    """Weighted readings with a model projected out, each as if alone: drifts are passed over.

    Attributes
    ----------
    rows
        The readings that count, shape (n,).
    root
        Root of their weights, shape (n,).
    basis
        Orthonormal columns that span the model, shape (n, p).
    left
        What the model leaves of the data, weighted, shape (n,).
    """

    rows: Codes
    root: Array
    basis: Array
    left: Array


def plain_view(setup: Problem, weighed: WhitenedData, chosen: Sequence[Chosen]) -> View:
    """Return the readings beside a model, outliers left out."""
    scatter = weighed.covariance.scatter
    rows = np.flatnonzero(weighed.used)
    root = np.sqrt(weighed.weights[rows]) / scatter[rows]
    model = setup.expanded((*setup.base, *chosen))[rows] * root[:, None]
    model = model / np.maximum(np.linalg.norm(model, axis=0), 1e-300)
    basis, strength, _ = np.linalg.svd(model, full_matrices=False)
    basis = basis[:, strength > 1e-9 * strength.max(initial=1e-300)]
    data = setup.residual[rows] * root
    return View(rows, root, basis, data - basis @ (basis.T @ data))
