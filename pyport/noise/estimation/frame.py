"""What the estimate of a covariance needs of the recordings, whatever is fitted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pyport.angles import Array
from pyport.least_squares import robust
from pyport.noise import scatter
from pyport.noise.estimation import departing
from pyport.noise.series import Departures, Possible, Series, series
from pyport.recordings.schema import Recordings, Stack


@dataclass(frozen=True)
class Frame:
    """What the estimate of a covariance needs of the recordings, whatever is fitted.

    Attributes
    ----------
    parts
        The series.
    departures
        The departures that sessions and sources could show.
    drivers
        What the scatter may follow, for each reading: shape (m, k) each.
    recorded
        Recorded variance of each reading over its axis's median, (m,), None without any.
    centred
        Whether a drift is counted from its mean. On a mount that turns over no zero is a constant
        in its second angle, so that a drift would pass for what is; on others the model has one.
    rounding
        Scatter that the recorded digits make in either axis, before a model was taken off [rad].
    """

    parts: tuple[Series, ...]
    departures: tuple[Departures, ...]
    drivers: tuple[scatter.Driver, ...]
    recorded: Array | None
    centred: bool = False
    rounding: tuple[float, ...] = (0.0, 0.0)

    @cached_property
    def possible(self) -> Possible:
        """Return the departures as their estimate needs them."""
        return Possible(self.departures, self.parts)


def frame(recordings: Recordings, data: Stack) -> Frame:
    """Return the frame of some recordings."""
    return Frame(
        tuple(series(recordings, data)),
        departing.possible(recordings, data),
        tuple(replace(one, columns=one.columns[data.row]) for one in scatter.drivers(recordings)),
        scatter.recorded(recordings, data),
        recordings.at.mount.turns_over,
        tuple(robust.rounding(one[np.isfinite(one)]) for one in (recordings.x, recordings.y)),
    )


def floors_of(value: Array, given: Frame) -> dict[bool, float]:
    """Return the scatter that rounding makes in either axis [rad]."""
    of_axis = np.zeros(len(value), bool)
    for part in given.parts:
        of_axis[part.rows] = part.is_y
    return {
        is_y: max(robust.rounding(value[of_axis == is_y]), given.rounding[is_y])
        for is_y in (False, True)
    }
