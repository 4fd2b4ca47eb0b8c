"""The name, the date and the size of a change, from the masses of the detector."""

from __future__ import annotations

import numpy as np
from scipy.special import logsumexp

from pyport.angles import ARCSEC, Array
from pyport.watch import alarms
from pyport.watch.alarms import Alarm
from pyport.watch.antenna import Antenna
from pyport.watch.composite import log_omitted
from pyport.watch.detector import SPREADS, Detector, log_odds

#: A name with this much of the probability is preferred if it has already been given to a
#: standing alarm: what comes back is the same thing.
STANDING = 0.02


def name(watch: Antenna, alarm: Alarm, every: dict[int, Alarm]) -> tuple[int, int]:
    """Say what an alarm is of; return the start and the change that are likeliest."""
    if alarm.stood:
        return 0, _name_omitted(watch, alarm)
    own, layout = watch.detector, watch.layout
    joint = log_odds(own, layout, watch.nulls.log_ratio)
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
    alarm.members = alarms.members([one.alike for one in changes], chance)
    alarm.effect = changes[change].alike[0]
    alarm.members.sort(key=lambda one: (alarm.effect not in one[0], -one[1]))
    size = len(changes[change].prior)
    covariance = own.covariance[0, change, :size, :size] * float(watch.null.scale.mean())
    resize(watch, alarm, change, own.mean[0, change, :size], covariance)
    return change


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


def resize(watch: Antenna, alarm: Alarm, change: int, mean: Array, covariance: Array) -> None:
    """Say how large a change is, and put it into words."""
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
    alarms.describe_spread(alarm, size, watch.baseline.axes[min(axis, 1)])
