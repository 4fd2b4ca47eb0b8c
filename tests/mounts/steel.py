"""A mount of any kind made of rotations of vectors (east, north, up); it knows nothing of pyport.

Its first axis `p` is fixed to the ground. Turned by nothing the tube looks along `zero`, and the
second axis lies along `zero` x `p`. `sense` is +1 where the first angle grows counterclockwise as
seen from the end of `p`.
"""

from dataclasses import dataclass

import numpy as np

UP = np.array([0.0, 0.0, 1.0])
NORTH, EAST = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])


def turned(vector, about, angle):
    """Return vectors turned about axes, counterclockwise from their ends (Rodrigues)."""
    vector, about = np.broadcast_arrays(vector, about)
    angle = np.reshape(angle, (-1, 1)) if np.ndim(angle) else angle
    along = np.sum(vector * about, axis=-1, keepdims=True)
    cross = np.cross(about, vector)
    return vector * np.cos(angle) + cross * np.sin(angle) + about * along * (1 - np.cos(angle))


@dataclass(frozen=True)
class Steel:
    """Where the axes of a mount point at a latitude."""

    p: np.ndarray
    zero: np.ndarray
    sense: int

    @property
    def quarter(self):
        """Return where the tube looks after a quarter turn of the first axis."""
        return turned(self.zero, self.p, self.sense * np.pi / 2)


def steel(mount, latitude):
    """Return the axes of a mount by its name."""
    sine, cosine = np.sin(latitude), np.cos(latitude)
    return {
        "altaz": Steel(UP, NORTH, -1),
        "equatorial": Steel(np.array([0, cosine, sine]), np.array([0, -sine, cosine]), -1),
        "xy-ns": Steel(NORTH, UP, 1),
        "xy-ew": Steel(EAST, UP, -1),
    }[mount]


def look(axes, first, second, flaws):
    """Return where the beam points, (n, 3), for two axis angles and what is wrong.

    `lean`: how far the first axis leans toward `zero` and toward `quarter`. `skew`: how far the
    end of the second axis that moves forward as the first angle grows is nearer to `p`.
    `collimation`: how far the beam looks backward of the plane. `droop` and `tube_end`: gravity on
    the tube, and on the end of the second axis that is opposite to growing first angles. `fork`:
    how far a fork's end, which holds the second axis, hangs down for gravity square to it.
    """
    ahead = axes.sense * np.cross(axes.p, axes.zero)  # where growing first angles go
    tube = axes.zero + 0 * second[:, None]
    tube = turned(tube, axes.p, -axes.sense * flaws.get("collimation", 0.0))
    hinge = np.cross(axes.zero, axes.p)
    tube = turned(tube, hinge, second)
    of_skew = np.cross(ahead, axes.p)
    tube = turned(tube, of_skew, flaws.get("skew", 0.0))
    tube, side, base = (
        turned(one, axes.p, axes.sense * first) for one in (tube, -ahead, axes.zero)
    )
    of_fork = flaws.get("fork", 0.0) * (base @ UP)
    tube = turned(tube, np.cross(axes.p, -base), of_fork)
    fall = np.cross(side, -UP)
    size = np.linalg.norm(fall, axis=1, keepdims=True)
    tube = turned(tube, fall / size, flaws.get("tube_end", 0.0) * size[:, 0])
    for toward, lean in zip((axes.zero, axes.quarter), flaws.get("lean", (0, 0)), strict=True):
        tube = turned(tube, np.cross(axes.p, toward), lean)
    down = np.cross(tube, -UP)
    size = np.linalg.norm(down, axis=1, keepdims=True)
    return turned(tube, down / size, flaws.get("droop", 0.0) * size[:, 0])


def angles(axes, vector):
    """Return the two angles of a faultless mount that look along vectors (n, 3)."""
    around = np.arctan2(vector @ axes.quarter, vector @ axes.zero)
    return around, np.arcsin(np.clip(vector @ axes.p, -1, 1))


def offsets(axes, az, el, flaws, over=None):
    """Return readings less true angles (across, along) [rad] of beams on az, el.

    The mount has turned over where `over` holds; what its encoders say is turned back before it
    is compared. `read`: axis angles -> how much more both encoders read.
    """
    vector = np.stack([np.cos(el) * np.sin(az), np.cos(el) * np.cos(az), np.sin(el)], axis=1)
    true = angles(axes, vector)
    over = np.zeros(len(az), bool) if over is None else over
    start = np.where(over, true[0] + np.pi, true[0]), np.where(over, np.pi - true[1], true[1])
    first, second = start
    step = 1e-6
    for _ in range(5):
        seen = look(axes, first, second, flaws)
        slopes = [
            (
                look(axes, first + step * i, second + step * j, flaws)
                - look(axes, first - step * i, second - step * j, flaws)
            )
            / (2 * step)
            for i, j in ((1, 0), (0, 1))
        ]
        design = np.stack(slopes, axis=2)
        move = np.linalg.pinv(design) @ (vector - seen)[:, :, None]
        first, second = first + move[:, 0, 0], second + move[:, 1, 0]
    more = flaws.get("read", lambda a, d: (0 * a, 0 * d))(first, second)
    across, along = first + more[0] - start[0], second + more[1] - start[1]
    return across * np.cos(true[1]), np.where(over, -along, along)
