"""Waves: smooth shapes in elevation, in azimuth and over the sky, from slow to quick.

A misfit that has no name can still be predicted if it is smooth. It is drawn as a sum
of waves whose heights are shrunk the more the quicker they are: a normal prior whose
variance falls with frequency as a bell curve's transform does makes the sum a smooth
random curve of a certain length (Solin & Sarkka 2020, Statistics and Computing 30, 419).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pyport.angles import DEG, Array
from pyport.effects.base import Circumstances

#: Waves in elevation stand between these: a little beyond what a telescope can see. [rad]
LOW, HIGH = -10 * DEG, 100 * DEG
#: So many waves: in elevation alone, in azimuth alone, and of each in products over the sky.
UP, AROUND, SKY_UP, SKY_AROUND = 16, 8, 8, 5


@dataclass(frozen=True)
class Family:
    """Waves that share a height and a length."""

    name: str  #: what they follow
    place: slice  #: where their columns stand among all waves
    frequency: Array  #: how quick each is in each direction, shape (K, L) [1/rad]
    #: The usual length of what is left of pointing in each direction, shape (L,) [rad].
    length: tuple[float, ...]

    def spectrum(self, log_length: Array) -> tuple[Array, Array]:
        """Return log-variances (K,) that add up to one, and their slopes by log-length (K, L)."""
        steep = (np.exp(log_length) * self.frequency) ** 2
        log = -steep.sum(axis=1) / 2
        log = log - np.logaddexp.reduce(log)
        return log, np.exp(log) @ steep - steep


def _families() -> tuple[Family, ...]:
    up: Array = np.pi * np.arange(1.0, UP + 1) / (HIGH - LOW)
    around: Array = np.repeat(np.arange(1.0, AROUND + 1), 2)
    both = np.meshgrid(around[: 2 * SKY_AROUND], up[:SKY_UP], indexing="ij")
    first, second = len(up), len(up) + len(around)
    last = second + both[0].size
    return (
        Family("elevation", slice(0, first), up[:, None], (12 * DEG,)),
        Family("azimuth", slice(first, second), around[:, None], (40 * DEG,)),
        Family(
            "the sky",
            slice(second, last),
            np.stack([one.ravel() for one in both], axis=1),
            (40 * DEG, 30 * DEG),
        ),
    )


FAMILIES = _families()
COUNT = FAMILIES[-1].place.stop


def columns(at: Circumstances) -> Array:
    """Return all waves at n pointings, shape (n, COUNT)."""
    up = np.cos(np.pi * np.arange(1, UP + 1) / (HIGH - LOW) * (at.el[:, None] - LOW))
    turns = np.arange(1, AROUND + 1) * at.az[:, None]
    around = np.stack([np.cos(turns), np.sin(turns)], axis=2).reshape(len(at), -1)
    sky = around[:, : 2 * SKY_AROUND, None] * up[:, None, :SKY_UP]
    # A wave has a mean square of one half, a product of two one of a quarter.
    return np.concatenate(
        [up * np.sqrt(2), around * np.sqrt(2), 2 * sky.reshape(len(at), -1)], axis=1
    )
