"""The RT32's exact model: the mount's errors by rotations, no term dropped as small.

Everything here is in the RT32's own frame: azimuth from south through west,
radians. The result equals the published routine Model within rounding. A
direction is written with x toward the azimuth of the tilt, y a quarter turn
further west, z up. The formulae stand here as they are to be read; `swift` has
them as they are computed for many points.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from pyport.angles import Array, wrap
from pyport.pointing import swift
from pyport.pointing.jump import has_jumped

#: (azimuth, altitude, xi, zeta) -> (change of azimuth, altitude that the mount reads), all [rad].
Tilt = Callable[[Array, Array, float, float], tuple[Array, Array]]


def tilted(az_south: Array, altitude: Array, xi: float, zeta: float) -> tuple[Array, Array]:
    """Return the change of azimuth and the altitude that a tilted mount reads [rad].

    Eqs. 1 to 4, as one rotation by eta about the horizontal axis square to the
    tilt. The change of azimuth is the angle between the direction's shadows
    before and after it, so that nothing is lost by subtracting large angles.

    `az_south`, `altitude`: true position [rad]; altitudes beyond 90 deg point in plunge.
    `xi`, `zeta`: tilt of the azimuth axis toward south and toward west [rad].

    Notes
    -----
    In plunge the routine turns the sign of the tilt in altitude; so does this.
    """
    # cos H < 0 marks plunge: the sky is then seen over the shoulder
    facing = np.copysign(1.0, np.cos(altitude))
    toward = np.arctan2(np.sin(zeta), np.sin(xi))  # the alpha of eqs. 3 and 4
    sin_eta = facing * np.hypot(np.sin(xi), np.sin(zeta))
    cos_eta = np.sqrt(1 - sin_eta**2)

    x = np.cos(altitude) * np.cos(az_south - toward)
    y = np.cos(altitude) * np.sin(az_south - toward)
    z = np.sin(altitude)
    x_tilted = x * cos_eta - z * sin_eta
    z_tilted = x * sin_eta + z * cos_eta

    turn = np.arctan2(x * y - x_tilted * y, x * x_tilted + y * y)
    # the tilted mount counts from where it sees the south point: kappa of eq. 1
    sin_a, cos_a = np.sin(toward), np.cos(toward)
    turn += np.arctan2(sin_a * cos_a * (1 - cos_eta), cos_a**2 * cos_eta + sin_a**2)
    return facing * turn, np.arctan2(z_tilted, facing * np.hypot(x_tilted, y))


def skewed(altitude: Array, sigma: float, beta: float) -> tuple[Array, Array]:
    """Return the change of azimuth and the altitude for a skewed axis and an offset beam [rad].

    Eqs. 15 and 16. Within |sigma + beta| of the zenith no setting of the axes
    reaches the source: the azimuth stops a quarter turn away, as in Model.

    `altitude`: altitude that the tilted mount reads [rad].
    `sigma`: skew of the elevation axis, positive when its west end (at azimuth 0) is high [rad].
    `beta`: offset of the beam, positive toward east (at azimuth 0) [rad].
    """
    sin_h, cos_h = np.sin(altitude), np.cos(altitude)
    sin_turn = (np.sin(sigma) * sin_h + np.sin(beta)) / (cos_h * np.cos(sigma))
    turn = np.arcsin(np.clip(sin_turn, -1, 1))
    across = sin_h * np.cos(sigma) + cos_h * np.sin(sigma) * np.sin(turn)
    return turn, np.arctan2(across, cos_h * np.cos(turn))


def exact_offsets(az_south: ArrayLike, altitude: ArrayLike, p: ArrayLike) -> tuple[Array, Array]:
    """Return the RT32's azimuth and altitude offsets, encoder minus true [rad].

    Parameters
    ----------
    az_south
        True azimuth from south through west [rad], any shape, unwrapped.
    altitude
        True altitude [rad], beyond pi/2 in plunge; broadcasts with the azimuth.
    p
        The twelve parameters p1..p12 [rad], shape (12,).

    Returns
    -------
    d_az, d_alt
        Offsets [rad] in the broadcast shape; the azimuth's is of the coordinate,
        not on the sky, within [-pi, pi).

    Notes
    -----
    Borkowski, RT32 Pointing Model (2004), eqs. 1 to 4, 15 to 19, routine Model.
    """
    return swift.exact(az_south, altitude, p)


def formulae(
    az_south: ArrayLike, altitude: ArrayLike, p: ArrayLike, tilt: Tilt = tilted
) -> tuple[Array, Array]:
    """Return the same by the formulae above, however `tilt` says that the tilted axis acts."""
    az_south, altitude = np.broadcast_arrays(
        np.asarray(az_south, dtype=float), np.asarray(altitude, dtype=float)
    )
    az0, alt0, sigma, beta, xi, zeta, sag, sag_sine, sin_2a, cos_2a, nod, jump = np.asarray(p)

    turn_of_tilt, alt_tilted = tilt(az_south, altitude, xi, zeta)
    turn_of_skew, alt_skewed = skewed(alt_tilted, sigma, beta)
    sine, cosine = np.sin(2 * az_south), np.cos(2 * az_south)

    d_az = turn_of_tilt + turn_of_skew + az0 + sin_2a * sine + cos_2a * cosine
    d_alt = (
        (alt_skewed - altitude)
        + alt0
        + sag * np.cos(altitude)
        + sag_sine * np.sin(altitude)
        + nod * sine
        + np.where(has_jumped(az_south, altitude), jump, 0.0)
    )
    return wrap(d_az), d_alt
