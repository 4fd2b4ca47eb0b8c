"""A telescope as a chain of rotations: two axes that carry a beam, and the encoders that read them.

The chain is written forwards, from the encoders' axes to the sky, as steel is
put together. Which axis angles look at a given direction is found by turning
the axes until the beam arrives there; no small-angle formula is used anywhere.

The dish frame is x to the right, y along the beam, z up, so that at azimuth
zero and elevation zero it is east-north-up.

The columns of a base are not formulae: they are what a mount of rotations does
when one thing in it is askew by a second of arc. In the frame of its first axis
every mount is this chain: what is here called east, north and up are then the
direction of a quarter turn, that of zero, and the axis. Gravity alone knows
where up is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pyport.angles import ARCSEC, Array, wrap


class Base:
    """A base at the pointings of a case, each antenna with its own coefficients.

    `columns`: (x, y) of its terms per radian, shape (n, k) each.
    `antenna`: whose pointings they are.
    `measured`: which rows measured which axis.
    `sigma`: weights by axis [rad].
    """

    def __init__(
        self,
        columns: tuple[Array, Array],
        antenna: NDArray[np.str_],
        measured: tuple[NDArray[np.bool_], NDArray[np.bool_]],
        sigma: tuple[float, float],
    ):
        self.measured, self.sigma = measured, sigma
        own = antenna[:, None] == np.unique(antenna)[None, :]
        spread = [(own[:, :, None] * part[:, None, :]).reshape(len(own), -1) for part in columns]
        left, size, _ = np.linalg.svd(self.stack(*spread), full_matrices=False)
        self._orthonormal = left[:, size > 1e-9 * size[0]]

    def stack(self, x: Array, y: Array) -> Array:
        """Return measured values of both axes, in units of the noise, one after the other."""
        both = zip((x, y), self.measured, self.sigma, strict=True)
        return np.concatenate([part[there] / sigma for part, there, sigma in both])

    def left(self, x: Array, y: Array) -> Array:
        """Return what the base leaves of an offset, stacked."""
        stacked = self.stack(x, y)
        return stacked - self._orthonormal @ (self._orthonormal.T @ stacked)

    def rho(self, x: Array, y: Array, *, projected: bool = True) -> tuple[float, float]:
        """Return the rms over the noise of an offset, per axis, 0 where none was measured.

        With `projected` it is the rms of what the base leaves of it.
        """
        stacked = self.left(x, y) if projected else self.stack(x, y)
        count = int(self.measured[0].sum())
        return _rms(stacked[:count]), _rms(stacked[count:])


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


#: One value for all pointings, or one for each of them.
Each = float | Array


#: One of the two encoders.
Encoder = Literal["az", "el"]


@dataclass(frozen=True)
class Wave:
    """A reading error of one encoder, `sine` sin(k angle) + `cosine` cos(k angle) [rad]."""

    on: Encoder
    of: Encoder
    k: int
    sine: Each
    cosine: Each


@dataclass(frozen=True)
class Mount:
    """Everything that is askew in a telescope; radians, a scalar or one value for each pointing.

    `tilt_north`, `tilt_east`: lean of the azimuth axis.
    `roll`, `pitch`, `yaw`: what the rail does to the platform: right side down, front down, turned
      anticlockwise.
    `skew`: right end of the elevation axis up.
    `sag_cosine`, `sag_sine`: how far the beam droops at the horizon and at the zenith.
    `beam_left`, `beam_down`: where the beam leaves the dish.
    `azimuth_zero`, `elevation_zero`, `azimuth_scale`, `elevation_scale`: encoder readings minus
      axis angles: a constant, and per radian turned.
    `centre_right`, `centre_ahead`: displacement of the azimuth encoder's disc, in units of its
      radius.
    `waves`: harmonics in the readings.

    With these signs each positive value makes the encoder read more than the
    true position needs, wherever the word has a sense.
    """

    tilt_north: Each = 0.0
    tilt_east: Each = 0.0
    roll: Each = 0.0
    pitch: Each = 0.0
    yaw: Each = 0.0
    skew: Each = 0.0
    sag_cosine: Each = 0.0
    sag_sine: Each = 0.0
    beam_left: Each = 0.0
    beam_down: Each = 0.0
    azimuth_zero: Each = 0.0
    elevation_zero: Each = 0.0
    azimuth_scale: Each = 0.0
    elevation_scale: Each = 0.0
    centre_right: Each = 0.0
    centre_ahead: Each = 0.0
    waves: tuple[Wave, ...] = ()

    def plus(self, *waves: Wave, **more: Each) -> Mount:
        """Return the mount with something added to what it already has."""
        sums: dict[str, Any] = {name: getattr(self, name) + value for name, value in more.items()}
        return replace(self, waves=self.waves + waves, **sums)


#: The parts of the classical model, and each of them askew by a second of arc.
CLASSICAL = (
    "azimuth_zero",
    "elevation_zero",
    "beam_left",
    "skew",
    "tilt_north",
    "tilt_east",
    "sag_cosine",
)
BASE = tuple(Mount().plus(**{name: ARCSEC}) for name in CLASSICAL)


def beam(mount: Mount, az: Array, el: Array) -> Array:
    """Return where the beam points, (n, 3) east-north-up, for axis angles [rad] of shape (n,)."""
    forward = np.broadcast_to([0.0, 1.0, 0.0], (*np.shape(el), 3))
    looking = turn(forward, 2, mount.beam_left)
    droop = mount.sag_cosine * np.cos(el) + mount.sag_sine * np.sin(el)
    looking = turn(looking, 0, el - mount.beam_down - droop)
    looking = turn(looking, 1, -np.asarray(mount.skew) + mount.roll)
    looking = turn(looking, 0, -np.asarray(mount.pitch))
    looking = turn(looking, 2, mount.yaw - az)
    north, east = np.broadcast_arrays(mount.tilt_north, mount.tilt_east, az)[:2]
    lean = np.stack([-north, east, np.zeros_like(az)], axis=-1)
    return turn_about(looking, lean)


def axes(mount: Mount, az: Array, el: Array, side: Each = 1.0) -> tuple[Array, Array]:
    """Return the axis angles [rad] at which the beam arrives at a true position.

    `side` is -1 where the mount has turned over. Each pass turns the axes by what is missing; what
    is left shrinks by the size of the misalignment, so eight passes leave nothing that a float can
    hold.
    """
    axis_az = np.where(np.asarray(side) < 0, az + np.pi, az)
    axis_el = np.where(np.asarray(side) < 0, np.pi - el, el)
    target = direction(az, el)
    for _ in range(8):
        missed = target - beam(mount, axis_az, axis_el)
        ahead = missed[..., 0] * np.cos(axis_az) - missed[..., 1] * np.sin(axis_az)
        level = missed[..., 0] * np.sin(axis_az) + missed[..., 1] * np.cos(axis_az)
        rising = missed[..., 2] * np.cos(axis_el) - level * np.sin(axis_el)
        axis_az = axis_az + ahead / np.cos(axis_el)
        axis_el = axis_el + rising
    return axis_az, axis_el


def readings(mount: Mount, axis_az: Array, axis_el: Array) -> tuple[Array, Array]:
    """Return what the encoders say for axis angles [rad]; azimuth unwrapped as it came."""
    off_centre = wrap(
        np.arctan2(
            np.sin(axis_az) - mount.centre_right,
            np.cos(axis_az) - mount.centre_ahead,
        )
        - axis_az
    )
    angle = {"az": axis_az, "el": axis_el}
    error = {
        "az": mount.azimuth_zero + mount.azimuth_scale * axis_az + off_centre,
        "el": mount.elevation_zero + mount.elevation_scale * axis_el,
    }
    for wave in mount.waves:
        phase = wave.k * angle[wave.of]
        error[wave.on] = error[wave.on] + wave.sine * np.sin(phase) + wave.cosine * np.cos(phase)
    return axis_az + error["az"], axis_el + error["el"]


def direction(az: ArrayLike, el: ArrayLike) -> Array:
    """Return unit vectors (n, 3), east-north-up, for azimuth (north through east) and elevation."""
    az, el = np.broadcast_arrays(np.asarray(az, float), np.asarray(el, float))
    return np.stack([np.cos(el) * np.sin(az), np.cos(el) * np.cos(az), np.sin(el)], axis=-1)


def az_el(vector: Array) -> tuple[Array, Array]:
    """Return azimuth (in [-pi, pi]) and elevation of vectors (n, 3) of any length."""
    east, north, up = np.moveaxis(vector, -1, 0)
    return np.arctan2(east, north), np.arctan2(up, np.hypot(east, north))


def turn(vector: Array, axis: int, angle: ArrayLike) -> Array:
    """Return vectors (n, 3) turned right-handedly about a coordinate axis (0, 1 or 2) [rad]."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    cos, sin = np.cos(angle), np.sin(angle)
    turned = vector.copy()
    turned[..., first] = cos * vector[..., first] - sin * vector[..., second]
    turned[..., second] = sin * vector[..., first] + cos * vector[..., second]
    return turned


def turn_about(vector: Array, rotation: Array) -> Array:
    """Return vectors (n, 3) turned about rotation vectors (n, 3), whose lengths are the angles.

    Rodrigues' formula.
    """
    angle = np.linalg.norm(rotation, axis=-1, keepdims=True)
    pole = rotation / np.where(angle > 0, angle, 1.0)
    along = np.sum(pole * vector, axis=-1, keepdims=True) * pole
    across = np.cross(pole, vector)
    return along + np.cos(angle) * (vector - along) + np.sin(angle) * across


def _polar(phi: float) -> Array:
    return np.array([[-1, 0, 0], [0, -np.sin(phi), np.cos(phi)], [0, np.cos(phi), np.sin(phi)]])


#: Latitude -> where a quarter turn, zero and the first axis point, rows east-north-up.
FRAMES: dict[str, Callable[[float], Array]] = {
    "german": _polar,
    "fork": _polar,
    "xy-ns": lambda _: np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]),
    "xy-ew": lambda _: np.array([[0, 1.0, 0], [0, 0, 1], [1, 0, 0]]),
}


@dataclass(frozen=True)
class Stand:
    """How a mount stands: its kind ("altaz" or one of `FRAMES`), and which rows turned it over."""

    kind: str = "altaz"
    latitude: float = 0.0
    side: Each = 1.0  #: -1 where it has turned over: its readings are turned back

    def angles(self, az: Array, el: Array) -> tuple[Array, Array]:
        """Return the two angles [rad] at which a faultless mount looks at directions, (n,) each."""
        if self.kind == "altaz":
            return az, el
        return az_el(direction(az, el) @ FRAMES[self.kind](self.latitude).T)

    def shown(
        self, mount: Mount, az: Array, el: Array, real: tuple[Array, Array] | None = None
    ) -> tuple[Array, Array]:
        """Return readings minus angles on the sky, (x, y) [rad], shape (n,) each.

        `az`, `el`: where the source is believed to be, and where it is if `real` does not say.
        """
        first, second = self.angles(az, el)
        aimed = real or (az, el)
        if self.kind != "altaz":
            # a tube that hangs down looks at a place when it is aimed above it
            hang = mount.sag_cosine * np.cos(aimed[1]) + mount.sag_sine * np.sin(aimed[1])
            mount = replace(mount, sag_cosine=0.0, sag_sine=0.0)
            aimed = self.angles(aimed[0], aimed[1] + hang)
        read = readings(mount, *axes(mount, *aimed, self.side))
        over = np.asarray(self.side) < 0
        x = wrap(read[0] - np.where(over, first + np.pi, first)) * np.cos(second)
        return x, self.side * (read[1] - np.where(over, np.pi - second, second))

    def columns(self, az: Array, el: Array, base: Sequence[Mount] = BASE) -> tuple[Array, Array]:
        """Return (x, y) of the terms of a base per radian, shape (n, k) each."""
        x, y = zip(*(self.shown(one, az, el) for one in base), strict=True)
        return np.stack(x, axis=1) / ARCSEC, np.stack(y, axis=1) / ARCSEC
