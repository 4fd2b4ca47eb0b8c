"""Alarms: what changed, since when, how large, how sure, and what to do next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from scipy.special import logsumexp

from pyport.angles import ARCSEC, Array
from pyport.diagnosis.naming.classes import decide_by
from pyport.diagnosis.naming.finding import Parameter
from pyport.diagnosis.naming.words import number
from pyport.effects.circumstances import utc
from pyport.watch.detection.antenna import Antenna
from pyport.watch.detection.changes import Change
from pyport.watch.detection.composite import log_omitted
from pyport.watch.detection.detector import SPREADS, Detector, log_odds

#: An effect is named when it has this probability among all that could have changed; until then
#: a class is, of those that make it up together.
NAMED = 0.95
#: Another name, or a return, is said when it is likelier than all else together.
HALF = 0.5
#: A name with this much of the probability is preferred if it has already been given to a
#: standing alarm: what comes back is the same thing.
STANDING = 0.02
#: The ids of effects that are one change, and what they are called in words.
Names = tuple[tuple[str, ...], tuple[str, ...]]
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
    raised: float  #: time of the pointing that raised it [s since 1970, or row]
    raised_row: int  #: its number
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
    called: list[str] = field(default_factory=list)  #: what each of these is called in words
    #: Effect, whether it was named, and `stood`, as an event said them last.
    said: list[Any] = field(default_factory=list)
    #: Name, value, sigma and unit of what changed.
    parameters: list[dict[str, Any]] = field(default_factory=list)
    moves_arcsec: float = 0.0  #: rms that it adds to the pointings of the past
    log_ratio: float = 0.0  #: logarithm of the likelihood ratio of the change to none
    #: `sentence`, `next`: what it is, and what to do, in words.
    sentence: str = ""
    next: str = ""
    ended: float | None = None  #: when it was withdrawn or over
    #: When what changed went back, if it has while it was being named, and how likely it has.
    back: float = math.nan
    went_back: float = 0.0
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

    def news(self) -> bool:
        """Tell whether it is another one than an event said last; from now on it is said.

        A name is until it is excluded, or another one has nearly all of the probability.
        """
        now = [self.effect, self.named, self.stood]
        effect, _, stood = self.said or now
        among = any(effect in alike for alike, _ in self.members)
        news = (
            not self.said or self.stood != stood or not among or (self.named and now != self.said)
        )
        if news:
            self.said = now
        return news

    def as_json(self, *, timed: bool) -> dict[str, Any]:
        """Return it as JSON holds it; times as ISO 8601 where pointings have times."""
        found = asdict(self)
        del found["said"]
        for key in ("raised", "since", "since_low", "since_high", "ended", "back"):
            found[key] = moment(found[key], timed=timed)
        found["members"] = [
            {"effects": list(alike), "called": words, "probability": round(chance, 4)}
            for (alike, chance), words in zip(self.members, found.pop("called"), strict=True)
        ]
        found["class"] = [one for alike, _ in self.members for one in alike]
        found["log10_likelihood_ratio"] = round(found.pop("log_ratio") / math.log(10), 2)
        found["verdict"] = "named" if self.named else "ambiguous"
        return found


def moment(value: float | None, *, timed: bool) -> str | float | None:
    """Return a time as ISO 8601 UTC, or the number of a row; None where it is not known."""
    if value is None or not math.isfinite(value):
        return None
    return utc(value) if timed else value


def members(names: Sequence[Names], chance: Array) -> list[tuple[Names, float]]:
    """Return what makes up `NAMED` of the probability together, likeliest first.

    `names` are those that each change stands for, `chance` is its probability.
    """
    total: dict[Names, float] = {}
    for alike, one in zip(names, chance, strict=True):
        total[alike] = total.get(alike, 0.0) + float(one)
    order = sorted(total.items(), key=lambda item: -item[1])
    reached = np.cumsum([one for _, one in order])
    return order[: 1 + int(np.searchsorted(reached, NAMED))]


def listed(alarm: Alarm, found: Sequence[tuple[Names, float]], chosen: Names) -> None:
    """Say what an alarm could be, by `members`, what it is taken for first."""
    order = sorted(found, key=lambda one: (one[0] != chosen, -one[1]))
    alarm.members = [(ids, chance) for (ids, _), chance in order]
    alarm.called = [" or ".join(words) for (_, words), _ in order]
    alarm.effect = chosen[0][0]


def _enter(change: Change) -> str:
    """Return what a model asks for where a change stays."""
    if change.of_model:
        return f"fit {change.called[0]} anew"
    return f"the model needs a term for it: diagnose, or --add {change.effect.id}"


def describe(alarm: Alarm, change: Change) -> None:
    """Put an alarm of an effect into words."""
    effect = change.effect
    sizes = ", ".join(
        f"{one['name'].replace('_', ' ')} {number(Parameter(**one))}" for one in alarm.parameters
    )
    pattern = effect.pattern or effect.sentence
    if alarm.stood:
        some = " or ".join(alarm.called[:_SHOWN])
        alarm.sentence = (
            f"{pattern}: {effect.sentence}; {sizes}, as if it had always been so:"
            f" the past did not show it; could be {some}"
        )
        alarm.next = f"fit the model with what the past left out: diagnose, or --add {alarm.effect}"
        return
    back = ", and went back" * (alarm.went_back > HALF)
    if alarm.named:
        alarm.sentence = f"{pattern}: {effect.sentence}; changed by {sizes}{back}"
        alarm.next = f"check it at the telescope; if it stays, {_enter(change)}"
        return
    likely = zip(alarm.called, alarm.members[:_SHOWN], strict=False)
    some = "; ".join(f"{words} ({chance:.0%})" for words, (_, chance) in likely)
    which = f"if it is {change.called[0]}; could be {some}"
    alarm.sentence = f"{pattern}; changed by {sizes}{back}, {which}"
    ids = [one for alike, _ in alarm.members for one in alike if one not in SPREADS]
    alarm.next = decide_by(ids[:2]) or "go on observing: more pointings will tell"


def name(watch: Antenna, alarm: Alarm, every: dict[int, Alarm]) -> tuple[int, int]:
    """Say what an alarm is of; return the start and the change that are likeliest."""
    if alarm.stood:
        return 0, _name_omitted(watch, alarm)
    own, layout = watch.detector, watch.layout
    joint = log_odds(own, layout, watch.nulls.log_ratio)
    total = float(logsumexp(joint))
    chance = np.exp(joint - total)
    some = watch.baseline.changes
    names: list[Names] = [(one.alike, one.called) for one in some]
    names += [((one,), (one.replace("_", " in "),)) for one in SPREADS]
    whole = chance.sum(axis=0)
    change = int(np.argmax(whole))  # of one effect's sizes the likelier one
    found = members(names, whole)
    likely = {one for (alike, _), _ in found for one in alike}
    for slot in watch.slots:
        if every[slot.alarm].effect in likely and chance[:, slot.change].sum() > STANDING:
            change = slot.change
    alarm.went_back = float(chance[~own.stays].sum())
    of_kind = own.stays == (alarm.went_back <= HALF)
    start = int(np.argmax(np.where(of_kind, chance[:, change], -1.0)))
    alarm.back = float(own.back[start])
    listed(alarm, found, names[change])
    alarm.log_ratio = total
    _date(own, alarm, start, chance)
    if change >= layout.members:
        _size_of_spread(watch, alarm, start, change)
    else:
        size = len(some[change].prior)
        mean = own.mean[start, change, :size]
        covariance = own.covariance[start, change, :size, :size] * float(watch.null.scale.mean())
        resize(watch, alarm, change, mean, covariance)
    return start, change


def _name_omitted(watch: Antenna, alarm: Alarm) -> int:
    """Say what may have stood all along; return the likeliest."""
    own = watch.standing
    joint = log_omitted(watch.nulls, watch.layout)
    alarm.log_ratio = float(logsumexp(joint))
    chance = np.exp(joint - alarm.log_ratio)
    changes = watch.baseline.changes
    change = int(np.argmax(chance))
    names = [(one.alike, one.called) for one in changes]
    listed(alarm, members(names, chance), names[change])
    size = len(changes[change].prior)
    covariance = own.covariance[0, change, :size, :size] * float(watch.null.scale.mean())
    resize(watch, alarm, change, own.mean[0, change, :size], covariance)
    return change


def _date(own: Detector, alarm: Alarm, start: int, chance: Array) -> None:
    """Say since when: the likeliest start, and those before and after it that bear 0.9."""
    # One that may have gone back began when it did.
    rows, first_of, which = np.unique(own.row, return_index=True, return_inverse=True)
    by_start, clock = np.bincount(which, chance.sum(axis=1)), own.clock[first_of]
    order = np.argsort(-by_start)
    bearing = order[: 1 + int(np.searchsorted(np.cumsum(by_start[order]), 0.9))]
    bearing = np.append(bearing, which[start])
    alarm.since, alarm.since_row = float(own.clock[start]), int(own.row[start])
    # starts between two that are kept were merged into one of them
    first, last = max(int(bearing.min()) - 1, 0), min(int(bearing.max()) + 1, len(rows) - 1)
    alarm.since_low, alarm.since_high = float(clock[first]), float(clock[last])


def resize(watch: Antenna, alarm: Alarm, change: int, mean: Array, covariance: Array) -> None:
    """Say how large a change is, and put it into words."""
    own = watch.baseline.changes[change]
    sigmas = np.sqrt(np.maximum(np.diag(covariance), 0.0)).tolist()
    some = zip(own.names, own.effect.coefficients, mean.tolist(), sigmas, strict=True)
    alarm.parameters = [
        {"name": name, "value": x / one.scale, "sigma": sigma / abs(one.scale), "unit": one.unit}
        for name, one, x, sigma in some
    ]
    # the prior moves readings by `expected` times their scatter, k directions together
    rms = math.sqrt(max(float(mean @ np.linalg.solve(own.prior, mean)), 0.0) / len(mean))
    scatter = float(np.sqrt(watch.baseline.white.mean())) / ARCSEC
    alarm.moves_arcsec = own.expected * rms * scatter
    describe(alarm, own)


def _size_of_spread(watch: Antenna, alarm: Alarm, start: int, change: int) -> None:
    own, axis = watch.detector, change - watch.layout.members
    if axis < 2:
        size = float(np.sqrt(own.spread[start, axis]))
        sigma = size / np.sqrt(2 * float(own.spread_dof[start, axis]))
        excess = max(size**2 - 1, 0.0) * float(watch.baseline.white[axis])
        alarm.moves_arcsec = float(np.sqrt(excess)) / ARCSEC
    else:
        size = float(own.outliers[start] / own.readings[start])
        sigma = float(np.sqrt(size * (1 - size) / own.readings[start]))
    unit = "times" if axis < 2 else "of readings"
    alarm.parameters = [{"name": alarm.effect, "value": size, "sigma": sigma, "unit": unit}]
    called = watch.baseline.axes[min(axis, 1)]
    alarm.sentence = _SPREAD_WORDS[alarm.effect].format(size=size, axis=called)
    alarm.next = _SPREAD_NEXT[alarm.effect]
