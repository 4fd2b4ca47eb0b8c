"""What the panels draw: residuals before and after, what each effect adds, and against what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, handy
from pyport.diagnosis.finding import Interval
from pyport.diagnosis.joint import rms
from pyport.mounts import ALTAZ
from pyport.page.linear import Linear
from pyport.recordings.schema import Recordings, Stack


@dataclass(frozen=True)
class Side:
    """One axis of n recordings; NaN where it was not measured."""

    before: Array  #: residuals of the model alone [rad], shape (n,)
    #: What each effect takes off them, the model refitted [rad], shape (n,) each.
    layers: tuple[Array, ...]
    share: Array  #: how much each counts in an rms, 0 to 1; 0 for an outlier, shape (n,)
    floor: float | None = None  #: rms of the noise alone [rad], None where it is not known

    @property
    def after(self) -> Array:
        """Return what is left when every layer is taken off [rad], shape (n,)."""
        return self.before - sum(self.layers, np.zeros(len(self.before)))

    def rms(self, values: Array) -> float:
        """Return the rms of values on this axis [rad], each by its share."""
        there = np.isfinite(values)
        return rms(values[there], self.share[there])


@dataclass(frozen=True)
class Column:
    """Something to draw residuals against: numbers in a unit, or labels."""

    #: `name`, `label`, `unit`: as the recordings spell it, in words, and the unit, "" for none.
    name: str
    label: str
    unit: str
    #: Shape (n,), numbers (NaN where unknown) or text.
    values: NDArray[np.float64] | NDArray[np.str_]
    #: Stretches (low, high) to which a finding is confined, and the number of its layer.
    regions: tuple[tuple[float, float, int], ...] = ()

    @property
    def title(self) -> str:
        """Return the label with its unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


@dataclass(frozen=True)
class Layer:
    """An effect that can be taken off: its name, where it is confined to, its edge on the sky."""

    name: str
    region: tuple[Interval, ...] = ()
    curve: tuple[tuple[float, float], ...] = ()
    since: str | None = None


@dataclass(frozen=True)
class Picture:
    """All that the panels draw of n recordings.

    `time` in seconds of UTC since 1970 or None; `columns` with azimuth and
    elevation first and the hour angle next, then the others, the one with the most
    structure first; `labels` distinguish recordings when one is pointed at; `show`
    is what is drawn first: before, after or both; `axes` are what the mount calls x and y, and
    `turn` (2, 2, n) turns what is across and along elevation into them, None where it is the same;
    `linear` is what can be fitted again.
    """

    time: Array | None
    line: NDArray[np.int64]
    columns: tuple[Column, ...]
    labels: dict[str, NDArray[np.str_]]
    layers: tuple[Layer, ...]
    x: Side
    y: Side
    names: tuple[str, str] = ("before", "after")
    show: str = "both"
    axes: tuple[str, str] = ALTAZ.names
    linear: Linear | None = None
    turn: Array | None = None

    def __len__(self) -> int:
        """Return n."""
        return len(self.line)

    @property
    def unit(self) -> tuple[float, str]:
        """Return the unit [rad] in which residuals are shown, by what is left, and its name."""
        sizes = [side.rms(side.after) for side in (self.x, self.y)]
        return handy(max(sizes))

    def on_sky(self, name: str) -> tuple[Array, Array]:
        """Return residuals, `before` or `after`, across and along elevation, 0 for none [rad]."""
        x, y = (np.nan_to_num(getattr(side, name)) for side in (self.x, self.y))
        if self.turn is None:
            return x, y
        return self.turn[0, 0] * x + self.turn[1, 0] * y, self.turn[0, 1] * x + self.turn[1, 1] * y

    def sides(self) -> list[tuple[str, Side]]:
        """Return the axes on which anything was measured, with their names."""
        both = zip(self.axes, (self.x, self.y), strict=True)
        return [(name, side) for name, side in both if np.isfinite(side.before).any()]


def apart(recordings: Recordings, stack: Stack, values: Array) -> tuple[Array, Array]:
    """Return the numbers of a stack (m,) as an array for each axis, (n,) each, NaN for none."""
    out = np.full((2, len(recordings)), np.nan)
    out[stack.is_y.astype(int), stack.row] = values
    return out[0], out[1]


def sides(
    recordings: Recordings,
    stack: Stack,
    before: Array,
    layers: Sequence[Array],
    share: Array,
    floors: tuple[float | None, float | None] = (None, None),
) -> tuple[Side, Side]:
    """Return both axes from numbers in the order of the stack, (m,) each."""
    first = apart(recordings, stack, before)
    taken = [apart(recordings, stack, one) for one in layers]
    counted = apart(recordings, stack, share)
    one, other = (
        Side(
            first[axis],
            tuple(layer[axis] for layer in taken),
            np.nan_to_num(counted[axis]),
            floors[axis],
        )
        for axis in (0, 1)
    )
    return one, other
