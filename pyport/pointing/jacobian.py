"""How the RT32's exact offsets change with its parameters: eqs. 1 to 4, 15 and 16 differentiated.

Signs and axes as in `exact`: azimuth from south through west, radians. A
horizontal direction is written (south, west).
"""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.pointing.leaning import Axis

#: d(azimuth, altitude) per radian of something.
Slopes = tuple[Array, Array]


def tilt_slopes(
    az: Axis, alt: Axis, xi: float, zeta: float
) -> tuple[Slopes, Slopes, tuple[Array, Array]]:
    """Return d(azimuth, altitude) that the tilted mount reads, per radian of xi and of zeta.

    And sine and cosine of that altitude.

    The lean q = (sin xi, sin zeta) turns the horizontal part v of a direction of
    height z into w = v - m q, m = q.v/(1 + c) + z, c the lean's cosine, and its
    height into q.v + z c. Written so nothing is singular where the lean is zero.
    """
    facing = np.copysign(1.0, alt.cosine)
    v = alt.cosine * az.cosine, alt.cosine * az.sine
    lean = float(np.sin(xi)), float(np.sin(zeta))
    c = float(np.sqrt(1 - lean[0] ** 2 - lean[1] ** 2))
    swings, square = _swings(v, facing * alt.sine, lean, c)
    sine = c * alt.sine + facing * (lean[0] * v[0] + lean[1] * v[1])
    # the mount counts from where it sees the south point
    zeros, _ = _swings((np.ones(()), np.zeros(())), np.zeros(()), lean, c)
    level = facing * np.sqrt(square)
    slopes = []
    for axis, angle in enumerate((xi, zeta)):
        turn = facing * (swings[axis] - zeros[axis])
        height = (facing * v[axis] - alt.sine * (lean[axis] / c)) / level
        slopes.append((np.cos(angle) * turn, np.cos(angle) * height))
    return slopes[0], slopes[1], (sine, level)


def _swings(
    level: tuple[Array, Array], height: Array, lean: tuple[float, float], c: float
) -> tuple[list[Array], Array]:
    """Return the swing of a direction's azimuth per unit of the lean's two parts, and |w|^2."""
    along = lean[0] * level[0] + lean[1] * level[1]
    m = along / (1 + c) + height
    w = level[0] - m * lean[0], level[1] - m * lean[1]
    square = w[0] * w[0] + w[1] * w[1]
    # w turns by w x dw / |w|^2, dw = -slope q, less m along the part that changes
    across = (w[0] * lean[1] - w[1] * lean[0]) / square
    aside = m / square
    swings = []
    for axis, sign in ((0, 1.0), (1, -1.0)):
        slope = level[axis] / (1 + c) + along * (lean[axis] / c / (1 + c) ** 2)
        swings.append(sign * w[1 - axis] * aside - slope * across)
    return swings, square


def skew_slopes(sine: Array, cosine: Array, sigma: float, beta: float) -> tuple[Slopes, ...]:
    """Return d(azimuth, altitude) per radian of sigma, of beta and of the altitude read.

    From sin(turn) = (sin sigma sin H + sin beta)/(cos H cos sigma) and
    cos beta sin H" = (sin H + sin sigma sin beta)/cos sigma, eqs. 15 and 16, `sine` and
    `cosine` being those of H. Where the azimuth stops, near the zenith, it changes no more.
    """
    sin_s, cos_s, sin_b, cos_b = np.sin(sigma), np.cos(sigma), np.sin(beta), np.cos(beta)
    sin_turn = (sin_s * sine + sin_b) / (cosine * cos_s)
    stopped = np.abs(sin_turn) >= 1.0
    cos_turn = np.sqrt(np.where(stopped, 1.0, 1 - sin_turn * sin_turn))
    up = sine + sin_s * sin_b
    level = cosine * cos_turn
    turn_by = np.where(stopped, 0.0, 1 / (cos_s * level))
    return (
        (turn_by * up / cos_s, (sin_b + sin_s * sine) / (cos_s**2 * level)),
        (turn_by * cos_b, (sin_s * cos_b / cos_s + np.tan(beta) / cos_s * up) / level),
        (turn_by * (sin_s + sin_b * sine) / cosine, cosine / (cos_s * level)),
    )


def exact_slopes(az: Axis, alt: Axis, p: Array) -> dict[int, Slopes]:
    """Return d(d_az, d_alt)/dp for the parameters that the exact form is not linear in.

    `az`, `alt`: true positions, azimuth from south, shape (n,).
    `p`: the twelve parameters [rad].
    Returns by the index of the parameter (2 skew, 3 box, 4 and 5 tilt) its two slopes, (n,) each.
    """
    *by_tilt, read = tilt_slopes(az, alt, p[4], p[5])
    by_skew, by_box, by_altitude = skew_slopes(*read, p[2], p[3])
    slopes = {2: by_skew, 3: by_box}
    for index, (turn, rise) in zip((4, 5), by_tilt, strict=True):
        slopes[index] = turn + by_altitude[0] * rise, by_altitude[1] * rise
    return slopes
