"""The filter at the end of the past: states, scale, tails, outliers, what nights do to scatter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pyport.angles import Array
from pyport.noise.scatter import tails
from pyport.watch import composite
from pyport.watch.baseline import LEAST_DOF, Past
from pyport.watch.composite import Composite
from pyport.watch.detector import Layout, layout
from pyport.watch.null import (
    LEAST_GROSS,
    NIGHT_DOF,
    NIGHT_DOF_LEAST,
    NIGHT_DOF_MOST,
    OUTLIER,
    States,
    outlying,
    states,
)
from pyport.watch.prepare import prepare

#: Innovations whose prediction is doubtful by more than this share of their variance are not
#: counted: they belong to the first pointings, when the model was not known.
DOUBTFUL = 0.5
#: Nights, and pointings in each, from which on their scatter can be compared.
FEWEST_NIGHTS, FEWEST_IN_NIGHT = 3, 8


def calibrated(past: Past) -> tuple[Layout, Composite]:
    """Return the null after the past recordings, its distribution that of their innovations."""
    known, placed = states(past.baseline), layout(past.baseline.changes)
    rows = prepare(past.baseline, past.recordings)
    weights = past.weights[rows.order]
    nulls = composite.begin(known, placed)
    found: list[tuple[float, str]] = []
    for n in range(len(rows)):
        composite.advance(nulls, rows, n)
        for axis in (0, 1):
            if not np.isfinite(rows.value[n, axis]):
                continue
            held = float(weights[n, axis])
            one, _, column = composite.take(nulls, placed, rows, n, axis, held=held)
            if one.sigma**2 * DOUBTFUL < rows.variance[n, axis] + _fresh(known, column):
                found.append((one.value, rows.labels["session"][n]))
    value = np.array([one for one, _ in found])
    shape, scale = tails(value)
    tail = 0.0 if shape.gross > 0 else shape.inverse
    dof = max(len(value) / 2, NIGHT_DOF_LEAST)
    degrees = 1 / (tail + 1 / dof)
    outliers = float(sum(outlying(one, degrees) for one in (value / scale) ** 2))
    for level in nulls.levels:
        level.null = replace(
            level.null,
            scale=np.full(2, scale**2),
            dof=np.full(2, dof),
            tail=tail,
            outliers=max(outliers, shape.gross * len(value)) + LEAST_GROSS * 100,
            readings=len(value) + 100.0,
            night_dof=_night_dof(value / scale, [name for _, name in found]),
        )
    # what they come to from now on is evidence, what they came to is none
    nulls.log_ratio[:] = 0.0
    return placed, nulls


def _fresh(known: States, column: Array) -> float:
    """Return the variance of a reading that departures and drifts make, whatever the past."""
    own = known.covariance * np.array([of != "model" for of in known.of])
    return float(column @ own @ column)


def _night_dof(value: Array, names: list[str]) -> float:
    """Return from how many deviations the scatter of another night is known by the past ones.

    Scales of nights that differ by more than their few readings explain make it small: the
    variance of a log-variance known from d deviations is 2 / d. From so few nights it is known
    badly itself, and counts for more, as the variance of departures does.
    """
    sessions, number, count = np.unique(names, return_inverse=True, return_counts=True)
    usual = np.minimum(value**2, OUTLIER**2)
    mean = np.bincount(number, usual, len(sessions)) / count
    many = count >= FEWEST_IN_NIGHT
    if many.sum() < FEWEST_NIGHTS:
        return NIGHT_DOF
    expected = float(np.mean(usual**2) / np.mean(usual) ** 2 - 1) * float(np.mean(1 / count[many]))
    excess = float(np.var(np.log(mean[many]), ddof=1)) - expected
    nights = max(float(many.sum()) - 1, LEAST_DOF)
    excess *= nights / (nights - 2)
    return float(np.clip(2 / max(excess, 1e-6), NIGHT_DOF_LEAST, NIGHT_DOF_MOST))
