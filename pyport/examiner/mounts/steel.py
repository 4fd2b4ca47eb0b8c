"""Mounts of any axes as a chain of rotations, from encoders to the sky.

In the frame of its first axis every mount is the chain of `worlds.mount`: what is there called
east, north and up are the direction of a quarter turn, that of zero, and the axis itself. Gravity
alone knows where up is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from pyport.angles import Array
from pyport.examiner.worlds.mount import Each, Mount, az_el, beam, direction, readings

#: Latitude -> where a quarter turn, zero and the first axis point, rows east-north-up.
FRAMES: dict[str, Callable[[float], Array]] = {
    "equatorial": lambda phi: np.array(
        [[-1, 0, 0], [0, -np.sin(phi), np.cos(phi)], [0, np.cos(phi), np.sin(phi)]]
    ),
    "xy-ns": lambda _: np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]),
    "xy-ew": lambda _: np.array([[0, 1.0, 0], [0, 0, 1], [1, 0, 0]]),
}
#: The frame of each mount that is drawn.
FRAME = {"german": "equatorial", "fork": "equatorial", "xy-ns": "xy-ns", "xy-ew": "xy-ew"}


@dataclass(frozen=True)
class Flaws:
    """What is wrong; radians."""

    mount: Mount = field(default_factory=Mount)  #: in the frame of the first axis
    droop: float = 0.0  #: how far gravity pulls the tube down at the horizon
    fork: float = 0.0  #: how far a fork hangs down, in which the tube looks up
    tube_end: float = 0.0  #: how far the end of the second axis that carries the tube hangs down
    #: Zeros of both encoders, plus on one side of the pier and minus on the other.
    pier: tuple[Each, Each] = (0.0, 0.0)


def axes_of(kind: str, latitude: float, az: Array, el: Array) -> tuple[Array, Array]:
    """Return the two angles [rad] at which a faultless mount looks at directions, shape (n,)."""
    return az_el(direction(az, el) @ FRAMES[FRAME[kind]](latitude).T)


def offsets(
    kind: str, latitude: float, at: tuple[Array, Array], side: Array, flaws: Flaws
) -> Array:
    """Return readings less true angles on the sky (across, along) [rad], shape (n, 2).

    `kind`, `latitude`: which mount, and where it stands.
    `at`: azimuths and elevations that the beam is on, shape (n,) each.
    `side`: -1 where the mount has turned over, shape (n,). Its readings are turned back before they
      are compared.
    `flaws`: what is wrong.
    """
    az, el = at
    true_first, true_second = axes_of(kind, latitude, az, el)
    # a tube that hangs down looks at a place when it is aimed above it
    first, second = axes_of(kind, latitude, az, el + flaws.droop * np.cos(el))
    sent_first = np.where(side < 0, first + np.pi, first)
    sent_second = np.where(side < 0, np.pi - second, second)
    target = direction(first, second)
    bent = flaws.mount.plus(
        beam_down=-flaws.fork * np.cos(sent_first), beam_left=flaws.tube_end * np.sin(el)
    )
    axis_first, axis_second = sent_first.copy(), sent_second.copy()
    for _ in range(8):
        missed = target - beam(bent, axis_first, axis_second)
        ahead = missed[:, 0] * np.cos(axis_first) - missed[:, 1] * np.sin(axis_first)
        level = missed[:, 0] * np.sin(axis_first) + missed[:, 1] * np.cos(axis_first)
        rising = missed[:, 2] * np.cos(axis_second) - level * np.sin(axis_second)
        axis_first = axis_first + ahead / np.cos(axis_second)
        axis_second = axis_second + rising
    read_first, read_second = readings(bent, axis_first, axis_second)
    across = read_first + side * flaws.pier[0] - np.where(side < 0, true_first + np.pi, true_first)
    along = read_second + side * flaws.pier[1]
    along = along - np.where(side < 0, np.pi - true_second, true_second)
    return np.stack([across * np.cos(true_second), side * along], axis=1)
