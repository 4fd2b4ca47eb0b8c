"""A mount made of rotations, beside which the effects are held; it knows nothing of them.

Vectors are (north, east, up) on the ground and (forward, right, up) on the
mount; axis angles are azimuth from north through east and elevation.
"""

import numpy as np


def rotation(angle, turned, toward):
    """Return the rotations that turn the axis `turned` to the axis `toward`, (n, 3, 3)."""
    angle = np.atleast_1d(angle)
    matrix = np.tile(np.eye(3), (len(angle), 1, 1))
    matrix[:, turned, turned] = matrix[:, toward, toward] = np.cos(angle)
    matrix[:, toward, turned] = np.sin(angle)
    matrix[:, turned, toward] = -np.sin(angle)
    return matrix


FORWARD, RIGHT, UP = NORTH, EAST, _ = range(3)


def nothing(angle):
    """Return zero for every angle."""
    return np.zeros_like(angle)


def encoders(
    az,
    el,
    *,
    read_az=nothing,
    read_el=nothing,
    lean=(0.0, 0.0),
    right_end_up=0.0,
    beam_left=0.0,
    droop=nothing,
    twist=nothing,
    roll=nothing,
    pitch=nothing,
    beam=None,
):
    """Return what the encoders read when the beam is on (az, el), less (az, el).

    Parameters
    ----------
    az, el
        True direction [rad], shape (n,). Flaws are radians, one for all or (n,).
    read_az, read_el
        Axis angle -> how much more the encoder reads.
    lean
        How far the azimuth axis leans toward north and toward east.
    right_end_up
        How much higher the right end of the elevation axis stands.
    beam_left
        How far the beam is left of the perpendicular to the elevation axis.
    droop
        Elevation -> how much lower the beam stands.
    twist, roll, pitch
        Azimuth -> how far the rail turns the mount clockwise, rolls its right
        side up, pitches it forward.
    beam
        Axis elevation -> where the beam leaves the mount, (n, 3), in place of the dish's.

    Returns
    -------
    x, y
        Difference across and along elevation [rad], shape (n,).
    """
    target = np.stack([np.cos(el) * np.cos(az), np.cos(el) * np.sin(az), np.sin(el)], axis=1)
    ground = rotation(lean[0], UP, NORTH) @ rotation(lean[1], UP, EAST)
    axle = rotation(right_end_up, RIGHT, UP)
    of_dish = np.zeros((len(az), 3))
    of_dish[:, FORWARD], of_dish[:, RIGHT] = np.cos(beam_left), -np.sin(beam_left)

    axis_az, axis_el = az.copy(), el.copy()
    for _ in range(60):
        mount = rotation(axis_az + twist(axis_az), FORWARD, RIGHT)
        mount = mount @ rotation(pitch(axis_az), UP, FORWARD) @ rotation(roll(axis_az), RIGHT, UP)
        dish = axle @ rotation(axis_el - droop(axis_el), FORWARD, UP)
        out = np.einsum("nij,nj->ni", dish, of_dish) if beam is None else beam(axis_el)
        missed = target - np.einsum("nij,nj->ni", ground @ mount, out)
        across = -missed[:, NORTH] * np.sin(az) + missed[:, EAST] * np.cos(az)
        up = missed[:, UP] / np.cos(el)
        axis_az, axis_el = axis_az + across / np.cos(el), axis_el + up
        if np.abs(missed).max() < 4e-15:
            break
    else:
        raise AssertionError("the mount did not find its target")
    return (axis_az + read_az(axis_az) - az) * np.cos(el), axis_el + read_el(axis_el) - el


def from_platform(side, forward, up):
    """Return axis elevation -> the beam of a receiver that stands beside the elevation axis.

    A flat mirror that turns with the tube throws the ray from the platform at the right
    (`side` = 1) or left (-1) along the tube; the receiver is off the axis so that its ray leans
    by `forward` and `up` [rad].
    """
    to_side = np.array([0.0, side, 0.0])
    ray = np.array([forward, 0.0, up]) - to_side
    ray /= np.linalg.norm(ray)

    def beam(axis_el):
        tube = np.stack([np.cos(axis_el), np.zeros_like(axis_el), np.sin(axis_el)], axis=1)
        normal = (tube + to_side) / np.sqrt(2)
        return ray - 2 * (normal @ ray)[:, None] * normal

    return beam


def turned(angle, right, up):
    """Return how far right and up an offset is when it is turned counterclockwise, as seen."""
    offset = np.tile([0.0, right, up], (len(angle), 1))
    out = np.einsum("nij,nj->ni", rotation(angle, RIGHT, UP), offset)
    return out[:, RIGHT], out[:, UP]
