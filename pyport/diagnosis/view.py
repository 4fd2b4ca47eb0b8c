"""The readings as they stand beside a model, each weighed as if it were alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pyport.angles import Array, Codes
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen, Problem, WhitenedData
from pyport.diagnosis.evidence import shown


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


def shown_beside(
    setup: Problem, weighed: WhitenedData, chosen: Sequence[Chosen], candidates: Sequence[Candidate]
) -> list[tuple[Array, Array]]:
    """Return what the data show of each candidate beside the model and what is chosen: `shown`."""
    model = setup.expanded((*setup.base, *chosen), of=weighed.white)
    places = [one.columns for one in candidates]
    own = weighed.covariance.whiten(setup.columns[:, np.concatenate(places)])
    both = np.concatenate([own, weighed.white[:, -1:]], axis=1)
    left = both - model @ np.linalg.lstsq(model, both, rcond=1e-9)[0]
    length = np.linalg.norm(own, axis=0)
    starts = np.cumsum([0, *map(len, places)])
    return [shown(left[:, low:up], length[low:up], left[:, -1]) for low, up in pairwise(starts)]
