"""Do own parts repeat? Those of some sessions predict the others, shape by shape.

Nothing of the antenna's session is used but its zeros, which an observer loads
anew: its own parts come from its other sessions, the common part from the
session's other antennas. The model's own form is held to the same.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import ARCMIN, Array
from pyport.diagnosis.arrays.blocks import Block, Shape
from pyport.diagnosis.arrays.lasting import Lasting, expected_without, lasting, well_known
from pyport.diagnosis.joint import rms
from pyport.thresholds import ENOUGH_ANTENNAS


@dataclass(frozen=True)
class Repeat:
    """One shape's own parts in one session beside those of all other sessions.

    Attributes
    ----------
    session, antennas
        The session held out, and the n antennas well known both there and elsewhere.
    common, common_sigma
        The session's common part when the antennas' own parts come from the others.
    correlation
        Of the antennas' own parts there and elsewhere, about the mean.
    size, left, noise
        Rms of the own parts there, of what those elsewhere leave of them, and what the errors of
        both alone would leave.
    p_value
        Chance of so much left by the errors alone.
    """

    session: str
    antennas: tuple[str, ...]
    common: float
    common_sigma: float
    correlation: float
    size: float
    left: float
    noise: float
    p_value: float


def repeats(blocks: Sequence[Block], shared: Collection[int], shape: int) -> list[Repeat]:
    """Hold each session out in turn, and compare one shape's own parts with the others'."""
    found = []
    for session in sorted({one.session for one in blocks}):
        inside = [one for one in blocks if one.session == session]
        outside = [one for one in blocks if one.session != session]
        both = {one.antenna for one in inside} & {one.antenna for one in outside}
        if len(both) >= ENOUGH_ANTENNAS:
            one = _compared(session, lasting(inside, shared), lasting(outside, shared), shape)
            if one is not None:
                found.append(one)
    return found


def _compared(session: str, inside: Lasting, outside: Lasting, shape: int) -> Repeat | None:
    """Compare one session's own parts with the others'."""
    from scipy.stats import chi2

    values, covariances, levels = [], [], []
    known = _well(inside, shape) & _well(outside, shape)
    names = tuple(sorted(known))
    if len(names) < ENOUGH_ANTENNAS:
        return None
    for parts in (inside, outside):
        at = [parts.antennas.index(name) for name in names]
        values.append(parts.own[at, shape])
        covariances.append(parts.own_covariance(shape)[np.ix_(at, at)])
        levels.append(float(values[-1].mean()))
    about = np.eye(len(names)) - 1 / len(names)
    covariance = about @ (covariances[0] + covariances[1]) @ about
    own, others = (about @ value for value in values)
    difference = own - others
    common, variance = levels[0] - levels[1], np.mean(np.diag(covariance)) / len(names)
    if shape in inside.shared:
        common += float(inside.common[0, shape])
    squares = float(difference @ np.linalg.pinv(covariance, rcond=1e-9) @ difference)
    return Repeat(
        session,
        names,
        common,
        float(np.sqrt(variance)),
        float(np.corrcoef(own, others)[0, 1]) if own.any() and others.any() else 0.0,
        rms(own),
        rms(difference),
        float(np.sqrt(np.mean(np.diag(covariance)))),
        float(chi2.sf(squares, len(names) - 1)),
    )


def _well(parts: Lasting, shape: int) -> set[str]:
    """Return the antennas whose own part is well known."""
    well = well_known(parts.own_covariance(shape))
    return {name for name, good in zip(parts.antennas, well, strict=True) if good}


#: A prediction as near to its own scatter as this needs no explanation.
NEAR = 1.5
#: What an improvement is held to.
FACTOR = 2.0
#: Scatter of this many times the array's median drowns the rest.
NOISY = 2.0
#: Why a prediction gains less than the factor.
AS_GOOD_AS_NOISE = "predicted to its own noise: the model's form left little to gain"
LOUD = "its pointings scatter more than the others': nothing more to gain"
MOVED = "it did not repeat; what differs most from its other sessions"
ALONE = "no other session of this antenna to predict it from"


@dataclass(frozen=True)
class AntennaDay:
    """One antenna in one session, predicted from all else.

    Attributes
    ----------
    antenna, session
        Whose.
    pointings, outliers
        Compared, and left out of both rms.
    before, after
        Rms of the model's own form and of the array's parts, held out, only zeros refitted [rad].
    fitted_before, fitted_after
        The same with the antenna's session in the fit [rad].
    noise
        Scatter about a fit of this session alone [rad].
    why, detail
        What kept the improvement below the factor, and what moved; "" where nothing did.
    """

    antenna: str
    session: str
    pointings: int
    outliers: int
    before: float
    after: float
    fitted_before: float
    fitted_after: float
    noise: float
    why: str = ""
    detail: str = ""

    @property
    def factor(self) -> float:
        """Return by how much the held-out rms falls."""
        return self.before / max(self.after, 1e-300)


@dataclass(frozen=True)
class UnseenDays:
    """Everything held out: what was predicted, and what could not be, with the reason."""

    days: tuple[AntennaDay, ...]
    unpredicted: tuple[tuple[str, str, str], ...]

    @property
    def sessions(self) -> list[str]:
        """Return the sessions that were predicted."""
        return sorted({one.session for one in self.days})

    def of(self, session: str) -> list[AntennaDay]:
        """Return the antennas of a session."""
        return [one for one in self.days if one.session == session]


def unseen_days(
    model: Sequence[Block],
    blocks: Sequence[Block],
    shapes: Sequence[Shape],
    shared: Collection[int],
    sessions: Collection[str] | None = None,
) -> UnseenDays:
    """Predict every antenna-day from all the others.

    Parameters
    ----------
    model
        Blocks in the model's own shapes.
    blocks, shapes, shared
        Blocks in the array's shapes, what those are, and which a session's antennas share.
    sessions
        Those to predict; None for all.
    """
    whole, own_form = lasting(blocks, shared), lasting(model)
    usual = float(np.median([one.sigma for one in blocks]))
    beside = {(one.antenna, one.session): n for n, one in enumerate(model)}
    days, unpredicted = [], []
    for n, one in enumerate(blocks):
        if sessions is not None and one.session not in sessions:
            continue
        if not any(o.antenna == one.antenna for o in blocks if o is not one):
            unpredicted.append((one.antenna, one.session, ALONE))
            continue
        number = beside.get((one.antenna, one.session))
        if number is None:
            reason = "too few pointings for the model's own form"
            unpredicted.append((one.antenna, one.session, reason))
            continue
        same, predicted = model[number], expected_without(blocks, whole, n)
        before = one.used_rms(same.left(expected_without(model, own_form, number)))
        after = one.used_rms(one.left(predicted))
        days.append(
            AntennaDay(
                one.antenna,
                one.session,
                int(one.used.sum()),
                int((~one.used).sum()),
                before,
                after,
                one.used_rms(same.left(same.alone())),
                one.used_rms(one.left(_posterior(one, n, whole))),
                one.sigma,
                *_why(one, predicted, before, after, usual, shapes),
            )
        )
    return UnseenDays(tuple(days), tuple(unpredicted))


def _posterior(one: Block, number: int, whole: Lasting) -> Array:
    """Return a block's coefficients in the fit of everything, its passing part with them."""
    expected = whole.of(one.antenna, one.session)
    power = whole.scatter**2 / whole.tails[number]
    free = np.eye(len(power)) + one.information * power
    passing = power * np.linalg.solve(free, one.score - one.information @ expected)
    return np.asarray(expected + passing)


def _why(
    one: Block, predicted: Array, before: float, after: float, usual: float, shapes: Sequence[Shape]
) -> tuple[str, str]:
    """Explain a prediction that is not much better than the model's own: why, and what moved."""
    if before >= FACTOR * after:
        return "", ""
    if after <= NEAR * one.sigma:
        return (LOUD if one.sigma > NOISY * usual else AS_GOOD_AS_NOISE), ""
    # each shape by itself: what of the miss would go if it alone were this session's own?
    miss = one.score - one.information @ predicted
    power = np.maximum(np.diag(one.information), 1e-300)
    most = int(np.argmax(miss**2 / power))
    return MOVED, f"{shapes[most].name.replace('_', ' ')} {miss[most] / power[most] / ARCMIN:+.1f}'"


@dataclass(frozen=True)
class Medians:
    """The median antenna of a session: rms as in `AntennaDay` [rad], factors, and their count.

    `factor` and `fitted_factor` are the median antenna's own, held out and in the fit;
    `enough` says how many antennas' held-out rms falls by `FACTOR` or more.
    """

    before: float
    after: float
    fitted_before: float
    fitted_after: float
    factor: float
    fitted_factor: float
    enough: int


def medians(days: Sequence[AntennaDay]) -> Medians:
    """Return the median over some antenna-days, one or more."""
    return Medians(
        float(np.median([one.before for one in days])),
        float(np.median([one.after for one in days])),
        float(np.median([one.fitted_before for one in days])),
        float(np.median([one.fitted_after for one in days])),
        float(np.median([one.factor for one in days])),
        float(np.median([one.fitted_before / max(one.fitted_after, 1e-300) for one in days])),
        sum(one.factor >= FACTOR for one in days),
    )
