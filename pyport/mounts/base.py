"""What a mount is: two axes, one carrying the other, and the frame on the ground that they turn in.

Every mount with two axes is an alt-azimuth mount put down in another frame. Its first axis
points along `p`, the angle about it is counted from the direction `z` toward the direction `q`,
and the second angle is counted from the plane of `z` and `q` toward `p`. In that frame the
angles are an azimuth and an elevation, so that what an alt-azimuth mount does about its axes any
other does about its own. Handedness is the determinant of the frame and enters nowhere else.

Directions on the ground have the components north, east, up; angles are radians.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array

#: Latitude [rad] -> the unit vectors z, q and p on the ground, rows of a matrix (3, 3).
Frame = Callable[[float], Array]


@dataclass(frozen=True)
class Axis:
    """An axis of a mount."""

    #: `name`, `symbol`: as an observer says it, "hour angle", and as a formula has it, "H".
    name: str
    symbol: str
    #: `column`, `offset`: what its angle, and the encoder's offset from it, are called in
    #: recordings, without a unit.
    column: str
    offset: str
    #: `low`, `high`: limits of travel [rad].
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Mount:
    """A kind of mount."""

    id: str  #: the word of a file's `# mount:`
    sentence: str  #: what it is, in words
    #: `first`, `second`: the axis that is fixed to the ground, and the one that it carries.
    first: Axis
    second: Axis
    #: `across`, `across_column`: what the offset of the first angle times the cosine of the second
    #: is called.
    across: str
    across_column: str
    frame: Frame | None  #: where the axes point; None where they are those of azimuth and elevation
    model: str  #: the built-in model of its classical terms
    needs_latitude: bool = False  #: whether the frame depends on where it stands
    #: Whether it reaches a direction in two ways, one on each side of a pier: the first axis half a
    #: turn on, the second beyond its pole.
    turns_over: bool = False
    #: A source closer than this to the first axis is out of reach: that axis would have to turn
    #: faster than the sky by more than the cosecant of it.
    blind_deg: float = 0.0
    #: Words of an alt-azimuth mount and what stands for them here: in sentences, and with `_` for a
    #: blank in ids and names of coefficients.
    words: Mapping[str, str] = field(default_factory=dict, compare=False)

    @property
    def axes(self) -> tuple[Axis, Axis]:
        """Return both axes, the one that is fixed to the ground first."""
        return self.first, self.second

    @property
    def fixed(self) -> str:
        """Return what the axis that is fixed to the ground is called."""
        return self.words.get("azimuth axis", f"{self.first.name} axis")

    @property
    def names(self) -> tuple[str, str]:
        """Return what the two components of an offset on the sky are called."""
        return self.across, self.second.name

    def angles(
        self, az: Array, el: Array, latitude: float = 0.0, over: NDArray[np.bool_] | None = None
    ) -> tuple[Array, Array]:
        """Return the angles of both axes [rad] for directions on the sky.

        `az`, `el`: from north through east, and elevation [rad], shape (n,).
        `latitude`: of the site [rad].
        `over`: where the mount has turned over, shape (n,).
        Returns `first`, `second`: in [-pi, pi] and, unless turned over, in [-pi/2, pi/2]. On the
          first axis itself, where any first angle would do, that is zero.
        """
        if self.frame is None:
            return az, el
        z, q, p = self.frame(latitude) @ _vectors(az, el)
        across = np.hypot(z, q)
        first = np.where(across < ON_THE_AXIS, 0.0, np.arctan2(q, z))
        return _turned_over(first, np.arctan2(p, across), over)

    def sky(self, first: Array, second: Array, latitude: float = 0.0) -> tuple[Array, Array]:
        """Return azimuth, in [-pi, pi], and elevation [rad] that two axis angles point at."""
        if self.frame is None:
            return first, second
        north, east, up = self.frame(latitude).T @ _vectors(first, second)
        return np.arctan2(east, north), np.arctan2(up, np.hypot(north, east))

    def turn(self, az: Array, el: Array, latitude: float = 0.0) -> Array:
        """Return what turns an offset (across, along) elevation into one along the axes.

        Both are on the sky: across is a step of the first angle times the cosine of the second.
        The matrices, shape (2, 2, n), are orthogonal; of determinant -1 where the mount counts
        one of its angles in the opposite sense. They hold for a mount that has not turned over.
        """
        if self.frame is None:
            return np.broadcast_to(np.eye(2)[:, :, None], (2, 2, len(el)))
        of_sky = _steps(az, el)
        of_axes = _steps(*self.angles(az, el, latitude))
        return np.einsum("aik,ij,bjk->abk", of_axes, self.frame(latitude), of_sky)

    def leans(self, latitude: float = 0.0) -> float:
        """Return the elevation of the first axis [rad]: a quarter turn where it is the vertical."""
        return np.pi / 2 if self.frame is None else float(np.arcsin(self.frame(latitude)[2, 2]))

    def reaches(self, first: Array, second: Array) -> NDArray[np.bool_]:
        """Tell which axis angles are within the limits and outside the blind spot, shape (n,)."""
        inside = (first >= self.first.low) & (first <= self.first.high)
        inside &= (second >= self.second.low) & (second <= self.second.high)
        return np.asarray(inside & (np.cos(second) >= np.sin(self.blind_deg * DEG)))


def turned(across: Array, second: Array) -> Array:
    """Return the turn about the first axis [rad] that moves directions across, x / cos E.

    At the pole of the axis, where no turn does that, it is a quarter turn at most.
    """
    return np.clip(across / np.cos(second), -np.pi / 2, np.pi / 2)


#: Sine of the distance from the first axis at which its angle is no more than rounding.
ON_THE_AXIS = 1e-15


def _turned_over(
    first: Array, second: Array, over: NDArray[np.bool_] | None
) -> tuple[Array, Array]:
    """Return the angles with which a mount that has turned over points the same way."""
    if over is None:
        return first, second
    turned = np.where(first > 0, first - np.pi, first + np.pi)
    return np.where(over, turned, first), np.where(over, np.pi - second, second)


def _vectors(longitude: Array, latitude: Array) -> Array:
    """Return unit vectors of spherical coordinates, shape (3, n)."""
    around, up = np.broadcast_arrays(longitude, latitude)
    return np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])


def _steps(longitude: Array, latitude: Array) -> Array:
    """Return unit vectors toward growing longitude and growing latitude, shape (2, 3, n)."""
    around, up = np.broadcast_arrays(longitude, latitude)
    zero = np.zeros_like(around)
    return np.stack(
        [
            np.stack([-np.sin(around), np.cos(around), zero]),
            np.stack([-np.sin(up) * np.cos(around), -np.sin(up) * np.sin(around), np.cos(up)]),
        ]
    )
