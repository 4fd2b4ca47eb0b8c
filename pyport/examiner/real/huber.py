"""Plain Huber least squares: what `fit` is compared with."""

from __future__ import annotations

import numpy as np

from pyport.examiner.real.sets import Recordings
from pyport.examiner.scores import Array

#: Huber's constant: 95 % efficient where noise is normal (Huber 1981, Robust Statistics, ch. 7).
K = 1.345
#: The scatter of normal noise over the median of its magnitude.
_PER_MEDIAN = 1.4826
_TURNS, _SETTLED = 200, 1e-9
#: Residuals count for no more than so many sigmas in the clipped scatter.
CLIP = 3.0

#: Group of rows -> coefficients in the order of the model's columns.
Coefficients = dict[str, Array]


def fit(recordings: Recordings) -> Coefficients:
    """Return the coefficients of every group; each axis is weighted by its robust scatter."""
    columns, offsets = recordings.columns(), recordings.offsets()
    return {
        str(group): _of_group(columns[rows], offsets[rows])
        for group in np.unique(recordings.group)
        for rows in [recordings.group == group]
    }


def _of_group(columns: Array, offsets: Array) -> Array:
    """Return the coefficients of (n, 2, k) columns for (n, 2) offsets, reweighted until at rest."""
    there = np.isfinite(offsets)
    axis = np.nonzero(there)[1]
    design, data = columns[there], offsets[there]
    weight = np.ones(len(data))
    value: Array = np.zeros(design.shape[1])
    for _ in range(_TURNS):
        root = np.sqrt(weight)
        solved = np.linalg.lstsq(design * root[:, None], data * root, rcond=1e-10)
        new = np.asarray(solved[0], dtype=float)
        left = data - design @ new
        scale = np.array([scatter(left[axis == k]) for k in (0, 1)])[axis]
        weight = np.minimum(1, K * scale / np.maximum(np.abs(left), 1e-300)) / scale**2
        if np.max(np.abs(design @ (new - value))) < _SETTLED * np.max(scale):
            return new
        value = new
    return value


def scatter(left: Array) -> float:
    """Return the robust scatter of residuals, 1 where there are none and never zero."""
    if len(left) == 0:
        return 1.0
    median = float(np.median(np.abs(left)))
    return _PER_MEDIAN * median or float(np.sqrt(np.mean(left**2))) or 1e-9


def residuals(recordings: Recordings, coefficients: Coefficients) -> Array:
    """Return what coefficients leave of every offset [arcsec], shape (n, 2), NaN for none."""
    columns = recordings.columns()
    left = np.full(recordings.offsets().shape, np.nan)
    for group, value in coefficients.items():
        rows = recordings.group == group
        left[rows] = recordings.offsets()[rows] - columns[rows] @ value
    return left


#: Samples of pointings for the error of a ratio.
DRAWS = 200


def ratio(ours: Array, theirs: Array) -> float:
    """Return by how much residuals (n, 2) exceed others: rms, each axis over the others' rms."""
    measured = np.isfinite(theirs).any(axis=0)
    scale = np.sqrt(np.nanmean(theirs[:, measured] ** 2, axis=0))
    return float(np.sqrt(np.nanmean((ours[:, measured] / scale) ** 2)))


def ratio_sigma(ours: Array, theirs: Array) -> float:
    """Return the error of `ratio`: its scatter among pointings drawn with replacement."""
    rng = np.random.default_rng(0)
    rows = np.flatnonzero(np.isfinite(theirs).any(axis=1))
    drawn = (rng.choice(rows, len(rows)) for _ in range(DRAWS))
    return float(np.std([ratio(ours[some], theirs[some]) for some in drawn]))


def clipped(ours: Array, theirs: Array) -> float:
    """Return the same of residuals cut off at three of the others' robust sigmas."""
    cut = [CLIP * scatter(one[np.isfinite(one)]) for one in theirs.T]
    return ratio(*(np.clip(one, -np.array(cut), cut) for one in (ours, theirs)))
