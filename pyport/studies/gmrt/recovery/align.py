"""Which cell of a garbled row belongs to which column: a pair hidden Markov model.

A printed row of m cells and the n columns it should have are read side by
side. Each step is one of four: a cell that is its column's (MATCH), a cell
that stands in its column's place but was taken from elsewhere (FOREIGN), a
cell too many (EXTRA), a column that lost its cell (LOST). Sums over all ways
through (forward and backward) give the probability that cell i is column j's.
Durbin, Eddy, Krogh & Mitchison 1998, Biological Sequence Analysis, ch. 4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array

MATCH, FOREIGN, EXTRA, LOST = range(4)

#: Probability of the next step (columns) after a step (rows). Most rows lose or
#: gain few cells; foreign cells come in runs, as a row's tail repeats another row's.
STEPS = np.array(
    [
        [0.95, 0.01, 0.02, 0.02],
        [0.08, 0.84, 0.04, 0.04],
        [0.55, 0.05, 0.37, 0.03],
        [0.35, 0.02, 0.03, 0.60],
    ]
)


def alignment(likelihood: Array, background: Array, cells: NDArray[np.int64]) -> Array:
    """Return the probability that each cell is its column's, for many rows at once.

    `likelihood`: of cell i if it is column j's, shape (rows, m, n).
    `background`: of cell i wherever it came from, shape (rows, m).
    `cells`: how many of the m cells each row really has, shape (rows,).
    Returns shape (rows, m, n); what is missing from 1 along j is the probability that the
      cell is a foreign one or one too many.
    """
    ahead = _ahead(likelihood, background)
    behind = _behind(likelihood, background, cells)
    rows, n = np.arange(len(cells)), likelihood.shape[2]
    whole = ahead[rows, cells, n].sum(axis=1)
    both: Array = ahead[:, 1:, 1:, MATCH] * behind[:, 1:, 1:, MATCH]
    return both / whole[:, None, None]


def _ahead(likelihood: Array, background: Array) -> Array:
    """Return the likelihood of the first i cells and j columns by last step, (rows, i, j, 4)."""
    rows, m, n = likelihood.shape
    ahead = np.zeros((rows, m + 1, n + 1, 4))
    ahead[:, 0, 0, MATCH] = 1
    for i in range(m + 1):
        for j in range(n + 1):
            here = ahead[:, i, j]
            if i and j:
                before = ahead[:, i - 1, j - 1]
                here[:, MATCH] += before @ STEPS[:, MATCH] * likelihood[:, i - 1, j - 1]
                here[:, FOREIGN] = before @ STEPS[:, FOREIGN] * background[:, i - 1]
            if i:
                here[:, EXTRA] = ahead[:, i - 1, j] @ STEPS[:, EXTRA] * background[:, i - 1]
            if j:
                here[:, LOST] = ahead[:, i, j - 1] @ STEPS[:, LOST]
    return ahead


def _behind(likelihood: Array, background: Array, cells: NDArray[np.int64]) -> Array:
    """Return the likelihood of what follows i cells and j columns, given the last step."""
    rows, m, n = likelihood.shape
    behind = np.zeros((rows, m + 1, n + 1, 4))
    behind[np.arange(rows), cells, n] = 1
    for i in range(m, -1, -1):
        for j in range(n, -1, -1):
            here = behind[:, i, j]
            if i < m and j < n:
                after = behind[:, i + 1, j + 1]
                matched = after[:, MATCH] * likelihood[:, i, j]
                here += matched[:, None] * STEPS[:, MATCH]
                here += (after[:, FOREIGN] * background[:, i])[:, None] * STEPS[:, FOREIGN]
            if i < m:
                extra = behind[:, i + 1, j, EXTRA] * background[:, i]
                here += extra[:, None] * STEPS[:, EXTRA]
            if j < n:
                here += behind[:, i, j + 1, LOST, None] * STEPS[:, LOST]
    return behind
