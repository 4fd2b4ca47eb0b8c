"""From row to row: filter, detector, alarms; a confirmed change becomes a state of the filter."""

from __future__ import annotations

from math import log

import numpy as np

from pyport.angles import Array
from pyport.watch.alarms import CONFIRMED, HALF, NAMED, OVER, WITHDRAWN, Alarm, name, resize
from pyport.watch.detection import composite, detector, null
from pyport.watch.detection.antenna import Antenna, Slot, columns_of, first_state, state_columns
from pyport.watch.detection.detector import SPREADS, Detector
from pyport.watch.detection.null import Innovation, Predictive
from pyport.watch.detection.prepare import Rows

#: Pointings after an alarm in which it is named; where it then has one name it is confirmed.
NAMING = 20
#: Where it has none by now, the likeliest is taken for it.
LONGEST_NAMING = 60


def take(watch: Antenna, rows: Rows, n: int, every: dict[int, Alarm], number: int) -> list[str]:
    """Take in a row; return what happened to alarms, as `EVENT NUMBER`.

    A new alarm is added to `every`, the alarms by number, as `number`.
    """
    kept, new, night = composite.advance(watch.nulls, rows, n)
    detector.forget(watch.detector, kept)
    if night:
        # in another night the scatter is another one, changed or not
        own = watch.detector
        own.spread_dof = np.minimum(own.spread_dof, watch.null.night_dof)
    if new:
        watch.rows += 1
        if watch.detector.open:
            now, clock = watch.nulls.log_ratio, float(rows.clock[n])
            detector.start(watch.detector, watch.layout, watch.null, watch.rows, clock, now)
        elif watch.pending is not None and not every[watch.pending].stood:
            # once in a whole naming
            once = 1 / LONGEST_NAMING
            detector.may_go_back(watch.detector, watch.layout, float(rows.clock[n]), once)
    white = np.sqrt(rows.variance[n] * watch.null.scale)
    watch.left = np.stack([rows.off[n], white], axis=1)
    for axis in (0, 1):
        if np.isfinite(rows.value[n, axis]):
            _reading(watch, rows, n, axis)
    happened = _judge(watch, rows, n, every, number)
    stands = _stand(watch, rows, n, every)
    # what as a state of its own is no likelier than none was not confirmed
    at_once = {one.replace("withdrawn", "confirmed") for one in stands}
    return [one for one in happened if one not in at_once] + stands


def _reading(watch: Antenna, rows: Rows, n: int, axis: int) -> None:
    change = rows.change[n, axis]
    columns = [change[places] for places in state_columns(watch)]
    one, before, nuisance = composite.take(watch.nulls, watch.layout, rows, n, axis, columns)
    detector.update(watch.detector, watch.layout, one, nuisance, change, before)
    _spreads(watch, one, before)


def _judge(watch: Antenna, rows: Rows, n: int, every: dict[int, Alarm], number: int) -> list[str]:
    """Raise an alarm, name it, confirm or withdraw it.

    A change is one that no effect explains which may have stood all along; what one explains is
    raised as that.
    """
    evidence, omitted = watch.evidence, watch.omitted
    if watch.pending is None:
        if max(evidence, omitted) < watch.threshold:
            return []
        return _raise(watch, float(rows.clock[n]), every, number, stood=evidence < watch.threshold)
    alarm = every[watch.pending]
    # no likelier than none, whenever it may have begun
    if evidence < log(watch.detector.begun) and (omitted < 0 or not alarm.stood):
        alarm.state, alarm.ended = WITHDRAWN, float(rows.clock[n])
        _afresh(watch)
        return [f"withdrawn {alarm.number}"]
    alarm.stood = alarm.stood and evidence < watch.threshold
    best = name(watch, alarm, every)
    age = watch.rows - alarm.raised_row
    at_last = age >= LONGEST_NAMING
    if alarm.went_back > (HALF if at_last else NAMED) and age >= NAMING:
        return _over(watch, alarm, best)
    known_to_stay = alarm.went_back < 1 - NAMED
    if at_last or (age >= NAMING and len(alarm.members) == 1 and known_to_stay):
        return _confirm(watch, alarm, best, every)
    likely = alarm.members[0][1] > HALF
    return [f"renamed {alarm.number}"] if likely and alarm.news() else []


def _raise(
    watch: Antenna, clock: float, every: dict[int, Alarm], number: int, *, stood: bool
) -> list[str]:
    watch.pending = number
    watch.detector.open = False
    watch.unchanged_mean = watch.standing.mean.copy()
    watch.unchanged_covariance = watch.standing.covariance.copy()
    every[number] = Alarm(number, watch.baseline.antenna, clock, watch.rows, stood=stood)
    start, _ = name(watch, every[number], every)
    every[number].news()  # which the event says
    for level in watch.nulls.levels:
        if not stood:
            level.null.scale = watch.detector.before[start, :2].copy()
            level.null.outliers, level.null.readings = map(float, watch.detector.before[start, 2:])
        level.null.learning = False
    return [f"raised {number}"]


def _afresh(watch: Antenna) -> None:
    watch.pending = None
    watch.unchanged_mean = watch.unchanged_covariance = np.zeros(0)
    for level in watch.nulls.levels:
        level.null.learning = True
    watch.detector = detector.fresh(watch.layout, watch.null)
    watch.nulls.log_ratio = np.zeros_like(watch.nulls.log_ratio)


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
    if alarm.stood:
        adopt_omitted(watch, change, again)
    elif change < watch.layout.members:
        _forget_standing(watch)
        adopt(watch, start, change, again, watch.detector)
    else:
        adopt_spread(watch, alarm, start, change, again)
    composite.settle(watch.nulls)
    _afresh(watch)
    return happened


def _forget_standing(watch: Antenna) -> None:
    """Know of what may have stood all along what was known before: the rest was the change's."""
    watch.standing.mean, watch.standing.covariance = (
        watch.unchanged_mean,
        watch.unchanged_covariance,
    )


def _over(watch: Antenna, alarm: Alarm, best: tuple[int, int]) -> list[str]:
    """Go on as before: what changed went back while it was being named."""
    start, change = best
    # Less than an alarm asks for was an alarm by chance.
    alarm.state = OVER if watch.evidence >= watch.threshold else WITHDRAWN
    alarm.ended = alarm.back
    if change < watch.layout.members:
        _forget_standing(watch)
        bias, mean, spread = _learnt(watch, start, change, watch.detector)
        whole = watch.null.covariance + bias @ spread @ bias.T
        watch.null.mean, watch.null.covariance = (
            watch.null.mean - bias @ mean,
            (whole + whole.T) / 2,
        )
    composite.settle(watch.nulls)
    _afresh(watch)
    return [f"{alarm.state} {alarm.number}"]


def _spreads(watch: Antenna, one: Innovation, before: Predictive) -> None:
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
            release(watch, slot)
            composite.settle(watch.nulls)
            happened.append(f"withdrawn {alarm.number}")
    return happened


def _refreshed(watch: Antenna, slot: Slot, alarm: Alarm) -> float:
    """Say a confirmed change anew; return the log-ratio of it to none (Dickey 1971)."""
    change = watch.baseline.changes[slot.change]
    first = first_state(watch, slot)
    own = slice(first, first + len(change.prior))
    mean, covariance = watch.null.mean[own], watch.null.covariance[own, own]
    resize(watch, alarm, slot.change, mean, covariance * float(watch.null.scale.mean()))
    _, before = np.linalg.slogdet(change.prior)
    _, after = np.linalg.slogdet(covariance)
    distance = float(mean @ np.linalg.solve(covariance, mean))
    return 0.5 * (float(after - before) + distance / float(watch.null.scale.mean()))


def adopt_omitted(watch: Antenna, change: int, again: Slot | None) -> None:
    """Make an effect that stood all along a state of the filter; what else did is open again."""
    stands = watch.standing
    adopt(watch, 0, change, again, stands)
    stands.mean[:] = 0.0
    stands.covariance[0, change] = 0.0


def adopt(watch: Antenna, start: int, change: int, again: Slot | None, own: Detector) -> None:
    """Make the coefficients of a change states of the filter, with all that is known of them.

    `own` holds what was learnt of them. Given the coefficients t the filter is off by bias t: its
    mean for the changed telescope is m - bias t, t being of the mean and covariance in `own`.
    """
    filtered = watch.null
    bias, mean, spread = _learnt(watch, start, change, own)
    size, cross = len(mean), -bias @ spread
    joint_mean = np.concatenate([filtered.mean - bias @ mean, mean])
    whole = filtered.covariance + bias @ spread @ bias.T
    joint = np.block([[whole, cross], [cross.T, spread]])
    if again is not None:
        # the same coefficients changed once more: what counts from now on is the sum
        first = first_state(watch, again)
        fold = np.eye(len(filtered.mean), len(joint_mean))
        fold[first : first + size, len(filtered.mean) :] = np.eye(size)
        joint_mean, joint = fold @ joint_mean, fold @ joint @ fold.T
    else:
        behind = sum(one.change < watch.layout.members for one in watch.slots)
        watch.slots.insert(behind, Slot(watch.pending or 0, change))
        # what stood all along made as much of the change as of what the change was made of
        bias = watch.standing.bias
        watch.standing.bias = np.concatenate([bias, np.zeros((*bias.shape[:2], size))], axis=2)
    filtered.mean, filtered.covariance = joint_mean, (joint + joint.T) / 2


def _learnt(watch: Antenna, start: int, change: int, own: Detector) -> tuple[Array, Array, Array]:
    """Return what one of each coefficient made of the filter, and their mean and covariance."""
    places = columns_of(watch, change)
    size = len(places)
    mean, spread = own.mean[start, change, :size], own.covariance[start, change, :size, :size]
    return own.bias[start, places].T, mean, spread


def adopt_spread(watch: Antenna, alarm: Alarm, start: int, change: int, again: Slot | None) -> None:
    """Go on with another scatter, or another share of outliers."""
    own, filtered, axis = watch.detector, watch.null, change - watch.layout.members
    if again is None:
        reference = float(filtered.scale[axis]) if axis < 2 else filtered.share
        again = Slot(alarm.number, change, 0.0, reference)
        watch.slots.append(again)
    again.log_ratio = alarm.log_ratio
    if axis < 2:
        filtered.scale[axis] *= own.spread[start, axis]
        filtered.dof[axis] = min(own.spread_dof[start, axis], filtered.dof[axis])
    else:
        filtered.outliers = float(own.outliers[start])
        filtered.readings = float(own.readings[start])


def release(watch: Antenna, slot: Slot) -> None:
    """Go on as if a change had never been: its coefficients are zero."""
    filtered = watch.null
    if slot.change < watch.layout.members:
        first = first_state(watch, slot)
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
        for one in (watch.detector, watch.standing):
            one.bias = one.bias[:, :, others] - one.bias[:, :, own] @ gain.T
    watch.slots.remove(slot)
