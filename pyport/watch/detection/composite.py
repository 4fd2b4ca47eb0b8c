"""The null: the telescope as it was, its model and its noise known no better than the past tells.

No model is complete: any one effect may have stood all along, too small or too little moved for
the past to show. Nor does a past of n nights say how far the next one drifts: if nights are alike,
one is wilder than all n before it with a probability of 1 / (n + 1). The null is therefore
composite: the model alone or with any one effect, and for each of them the noise of each night a
mixture of that of the past and of wilder ones, weighed anew by every reading (the fixed share of
Herbster & Warmuth 1998, Machine Learning 32, 151). A change is compared with the best of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from math import log

import numpy as np
from scipy.special import logsumexp

from pyport.angles import Array
from pyport.noise.scatter import tails
from pyport.watch.detection import detector, null
from pyport.watch.detection.baseline import LEAST_DOF, Past
from pyport.watch.detection.detector import Detector, Layout, layout
from pyport.watch.detection.null import Innovation, Null, Predictive, States
from pyport.watch.detection.prepare import Rows, prepare

#: Drifts and departures of a wilder night, over those of the past: octaves, so that what lies
#: between is within a factor of 1.4 of one. Nights wilder still are not in the promise.
WILDER = (2.0, 4.0)
#: Innovations whose prediction is doubtful by more than this share of their variance are not
#: counted: they belong to the first pointings, when the model was not known.
DOUBTFUL = 0.5
#: Nights, and pointings in each, from which on their scatter can be compared.
FEWEST_NIGHTS, FEWEST_IN_NIGHT = 3, 8


@dataclass
class Level:
    """The filter at one level of noise, and on it the effects that may have stood all along."""

    states: States
    null: Null
    standing: Detector


@dataclass
class Composite:
    """The null."""

    levels: tuple[Level, ...]  #: the noise of the past, then the wilder ones
    #: Probability of each level tonight, for each effect and, last, the model alone, (1 + W, M +
    #: 1).
    log_weight: Array = field(default_factory=lambda: np.zeros(0))
    #: What each effect and the model alone have come to, beside the model alone with the noise of
    #: the past, (M + 1,).
    log_ratio: Array = field(default_factory=lambda: np.zeros(0))
    nights: int = 0  #: until now, tonight among them


def begin(known: States, placed: Layout) -> Composite:
    """Return the null before any reading."""
    levels = []
    for factor in (1.0, *WILDER):
        states = replace(known, covariance=known.covariance * known.scaled(factor))
        start = null.begin(states)
        levels.append(Level(states, start, detector.standing(placed, start)))
    return Composite(tuple(levels), log_ratio=np.zeros(placed.members + 1))


def advance(own: Composite, rows: Rows, n: int) -> tuple[Array, bool, bool]:
    """Go on to a row; return what the first filter keeps, if a pointing and if a night begins."""
    night = rows.labels["session"][n] != own.levels[0].null.labels.get("session")
    if night:
        own.nights += 1
        wilder = 1 / max(own.nights, 2)
        others = len(own.levels) - 1
        share = np.log([1 - wilder, *[wilder / others] * others] if others else [1.0])
        own.log_weight = np.repeat(share[:, None], len(own.log_ratio), axis=1)
    kept, new = np.zeros(0), False
    for level in reversed(own.levels):
        kept, new = null.advance(level.null, level.states, rows, n)
        detector.forget(level.standing, kept)
    return kept, new, night


def take(
    own: Composite,
    placed: Layout,
    rows: Rows,
    n: int,
    axis: int,
    columns: Sequence[Array] = (),
    held: float | None = None,
) -> tuple[Innovation, Predictive, Array]:
    """Take in a reading; return what the first filter made of it, and the columns of its states.

    `columns` are those of states that alarms added; see `null.take` for `held`.
    """
    nuisance = np.concatenate([rows.nuisance[n, axis], *columns])
    found = []
    log_density = np.zeros_like(own.log_weight)
    for k, level in enumerate(own.levels):
        before = null.predictive(level.null, axis)
        reading, variance = float(rows.value[n, axis]), float(rows.variance[n, axis])
        one = null.take(level.null, axis, reading, nuisance, variance, held)
        was = level.standing.log_mass[0, : placed.members].copy()
        detector.update(level.standing, placed, one, nuisance, rows.change[n, axis], before)
        log_density[k, :-1] = level.standing.log_mass[0, : placed.members] - was
        log_density[k] += before.log_density(one.value**2) - log(one.sigma)
        found.append((one, before, nuisance))
    joint = own.log_weight + log_density - log_density[0, -1]
    total = logsumexp(joint, axis=0)
    own.log_ratio, own.log_weight = own.log_ratio + total, joint - total
    return found[0]


def log_omitted(own: Composite, placed: Layout) -> Array:
    """Return what each effect that may have stood all along has come to in the watch, (M,)."""
    share = np.where(placed.subtle, placed.log_share[: placed.members], -np.inf)
    return np.asarray(own.log_ratio[:-1] - own.log_ratio[-1] + share)


def settle(own: Composite) -> None:
    """Let the filters of wilder noise go on from where the first one is."""
    first = own.levels[0]
    for level in own.levels[1:]:
        level.null, level.standing = deepcopy((first.null, first.standing))


def calibrated(past: Past) -> tuple[Layout, Composite]:
    """Return the null after the past recordings, its distribution that of their innovations."""
    known, placed = null.states(past.baseline), layout(past.baseline.changes)
    rows = prepare(past.baseline, past.recordings)
    weights = past.weights[rows.order]
    nulls = begin(known, placed)
    found: list[tuple[float, str]] = []
    for n in range(len(rows)):
        advance(nulls, rows, n)
        for axis in (0, 1):
            if not np.isfinite(rows.value[n, axis]):
                continue
            held = float(weights[n, axis])
            one, _, column = take(nulls, placed, rows, n, axis, held=held)
            if one.sigma**2 * DOUBTFUL < rows.variance[n, axis] + _fresh(known, column):
                found.append((one.value, rows.labels["session"][n]))
    value = np.array([one for one, _ in found])
    shape, scale = tails(value)
    tail = 0.0 if shape.gross > 0 else shape.inverse
    dof = max(len(value) / 2, null.NIGHT_DOF_LEAST)
    degrees = 1 / (tail + 1 / dof)
    outliers = float(sum(null.outlying(one, degrees) for one in (value / scale) ** 2))
    for level in nulls.levels:
        level.null = replace(
            level.null,
            scale=np.full(2, scale**2),
            dof=np.full(2, dof),
            tail=tail,
            outliers=max(outliers, shape.gross * len(value)) + null.LEAST_GROSS * 100,
            readings=len(value) + 100.0,
            night_dof=_night_dof(value / scale, [name for _, name in found]),
        )
    # what they come to from now on is evidence, what they came to is none
    nulls.log_ratio[:] = 0.0
    return placed, nulls


def _fresh(known: States, column: Array) -> float:
    """Return the variance of a reading that departures and drifts make, whatever the past."""
    own = known.covariance * (known.of != "model")
    return float(column @ own @ column)


def _night_dof(value: Array, names: list[str]) -> float:
    """Return from how many deviations the scatter of another night is known by the past ones.

    Scales of nights that differ by more than their few readings explain make it small: the
    variance of a log-variance known from d deviations is 2 / d. From so few nights it is known
    badly itself, and counts for more, as the variance of departures does.
    """
    sessions, number, count = np.unique(names, return_inverse=True, return_counts=True)
    usual = np.minimum(value**2, null.OUTLIER**2)
    mean = np.bincount(number, usual, len(sessions)) / count
    many = count >= FEWEST_IN_NIGHT
    if many.sum() < FEWEST_NIGHTS:
        return null.NIGHT_DOF
    expected = float(np.mean(usual**2) / np.mean(usual) ** 2 - 1) * float(np.mean(1 / count[many]))
    excess = float(np.var(np.log(mean[many]), ddof=1)) - expected
    nights = max(float(many.sum()) - 1, LEAST_DOF)
    excess *= nights / (nights - 2)
    return float(np.clip(2 / max(excess, 1e-6), null.NIGHT_DOF_LEAST, null.NIGHT_DOF_MOST))
