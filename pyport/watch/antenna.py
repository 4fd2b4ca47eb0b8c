"""The watch of one antenna: filter, detector and alarms, from row to row."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import log

import numpy as np
from scipy.special import logsumexp

from pyport.angles import ARCSEC, Array, Codes
from pyport.watch import alarms, detector, null
from pyport.watch.alarms import CONFIRMED, OVER, WITHDRAWN, Alarm
from pyport.watch.baseline import Baseline
from pyport.watch.detector import SPREADS, Detector, Layout
from pyport.watch.null import Innovation, Null, States
from pyport.watch.prepare import Rows

#: Pointings after an alarm in which it is named; where it then has one name it is confirmed.
NAMING = 20
#: Where it has none by now, the likeliest is taken for it.
LONGEST_NAMING = 60
#: Another name is reported when it is likelier than all others together.
HALF = 0.5
#: A name with this much of the probability is preferred if it has already been given to a
#: standing alarm: what comes back is the same thing.
STANDING = 0.02


@dataclass
class Slot:
    """A confirmed alarm whose change is a further state of the filter, or of the scatter.

    Attributes
    ----------
    alarm
        Its number.
    change
        Which of the changes, or which of the spreads behind them.
    log_ratio
        Of the change to none: of a spread it is kept here, of a change it follows from the state.
    reference
        Scale, or share of outliers, before.
    """

    alarm: int
    change: int
    log_ratio: float = 0.0
    reference: float = 0.0


@dataclass
class Antenna:
    """The watch of one antenna.

    Attributes
    ----------
    baseline, states, layout
        What does not change.
    null, detector
        The running state.
    threshold
        Logarithm of what the mixture must reach.
    slots
        Confirmed alarms, those with states of the filter in their order first.
    pending
        The alarm that is being named, its number.
    rows
        Pointings taken in.
    home
        The states that make up the model of the past, (D,).
    left
        Offsets of the last row against that model, and its white sigma [rad], (2, 2).
    """

    baseline: Baseline
    states: States
    layout: Layout
    null: Null
    detector: Detector
    threshold: float
    slots: list[Slot] = field(default_factory=list)
    pending: int | None = None
    rows: int = 0
    home: Array = field(default_factory=lambda: np.zeros(0))
    left: Array = field(default_factory=lambda: np.full((2, 2), np.nan))

    @property
    def evidence(self) -> float:
        """Return the logarithm of the mixture."""
        return detector.evidence(self.detector, self.layout)


def begin(
    baseline: Baseline, known: States, start: Null, pointings_per_false_alarm: float
) -> Antenna:
    """Return the watch at its beginning; the threshold keeps one false alarm in so many."""
    placed = detector.layout(baseline.changes)
    empty = detector.fresh(placed, len(start.mean))
    home = start.mean * np.array([of == "model" for of in known.of])
    threshold = log(pointings_per_false_alarm)
    return Antenna(baseline, known, placed, start, empty, threshold, home=home)


def take(watch: Antenna, rows: Rows, n: int, every: dict[int, Alarm], number: int) -> list[str]:
    """Take in a row; return what happened to alarms, as `EVENT NUMBER`.

    Parameters
    ----------
    every
        Alarms by number, to which a new one is added, as `number`.
    """
    night = rows.labels["session"][n] != watch.null.labels.get("session")
    kept, new = null.advance(watch.null, watch.states, rows, n)
    detector.forget(watch.detector, kept, watch.null, night=night)
    if new:
        watch.rows += 1
        if watch.detector.open:
            detector.start(
                watch.detector, watch.layout, watch.null, watch.rows, float(rows.clock[n])
            )
    white = np.sqrt(rows.variance[n] * watch.null.scale)
    watch.left = np.stack([rows.off[n], white], axis=1)
    for axis in (0, 1):
        if np.isfinite(rows.value[n, axis]):
            _reading(watch, rows, n, axis)
    happened = _judge(watch, rows, n, every, number)
    return happened + _stand(watch, rows, n, every)


def _reading(watch: Antenna, rows: Rows, n: int, axis: int) -> None:
    own = watch.null
    change = rows.change[n, axis]
    columns = [change[places] for places in _places(watch)]
    nuisance = np.concatenate([rows.nuisance[n, axis], *columns])
    before = (float(own.scale[axis]), own.degrees(axis), own.share, own.tail)
    one = null.take(own, axis, float(rows.value[n, axis]), nuisance, float(rows.variance[n, axis]))
    detector.update(watch.detector, watch.layout, one, nuisance, change, before)
    _spreads(watch, one, before)


def _places(watch: Antenna) -> list[Codes]:
    """Return the columns of the changes that are states, in the order of those."""
    members = watch.layout.members
    return [_own(watch, slot.change) for slot in watch.slots if slot.change < members]


def _own(watch: Antenna, change: int) -> Codes:
    return watch.layout.place[change, : len(watch.baseline.changes[change].prior)]


def _judge(watch: Antenna, rows: Rows, n: int, every: dict[int, Alarm], number: int) -> list[str]:
    """Raise an alarm, name it, confirm or withdraw it."""
    evidence = watch.evidence
    if watch.pending is None:
        if evidence < watch.threshold:
            return []
        watch.pending = number
        watch.detector.open = False
        antenna = watch.baseline.antenna
        every[number] = Alarm(number, antenna, float(rows.clock[n]), watch.rows)
        start, _ = _name(watch, every[number], every)
        watch.null.scale = watch.detector.before[start, :2].copy()
        watch.null.outliers, watch.null.readings = map(float, watch.detector.before[start, 2:])
        watch.null.learning = False
        return [f"raised {number}"]
    alarm = every[watch.pending]
    # no likelier than none, whenever it may have begun
    if evidence < log(watch.detector.begun):
        alarm.state, alarm.ended = WITHDRAWN, float(rows.clock[n])
        _afresh(watch)
        return [f"withdrawn {alarm.number}"]
    was = alarm.effect, alarm.named
    best = _name(watch, alarm, every)
    age = watch.rows - alarm.raised_row
    if age >= LONGEST_NAMING or (age >= NAMING and len(alarm.members) == 1):
        return _confirm(watch, alarm, best, every)
    known = (alarm.effect, alarm.named)
    return [f"renamed {alarm.number}"] if known != was and alarm.members[0][1] > HALF else []


def _afresh(watch: Antenna) -> None:
    watch.pending = None
    watch.null.learning = True
    watch.detector = detector.fresh(watch.layout, len(watch.null.mean))


def _name(watch: Antenna, alarm: Alarm, every: dict[int, Alarm]) -> tuple[int, int]:
    """Say what an alarm is of; return the start and the change that are likeliest."""
    own, layout = watch.detector, watch.layout
    joint = own.log_mass + layout.log_share
    total = float(logsumexp(joint))
    chance = np.exp(joint - total)
    some = watch.baseline.changes
    names: list[tuple[str, ...]] = [*(one.alike for one in some), *((one,) for one in SPREADS)]
    alarm.members = alarms.members(names, chance.sum(axis=0))
    change = int(np.argmax(chance.sum(axis=0)))  # of one effect's sizes the likelier one
    likely = {one for alike, _ in alarm.members for one in alike}
    for slot in watch.slots:
        if every[slot.alarm].effect in likely and chance[:, slot.change].sum() > STANDING:
            change = slot.change
    start = int(np.argmax(chance[:, change]))
    alarm.effect = names[change][0]
    alarm.members.sort(key=lambda one: (alarm.effect not in one[0], -one[1]))
    alarm.log_ratio = total
    _date(own, alarm, start, chance)
    if change >= layout.members:
        _size_of_spread(watch, alarm, start, change)
    else:
        size = len(some[change].prior)
        mean = own.mean[start, change, :size]
        covariance = own.covariance[start, change, :size, :size] * float(watch.null.scale.mean())
        _size(watch, alarm, change, mean, covariance)
    return start, change


def _date(own: Detector, alarm: Alarm, start: int, chance: Array) -> None:
    """Say since when: the likeliest start, and those before and after it that bear 0.9."""
    by_start = chance.sum(axis=1)
    order = np.argsort(-by_start)
    bearing = order[: 1 + int(np.searchsorted(np.cumsum(by_start[order]), 0.9))]
    bearing = np.append(bearing, start)
    alarm.since, alarm.since_row = float(own.clock[start]), int(own.row[start])
    # starts between two that are kept were merged into one of them
    first, last = max(int(bearing.min()) - 1, 0), min(int(bearing.max()) + 1, len(own.clock) - 1)
    alarm.since_low, alarm.since_high = float(own.clock[first]), float(own.clock[last])


def _size(watch: Antenna, alarm: Alarm, change: int, mean: Array, covariance: Array) -> None:
    one = watch.baseline.changes[change]
    alarm.parameters = alarms.parameters(one, mean, covariance)
    sigma = float(np.sqrt(watch.baseline.white.mean()))
    alarm.moves_arcsec = alarms.moves(one, mean, sigma)
    alarms.describe(alarm, one)


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
    alarms.describe(alarm, None, size)


def _confirm(
    watch: Antenna, alarm: Alarm, best: tuple[int, int], every: dict[int, Alarm]
) -> list[str]:
    """Go on from the changed telescope: what changed becomes a state like the others."""
    start, change = best
    alarm.state = CONFIRMED
    happened = [f"confirmed {alarm.number}"]
    again = next((slot for slot in watch.slots if slot.change == change), None)
    if again is not None:
        former = every[again.alarm]
        former.state, former.ended = OVER, alarm.since
        happened.append(f"over {former.number}")
        again.alarm = alarm.number
    if change < watch.layout.members:
        _adopt(watch, start, change, again)
    else:
        _adopt_spread(watch, alarm, start, change, again)
    _afresh(watch)
    return happened


def _adopt(watch: Antenna, start: int, change: int, again: Slot | None) -> None:
    """Make the coefficients of a change states of the filter, with all that is known of them.

    Given the coefficients t the filter is off by bias t: its mean for the changed telescope is
    m - bias t, with t of the mean and covariance that were learnt.
    """
    own, filtered = watch.detector, watch.null
    places = _own(watch, change)
    size = len(places)
    bias = own.bias[start, places].T
    mean, spread = own.mean[start, change, :size], own.covariance[start, change, :size, :size]
    cross = -bias @ spread
    joint_mean = np.concatenate([filtered.mean - bias @ mean, mean])
    whole = filtered.covariance + bias @ spread @ bias.T
    joint = np.block([[whole, cross], [cross.T, spread]])
    if again is not None:
        # the same coefficients changed once more: what counts from now on is the sum
        first = len(watch.states) + _offset(watch, again)
        fold = np.eye(len(filtered.mean), len(joint_mean))
        fold[first : first + size, len(filtered.mean) :] = np.eye(size)
        joint_mean, joint = fold @ joint_mean, fold @ joint @ fold.T
    else:
        behind = sum(one.change < watch.layout.members for one in watch.slots)
        watch.slots.insert(behind, Slot(watch.pending or 0, change))
    filtered.mean, filtered.covariance = joint_mean, (joint + joint.T) / 2


def _offset(watch: Antenna, slot: Slot) -> int:
    """Return where among the added states those of a slot begin."""
    before = watch.slots[: watch.slots.index(slot)]
    return sum(len(watch.baseline.changes[one.change].prior) for one in before)


def _adopt_spread(
    watch: Antenna, alarm: Alarm, start: int, change: int, again: Slot | None
) -> None:
    own, filtered, axis = watch.detector, watch.null, change - watch.layout.members
    if again is None:
        reference = float(filtered.scale[axis]) if axis < 2 else filtered.share
        again = Slot(alarm.number, change, 0.0, reference)
        watch.slots.append(again)
    again.log_ratio = alarm.log_ratio
    if axis < 2:
        # relative to the scale as it is now, which followed the change a little
        filtered.scale[axis] *= own.spread[start, axis]
        filtered.dof[axis] = min(own.spread_dof[start, axis], filtered.dof[axis])
    else:
        filtered.outliers = float(own.outliers[start])
        filtered.readings = float(own.readings[start])


def _spreads(watch: Antenna, one: Innovation, before: tuple[float, float, float, float]) -> None:
    """Let a reading speak for or against a confirmed change of scatter or outliers."""
    scale, degrees, share, _ = before
    square = one.value**2
    for slot in watch.slots:
        axis = slot.change - watch.layout.members
        if axis == one.axis:
            wide = null.log_gross(square, max(scale, slot.reference), share)
            now = null.log_density(square, scale, degrees, share, wide)
            then = null.log_density(square, slot.reference, degrees, share, wide)
            slot.log_ratio += float(now - then)
        elif axis == len(SPREADS) - 1:
            outlier = null.outlying(square / scale, degrees)
            now, then = (share, slot.reference) if outlier else (1 - share, 1 - slot.reference)
            slot.log_ratio += log(now / then)


def _stand(watch: Antenna, rows: Rows, n: int, every: dict[int, Alarm]) -> list[str]:
    """Bring confirmed alarms up to date; withdraw what the data withdrew."""
    happened = []
    for slot in list(watch.slots):
        alarm = every[slot.alarm]
        if slot.change < watch.layout.members:
            ratio = _refreshed(watch, slot, alarm)
        else:
            ratio = slot.log_ratio
        alarm.log_ratio = ratio
        if ratio < 0:
            alarm.state = WITHDRAWN
            alarm.ended = float(rows.clock[n])
            _release(watch, slot)
            happened.append(f"withdrawn {alarm.number}")
    return happened


def _refreshed(watch: Antenna, slot: Slot, alarm: Alarm) -> float:
    """Say a confirmed change anew; return the log-ratio of it to none (Dickey 1971)."""
    change = watch.baseline.changes[slot.change]
    first = len(watch.states) + _offset(watch, slot)
    own = slice(first, first + len(change.prior))
    mean, covariance = watch.null.mean[own], watch.null.covariance[own, own]
    _size(watch, alarm, slot.change, mean, covariance * float(watch.null.scale.mean()))
    _, before = np.linalg.slogdet(change.prior)
    _, after = np.linalg.slogdet(covariance)
    distance = float(mean @ np.linalg.solve(covariance, mean))
    return 0.5 * (float(after - before) + distance / float(watch.null.scale.mean()))


def _release(watch: Antenna, slot: Slot) -> None:
    """Go on as if a change had never been: its coefficients are zero."""
    filtered = watch.null
    if slot.change < watch.layout.members:
        first = len(watch.states) + _offset(watch, slot)
        own = np.arange(first, first + len(watch.baseline.changes[slot.change].prior))
        others = np.delete(np.arange(len(filtered.mean)), own)
        gain = np.linalg.solve(
            filtered.covariance[np.ix_(own, own)], filtered.covariance[np.ix_(own, others)]
        ).T
        filtered.mean = filtered.mean[others] - gain @ filtered.mean[own]
        filtered.covariance = (
            filtered.covariance[np.ix_(others, others)]
            - gain @ filtered.covariance[np.ix_(own, others)]
        )
        bias = watch.detector.bias
        watch.detector.bias = bias[:, :, others] - bias[:, :, own] @ gain.T
    watch.slots.remove(slot)
