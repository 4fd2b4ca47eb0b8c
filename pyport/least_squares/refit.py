"""One linear fit many times over, with other weights each time."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.least_squares.gram import cholesky


class Refit:
    """A design and data, ready to be fitted with one set of weights after another.

    Parameters
    ----------
    columns, value
        The design (m, k) and the data (m,).
    """

    def __init__(self, columns: Array, value: Array):
        self.columns = columns
        self.value = value
        self.products = columns.T @ columns
        self.rank = columns.shape[1]
        if not _told_apart(self.products):
            self.rank = int(np.linalg.matrix_rank(columns)) if columns.size else 0

    def residual(self, weight: Array) -> Array:
        """Return what the weighted least-squares fit leaves of the data, shape (m,)."""
        columns, value = self.columns, self.value
        products = self._weighted(weight)
        if not _told_apart(products):
            root = np.sqrt(weight)
            solution = np.linalg.lstsq(columns * root[:, None], value * root, rcond=1e-9)[0]
        else:
            solution = np.linalg.solve(products, columns.T @ (weight * value))
        return np.asarray(value - columns @ solution)

    def _weighted(self, weight: Array) -> Array:
        """Return the products under weights; most are one, and only the others are gone through."""
        other = np.flatnonzero(weight != 1)
        if 2 * len(other) < len(weight):
            few = self.columns[other]
            return np.asarray(self.products - (few * (1 - weight[other])[:, None]).T @ few)
        root = self.columns * np.sqrt(weight)[:, None]
        return np.asarray(root.T @ root)


def _told_apart(products: Array) -> bool:
    """Tell whether products alone distinguish the columns."""
    length = np.sqrt(np.diag(products))
    return bool(np.all(length > 0)) and cholesky(products / np.outer(length, length)) is not None
