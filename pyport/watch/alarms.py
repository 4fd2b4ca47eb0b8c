"""Alarms: what changed, since when, how large, how sure, and what to do next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.diagnosis.finding import Parameter
from pyport.diagnosis.identify import decide_by
from pyport.diagnosis.words import number
from pyport.watch.changes import Change
from pyport.watch.detector import SPREADS

#: An effect is named when it has this probability among all that could have changed; until then
#: a class is, of those that make it up together.
NAMED = 0.95
#: The states of an alarm.
RAISED, CONFIRMED, WITHDRAWN, OVER = "raised", "confirmed", "withdrawn", "over"

#: So many of those that it could be are put into words.
_SHOWN = 4
_SPREAD_WORDS = {
    "scatter_xel": "the scatter in {axis} is {size:.2g} times what it was",
    "scatter_el": "the scatter in {axis} is {size:.2g} times what it was",
    "outliers": "outliers are {size:.1%} of the readings",
}
_SPREAD_NEXT = {
    "scatter_xel": "look at wind, seeing, the signal and the drive of this axis",
    "scatter_el": "look at wind, seeing, the signal and the drive of this axis",
    "outliers": "look at the outlying pointings: signal, sources, interference",
}


@dataclass
class Alarm:
    """An alarm of one antenna."""

    number: int  #: of the alarm, from 1, over all antennas
    antenna: str  #: whose
    #: `raised`, `raised_row`: time [s since 1970, or row] and number of the pointing that raised
    #: it.
    raised: float
    raised_row: int
    #: `raised`, while it is being named; `confirmed`; `withdrawn`, as the data came to speak
    #: against it; `over`, as the telescope went back.
    state: str = RAISED
    #: `since`, `since_low`, `since_high`: when the change began, and between which pointings it may
    #: have [s, or row].
    since: float = math.nan
    since_low: float = math.nan
    since_high: float = math.nan
    since_row: int = 0  #: the pointing with which it began
    effect: str = ""  #: the likeliest effect's id, or one of `detector.SPREADS`
    #: What it could be, likeliest first: effects that cannot be distinguished, and the probability
    #: of them together.
    members: list[tuple[tuple[str, ...], float]] = field(default_factory=list)
    #: Name, value, sigma and unit of what changed.
    parameters: list[dict[str, Any]] = field(default_factory=list)
    moves_arcsec: float = 0.0  #: rms that it adds to the pointings of the past
    log_ratio: float = 0.0  #: logarithm of the likelihood ratio of the change to none
    #: `sentence`, `next`: what it is, and what to do, in words.
    sentence: str = ""
    next: str = ""
    ended: float | None = None  #: when it was withdrawn or over
    #: Whether it may have been so all along, the past not having shown it: no change.
    stood: bool = False

    @property
    def stands(self) -> bool:
        """Tell whether it is neither withdrawn nor over."""
        return self.state in (RAISED, CONFIRMED)

    @property
    def named(self) -> bool:
        """Tell whether one effect alone has nearly all of the probability."""
        return len(self.members) == 1 and len(self.members[0][0]) == 1

    def as_json(self, *, timed: bool) -> dict[str, Any]:
        """Return it as JSON holds it; times as ISO 8601 where pointings have times."""
        found = asdict(self)
        for key in ("raised", "since", "since_low", "since_high", "ended"):
            found[key] = moment(found[key], timed=timed)
        found["members"] = [
            {"effects": list(alike), "probability": round(chance, 4)}
            for alike, chance in self.members
        ]
        found["class"] = [one for alike, _ in self.members for one in alike]
        found["log10_likelihood_ratio"] = round(found.pop("log_ratio") / math.log(10), 2)
        found["verdict"] = "named" if self.named else "ambiguous"
        return found


def moment(value: float | None, *, timed: bool) -> str | float | None:
    """Return a time as ISO 8601 UTC, or the number of a row; None where it is not known."""
    if value is None or not math.isfinite(value):
        return None
    return f"{np.datetime64(round(value), 's')}Z" if timed else value


def parameters(change: Change, mean: Array, covariance: Array) -> list[dict[str, Any]]:
    """Return the changed coefficients in their units."""
    found = []
    for n, (name, one) in enumerate(zip(change.names, change.effect.coefficients, strict=True)):
        scale = abs(one.scale)
        sigma = math.sqrt(max(float(covariance[n, n]), 0.0)) / scale
        value = float(mean[n]) / one.scale
        found.append({"name": name, "value": value, "sigma": sigma, "unit": one.unit})
    return found


def moves(change: Change, mean: Array, sigma: float) -> float:
    """Return the rms that a change adds to the past pointings that it acts on [arcsec].

    The prior moves readings by `expected` times `sigma` [rad], k directions together.
    """
    size = float(mean @ np.linalg.solve(change.prior, mean))
    return change.expected * math.sqrt(max(size, 0.0) / len(mean)) * sigma / ARCSEC


def members(names: Sequence[tuple[str, ...]], chance: Array) -> list[tuple[tuple[str, ...], float]]:
    """Return what makes up `NAMED` of the probability together, likeliest first.

    Parameters
    ----------
    names
        For each change the ids of all effects that it stands for.
    chance
        Probability of each change.
    """
    total: dict[tuple[str, ...], float] = {}
    for alike, one in zip(names, chance, strict=True):
        total[alike] = total.get(alike, 0.0) + float(one)
    order = sorted(total.items(), key=lambda item: -item[1])
    reached = np.cumsum([one for _, one in order])
    return order[: 1 + int(np.searchsorted(reached, NAMED))]


def describe_spread(alarm: Alarm, size: float, axis: str) -> None:
    """Put an alarm of scatter on an axis, or of outliers, into words.

    `size` is the ratio of scatter or the share of outliers.
    """
    alarm.sentence = _SPREAD_WORDS[alarm.effect].format(size=size, axis=axis)
    alarm.next = _SPREAD_NEXT[alarm.effect]


def describe(alarm: Alarm, change: Change) -> None:
    """Put an alarm of an effect into words."""
    effect = change.effect
    sizes = ", ".join(
        f"{one['name'].replace('_', ' ')} {number(Parameter(**one))}" for one in alarm.parameters
    )
    pattern = effect.pattern or effect.sentence
    if alarm.stood:
        some = " or ".join(one for alike, _ in alarm.members[:_SHOWN] for one in alike)
        alarm.sentence = (
            f"{pattern}: {effect.sentence}; {sizes}, as if it had always been so:"
            f" the past did not show it; could be {some}"
        )
        alarm.next = f"fit the model with what the past left out: diagnose, or --add {alarm.effect}"
        return
    if alarm.named:
        alarm.sentence = f"{pattern}: {effect.sentence}; changed by {sizes}"
        alarm.next = f"check it at the telescope; if it stays, fit {alarm.effect} anew"
        return
    some = "; ".join(
        f"{' or '.join(alike)} ({chance:.0%})" for alike, chance in alarm.members[:_SHOWN]
    )
    alarm.sentence = f"{pattern}; changed by {sizes} if it is {alarm.effect}; could be {some}"
    ids = [one for alike, _ in alarm.members for one in alike if one not in SPREADS]
    alarm.next = decide_by(ids[:2]) or "go on observing: more pointings will tell"
