"""Instruments that do not turn with the sky as the mount does: by how much the field turns.

An angle here turns an offset (across, along the second axis) on the sky into the frame of the
instrument, counterclockwise as seen from inside the sphere.
"""

from __future__ import annotations

from pyport.angles import Array


def nasmyth(field: Array, second: Array, side: int) -> Array:
    """Return the angle of a field on a platform [rad], shape (n,).

    `field` is the parallactic angle, `second` the angle of the second axis, `side` +1 for the
    platform at the right of who looks along the beam, -1 for the left one.
    """
    return field + side * second


def k_mirror(field: Array, mirror: Array) -> Array:
    """Return the angle of a field behind a K-mirror that stands at `mirror` [rad].

    Three reflections turn the image by twice the angle of the mirror, and over.
    """
    return 2 * mirror - field


def k_mirror_still(field: Array) -> Array:
    """Return where a K-mirror must stand for a field to stand still [rad]."""
    return field / 2
