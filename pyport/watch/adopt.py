"""Going on from a changed telescope: what changed becomes a state like the others, or ceases."""

from __future__ import annotations

import numpy as np

from pyport.watch.alarms import Alarm
from pyport.watch.antenna import Antenna, Slot, columns_of, first_state
from pyport.watch.detector import Detector


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
    places = columns_of(watch, change)
    size = len(places)
    bias = own.bias[start, places].T
    mean, spread = own.mean[start, change, :size], own.covariance[start, change, :size, :size]
    cross = -bias @ spread
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
