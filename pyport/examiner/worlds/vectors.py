"""Directions as unit vectors, east-north-up, and the turns that take one to another."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pyport.angles import Array


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
