"""The vectorised port as the Fortran is called, and the regions of the ledger of deviations."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from rt32_inputs import MODELA_PLUNGE

from pyport import pointing
from pyport.angles import DEG, Array
from pyport.parity.description import Batch

Real4 = NDArray[np.float32]
Mask = NDArray[np.bool_]

#: Within this of the mount's zenith [rad], 25 arcsec, the azimuth offset has less than REAL*4's
#: digits: DASIN leaves the cosine c of the altitude with an error of 2**-52/c; relative to c that
#: passes 2**-26, a quarter ulp.
ZENITH_RADIUS = 2.0**-13

#: The curve of Hjump may be taken for this much higher or lower [rad]: REAL*4 pi has an error of
#: 1.1e-7, the curve is as high as 112 deg; with the roundings on the way 7e-5 deg at most.
CURVE_WIDTH = 1e-4 * DEG


def exact(az: Real4, alt: Real4, p: Real4) -> tuple[Array, Array]:
    """Return what the exact form answers [deg]; angles in rad, shape (n,), p in deg, (n, 12)."""
    return _offsets(pointing.exact_offsets, az, alt, p)


def approximate(az: Real4, alt: Real4, p: Real4) -> tuple[Array, Array]:
    """Return what the approximate form answers [deg]; arguments as for :func:`exact`."""
    return _offsets(pointing.approximate_offsets, az, alt, p)


def jump(az: Real4, alt: Real4) -> Array:
    """Return 1 above the jump, else 0; for a negative altitude that of the jump [deg]."""
    az_rad, alt_rad = az.astype(float), alt.astype(float)
    jumped = pointing.has_jumped(az_rad, alt_rad).astype(float)
    return np.where(alt_rad < 0, pointing.jump_altitude(az_rad) / DEG, jumped)


def _offsets(
    form: Callable[..., tuple[Array, Array]], az: Real4, alt: Real4, p: Real4
) -> tuple[Array, Array]:
    result = np.empty((2, len(az)))
    sets, which = np.unique(p.view(np.uint32), axis=0, return_inverse=True)
    for number, one in enumerate(sets.view(np.float32).astype(float) * DEG):
        here = which == number
        result[:, here] = form(az[here].astype(float), alt[here].astype(float), one)
    return result[0] / DEG, result[1] / DEG


def at_the_curve(at: Batch, expected: Batch) -> Mask:  # noqa: ARG001 - one signature for all
    """Tell where the altitude is next to the curve of the jump."""
    return (at["alt"] > 0) & (np.abs(at["alt"] - pointing.jump_altitude(at["az"])) <= CURVE_WIDTH)


def between_the_zeniths(at: Batch, expected: Batch) -> Mask:  # noqa: ARG001
    """Tell where the altitude is beyond pi/2, and not beyond ModelA's."""
    return (at["alt"].astype(float) > math.pi / 2) & (at["alt"] <= np.float32(MODELA_PLUNGE))


def in_plunge(at: Batch, expected: Batch) -> Mask:  # noqa: ARG001
    """Tell where ModelA plunges."""
    return at["alt"] > np.float32(MODELA_PLUNGE)


def second_turn(at: Batch, expected: Batch) -> Mask:  # noqa: ARG001
    """Tell where the oracle left the azimuth offset beyond half a turn."""
    return np.abs(expected["daz"]) > np.float32(180)


def at_the_mounts_zenith(at: Batch, expected: Batch) -> Mask:  # noqa: ARG001
    """Tell where the direction is next to the mount's own zenith."""
    az, alt = at["az"].astype(float), at["alt"].astype(float)
    xi, zeta = np.sin(at["p"][:, 4:6].astype(float) * DEG).T
    tilt, toward = np.hypot(xi, zeta), np.arctan2(zeta, xi)
    side = np.copysign(tilt, np.cos(alt))  # in plunge the tilt has the other sign
    sine = np.sqrt(1 - tilt**2) * np.sin(alt) + side * np.cos(alt) * np.cos(toward - az)
    return sine >= math.cos(ZENITH_RADIUS)


def no_number(at: Batch, expected: Batch) -> Mask:  # noqa: ARG001
    """Tell where the oracle's answer is no number."""
    return np.isnan(expected["daz"]) | np.isnan(expected["dalt"])
