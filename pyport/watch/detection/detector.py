"""The detector: a mixture of sequential likelihood ratios over what, when and how large.

For a change that began at pointing k the ratio of the predictive density of each new reading
after the change to that without it is multiplied up: its expectation is one as long as nothing
changes. The sum over all k grows by one a pointing in expectation, so that it passes A within n
pointings with a probability of at most n / A, and in A pointings or more on average, however long
one watches (Roberts 1966, Technometrics 8, 411; Shin, Ramdas & Rinaldo 2024, "E-detectors",
New England J. Stat. Data Sci. 2, 229). A mixture over what may change keeps the promise.

How large a change is, is learnt as it goes: the density after the change is that of the filter
with the coefficients as further states, first of them those readings that came since k. What the
filter makes of the change meanwhile is followed exactly (Willsky & Jones 1976, IEEE Trans. Autom.
Control 21, 108), whatever it is: the null is filtered once.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log, log1p
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from pyport.angles import Array
from pyport.watch.detection.changes import SPREAD_SHARE, WORKED_ON, Change
from pyport.watch.detection.null import (
    OUTLIER,
    Innovation,
    Null,
    Predictive,
    learnt,
    log_density,
    log_gross,
    log_usual,
    outlying,
)

#: Moments at which a change may have begun: the last ones all, earlier ones ever further apart.
STARTS, NEWEST = 24, 4
#: The scatter after a change is learnt from this many deviations of the old one on.
SPREAD_DOF = 2.0
#: Outliers and readings that the share of outliers after a change is learnt from.
MORE_OUTLIERS, OF_READINGS = 0.5, 4.0
#: What is watched for beside the catalogue.
SPREADS = ("scatter_xel", "scatter_el", "outliers")


@dataclass(frozen=True)
class Layout:
    """Where the coefficients of all changes stand."""

    #: Column of each coefficient of each change, (M, p); the last column, which is zero, where a
    #: change has fewer.
    place: NDArray[np.intp]
    prior: Array  #: covariance of each change before any reading, (M, p, p)
    log_share: Array  #: of the budget: changes first, then `SPREADS`, (M + 3,)
    #: Which may have stood all along, (M,): what is done to a telescope begins when it is done.
    subtle: NDArray[np.bool_]
    columns: int  #: C

    @property
    def members(self) -> int:
        """Return M."""
        return len(self.place)


def layout(changes: tuple[Change, ...]) -> Layout:
    """Return the layout of some changes."""
    sizes = [len(one.prior) for one in changes]
    widest, total = max(sizes, default=1), sum(sizes)
    place = np.full((len(sizes), widest), total, np.intp)
    prior = np.zeros((len(sizes), widest, widest))
    start = 0
    for n, one in enumerate(changes):
        size = len(one.prior)
        place[n, :size] = np.arange(start, start + size)
        prior[n, :size, :size] = one.prior
        start += size
    spread = SPREAD_SHARE / len(SPREADS)
    share = np.array([*(one.share for one in changes), *([spread] * len(SPREADS))])
    subtle = np.array([one.expected < WORKED_ON for one in changes], bool)
    return Layout(place, prior, np.log(share / share.sum()), subtle, total)


@dataclass
class Detector:
    """The state of the mixture."""

    #: Logarithm of the likelihood ratio of each start and change, and of `SPREADS`, the sum of
    #: those merged into it: (S, M + 3).
    log_mass: Array
    #: What one of each coefficient made of the filter's states since each start, (S, C + 1, D).
    bias: Array
    #: `mean`, `covariance`: of the coefficients, (S, M, p) and (S, M, p, p).
    mean: Array
    covariance: Array
    #: `spread`, `spread_dof`: variance after a change of the scatter of either axis, over that
    #: before, and from how many deviations, (S, 2).
    spread: Array
    spread_dof: Array
    #: `outliers`, `readings`: since each start, (S,).
    outliers: Array
    readings: Array
    #: Scale of either axis, outliers and readings that the null knew at each start, (S, 4).
    before: Array
    stood: Array  #: what each member of the composite null had come to at each start, (S, M + 1)
    #: `row`, `clock`: when each start was, (S,).
    row: Array
    clock: Array
    #: When what began at each start went back, NaN where it has not [clock], (S,).
    back: Array
    begun: int = 0  #: how many starts there were, those merged into others counted
    open: bool = True  #: whether new starts are taken: not while an alarm is being named

    def arrays(self) -> dict[str, Array]:
        """Return everything that one start holds, an array for each."""
        return {k: one for k, one in vars(self).items() if isinstance(one, np.ndarray)}

    @property
    def stays(self) -> NDArray[np.bool_]:
        """Tell of which starts what began has not gone back, (S,)."""
        return np.isnan(self.back)

    def add(self, one: dict[str, Any]) -> None:
        """Add a start, an array for each name."""
        for name, values in self.arrays().items():
            setattr(self, name, np.concatenate([values, one[name][None]]))

    def keep(self, index: NDArray[np.intp]) -> None:
        """Keep some of the starts."""
        for name, values in self.arrays().items():
            setattr(self, name, values[index])


def fresh(known: Layout, null: Null) -> Detector:
    """Return a detector without any start."""
    one = _begun(known, null, 0, 0.0, np.zeros(known.members + 1))
    return Detector(**{name: values[None][:0] for name, values in one.items()})


def standing(known: Layout, null: Null) -> Detector:
    """Return the effects that may have stood all along, from here on."""
    found = fresh(known, null)
    start(found, known, null, 0, 0.0, np.zeros(known.members + 1))
    return found


def start(
    detector: Detector, known: Layout, null: Null, row: int, clock: float, stood: Array
) -> None:
    """Let a change begin at this pointing; where there are too many, merge two.

    `stood` (M + 1,) is what the members of the composite null have come to by now.
    """
    detector.begun += 1
    if len(detector.row) == STARTS:
        _merge(detector, known, row)
    detector.add(_begun(known, null, row, clock, stood))


def _begun(known: Layout, null: Null, row: int, clock: float, stood: Array) -> dict[str, Any]:
    """Return what one start holds before any reading."""
    members, widest = known.place.shape
    return {
        "log_mass": np.zeros(members + len(SPREADS)),
        "bias": np.zeros((known.columns + 1, len(null.mean))),
        "mean": np.zeros((members, widest)),
        "covariance": known.prior,
        "spread": np.ones(2),
        "spread_dof": np.full(2, SPREAD_DOF),
        "outliers": np.array(MORE_OUTLIERS),
        "readings": np.array(OF_READINGS),
        "before": np.array([*null.scale, null.outliers, null.readings]),
        "stood": stood,
        "row": np.array(float(row)),
        "clock": np.array(clock),
        "back": np.array(np.nan),
    }


def _merge(detector: Detector, known: Layout, row: int) -> None:
    """Give the mass of one start to its neighbour, where both are nearly equally long ago.

    The promise holds whichever two are merged: the sum of their masses goes on as one.
    """
    age = row - detector.row
    older = np.arange(len(age) - NEWEST)
    closeness = (age[older] + 1) / (age[older + 1] + 1)
    first = int(np.argmin(closeness))
    pair = [first, first + 1]
    total = logsumexp(detector.log_mass[pair] + known.log_share, axis=1)
    kept = pair[int(np.argmax(total))]
    detector.log_mass[kept] = np.logaddexp(*detector.log_mass[pair])
    detector.stood[kept] = detector.stood[pair].min(axis=0)
    gone = pair[0] + pair[1] - kept
    detector.keep(np.delete(np.arange(len(age)), gone))


def may_go_back(detector: Detector, known: Layout, clock: float, chance: float) -> None:
    """Let what changed at the likeliest start have gone back at this pointing, by some chance.

    From then on only what the filter made of it is left. Of too many the least likely is dropped.
    """
    total = logsumexp(detector.log_mass + known.log_share, axis=1)
    stays = detector.stays
    best = int(np.argmax(np.where(stays, total, -np.inf)))
    one = {name: values[best].copy() for name, values in detector.arrays().items()}
    one |= {"log_mass": one["log_mass"] + log(chance), "back": np.array(clock)}
    if (~stays).sum() == STARTS:
        least = int(np.argmin(np.where(stays, np.inf, total)))
        detector.keep(np.delete(np.arange(len(stays)), least))
    detector.add(one)


def forget(detector: Detector, kept: Array) -> None:
    """Let the biases go on to another row with the states that they are of."""
    if len(detector.row) and (kept < 1).any():
        detector.bias *= kept


def update(
    detector: Detector,
    known: Layout,
    one: Innovation,
    nuisance: Array,
    change: Array,
    before: Predictive,
) -> None:
    """Take in an innovation, `before` being what it was predicted with.

    `nuisance` and `change` are the reading's columns of states (D,) and of coefficients (C,).
    """
    if not len(detector.row):
        return
    scale, degrees, share, _ = before
    value = one.value
    wide = log_gross(value * value, scale, share)
    usual = float(log_density(value * value, scale, degrees, share, wide))
    seen = -(detector.bias @ nuisance)
    seen[:, :-1] += np.where(detector.stays[:, None], change, 0.0)
    members = known.members
    response = seen[:, known.place] / one.sigma
    along = np.einsum("smpq,smq->smp", detector.covariance, response)
    predicted = np.einsum("smp,smp->sm", response, detector.mean)
    doubt = np.einsum("smp,smp->sm", response, along)
    missed = value - predicted
    total = scale + doubt
    density = log_density(missed**2, total, degrees, share, wide)
    detector.log_mass[:, :members] += density - usual
    weight = np.exp(log1p(-share) + log_usual(missed**2, total, degrees) - density)
    weight *= (degrees + 1) / (degrees + missed**2 / total)
    gain = along / (doubt + scale / np.maximum(weight, 1e-6))[:, :, None]
    detector.mean += gain * missed[:, :, None]
    detector.covariance -= gain[..., :, None] * along[..., None, :]
    detector.bias += seen[:, :, None] * one.gain
    _spread(detector, members, one, before, usual)
    _outlying(detector, members, share, outlier=outlying(value * value / scale, degrees))


def _spread(
    detector: Detector, members: int, one: Innovation, before: Predictive, usual: float
) -> None:
    """Take an innovation for one of another scatter on its axis, where that stays."""
    scale, degrees, share, tail = before
    stays = detector.stays
    axis, square = one.axis, one.value**2
    dof = detector.spread_dof[:, axis]
    wider, variance = 1 / (1 / degrees + 1 / dof), scale * detector.spread[:, axis]
    density = log_density(square, variance, wider, share, log_gross(square, scale, share))
    detector.log_mass[:, members + axis] += stays * (density - usual)
    # a gross error is none of the scatter's
    capped = min(square / scale, OUTLIER**2 * float(detector.spread[:, axis].max()))
    now = learnt(detector.spread[:, axis], dof, capped, 1.0, tail)
    detector.spread[:, axis] = np.where(stays, now, detector.spread[:, axis])
    detector.spread_dof[:, axis] += stays


def _outlying(detector: Detector, members: int, before: float, *, outlier: bool) -> None:
    """Count an outlier, or none, against the shares before and after a change for the worse."""
    stays = detector.stays
    after = np.maximum(detector.outliers / detector.readings, before)
    ratio = np.log(after) - log(before) if outlier else np.log1p(-after) - log1p(-before)
    detector.log_mass[:, members + len(SPREADS) - 1] += stays * ratio
    detector.outliers = detector.outliers + outlier * stays
    detector.readings = detector.readings + stays


def log_odds(detector: Detector, known: Layout, null: Array) -> Array:
    """Return what each start and change has come to beside the best of the null, (S, M + 3).

    `null` (M + 1,) is what the members of the composite null have come to by now.
    """
    stood = (null - detector.stood)[:, np.append(known.subtle, True)]
    best = stood.max(axis=1, initial=0.0)
    return np.asarray(detector.log_mass + known.log_share - best[:, None])


def evidence(detector: Detector, known: Layout, null: Array) -> float:
    """Return the logarithm of the mixture; minus infinity before any start."""
    if not len(detector.row):
        return -np.inf
    return float(logsumexp(log_odds(detector, known, null)))
