"""How the RT32's exact offsets change with its parameters: eqs. 1 to 4, 15 and 16 differentiated.

Signs and axes as in `exact`: azimuth from south through west, radians. A
horizontal direction is written (south, west).
"""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.pointing.exact import skewed, tilted


def tilt_slopes(
    az_south: Array, altitude: Array, xi: float, zeta: float
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return d(azimuth, altitude) that the tilted mount reads, per radian of xi and of zeta.

    The lean q = (sin xi, sin zeta) turns the horizontal part v of a direction of
    height z into w = v - m q, m = q.v/(1 + c) + z, c the lean's cosine, and its
    height into q.v + z c. Written so nothing is singular where the lean is zero.
    """
    facing = np.copysign(1.0, np.cos(altitude))
    lean = np.sin(xi), np.sin(zeta)
    c = np.sqrt(1 - lean[0] ** 2 - lean[1] ** 2)
    v = np.cos(altitude) * np.cos(az_south), np.cos(altitude) * np.sin(az_south)
    z = np.sin(altitude)
    south = np.ones_like(z), np.zeros_like(z)

    def swung(level: tuple[Array, Array], height: Array, axis: int) -> tuple[Array, Array]:
        """Return the swing of a direction's azimuth per unit of the lean's part, and |w|^2."""
        along = lean[0] * level[0] + lean[1] * level[1]
        m = along / (1 + c) + height
        slope = level[axis] / (1 + c) + along * lean[axis] / c / (1 + c) ** 2
        w = level[0] - m * lean[0], level[1] - m * lean[1]
        d_w = [-slope * lean[0], -slope * lean[1]]
        d_w[axis] = d_w[axis] - m
        square = w[0] ** 2 + w[1] ** 2
        return (w[0] * d_w[1] - w[1] * d_w[0]) / square, square

    slopes = []
    for axis, angle in enumerate((xi, zeta)):
        turn, square = swung(v, facing * z, axis)
        # the mount counts from where it sees the south point
        zero, _ = swung(south, np.zeros_like(z), axis)
        height = (facing * v[axis] - z * lean[axis] / c) / (facing * np.sqrt(square))
        slopes.append((np.cos(angle) * facing * (turn - zero), np.cos(angle) * height))
    return slopes[0], slopes[1]


def skew_slopes(altitude: Array, sigma: float, beta: float) -> tuple[tuple[Array, Array], ...]:
    """Return d(azimuth, altitude) per radian of sigma, of beta and of the altitude read.

    From sin(turn) = (sin sigma sin H + sin beta)/(cos H cos sigma) and
    cos beta sin H" = (sin H + sin sigma sin beta)/cos sigma, eqs. 15 and 16. Where the
    azimuth stops, near the zenith, it changes no more.
    """
    sin_h, cos_h = np.sin(altitude), np.cos(altitude)
    sin_s, cos_s, sin_b, cos_b = np.sin(sigma), np.cos(sigma), np.sin(beta), np.cos(beta)
    turn, _ = skewed(altitude, sigma, beta)
    cos_turn = np.cos(turn)
    stopped = np.abs(np.sin(turn)) >= 1.0
    up = sin_h + sin_s * sin_b
    level = cos_h * np.where(stopped, 1.0, cos_turn)

    d_sine = (
        up / (cos_h * cos_s**2),
        cos_b / (cos_h * cos_s),
        (sin_s + sin_b * sin_h) / (cos_h**2 * cos_s),
    )
    d_up = (
        (sin_b + sin_s * sin_h) / cos_s**2,
        sin_s * cos_b / cos_s + np.tan(beta) * up / cos_s,
        cos_h / cos_s,
    )
    return tuple(
        (np.where(stopped, 0.0, one / np.where(stopped, 1.0, cos_turn)), other / level)
        for one, other in zip(d_sine, d_up, strict=True)
    )


def exact_slopes(az_south: Array, altitude: Array, p: Array) -> dict[int, tuple[Array, Array]]:
    """Return d(d_az, d_alt)/dp for the parameters that the exact form is not linear in.

    Parameters
    ----------
    az_south, altitude
        True position [rad], shape (n,).
    p
        The twelve parameters [rad].

    Returns
    -------
    dict
        Index of the parameter (2 skew, 3 box, 4 and 5 tilt) to its two slopes, shape (n,) each.
    """
    _, read = tilted(az_south, altitude, p[4], p[5])
    by_skew, by_box, by_altitude = skew_slopes(read, p[2], p[3])
    slopes = {2: by_skew, 3: by_box}
    for index, (turn, rise) in zip(
        (4, 5), tilt_slopes(az_south, altitude, p[4], p[5]), strict=True
    ):
        slopes[index] = turn + by_altitude[0] * rise, by_altitude[1] * rise
    return slopes
