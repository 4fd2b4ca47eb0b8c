"""The vectorised port as the Fortran is called, and the regions of the ledger of deviations."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from rt32_inputs import MODELA_PLUNGE

from pyport import pointing
from pyport.angles import DEG, Array
from pyport.parity.described.description import Batch

Real4 = NDArray[np.float32]
Mask = NDArray[np.bool_]

#: Answers this far apart are equal [deg]: `absolute` in parity.toml.
EQUAL_DEG = 2e-10

#: What roundings take from the argument of DASIN next to the mount's zenith: a sum of two products
#: whose factors are rounded too, each time by half a unit of its last place, 2**-54.
ROUNDING = 2.0**-52

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


def asin_shows_in_azimuth(at: Batch, expected: Batch) -> Mask:
    """Tell where what DASIN loses may move the azimuth offset by more than half an ulp."""
    return _shows(_asin_errors(at)[0], expected["daz"])


def asin_shows_in_altitude(at: Batch, expected: Batch) -> Mask:
    """Tell where what DASIN loses may move the altitude offset by more than half an ulp."""
    return _shows(_asin_errors(at)[1], expected["dalt"])


def _shows(error: Array, answer: Real4) -> Mask:
    return error / DEG > np.maximum(EQUAL_DEG, np.spacing(np.abs(answer)) / 2)


def _asin_errors(at: Batch) -> tuple[Array, Array]:
    """Return what the roundings before DASIN may cost the azimuth and the altitude offset [rad].

    At a distance c from the mount's zenith DASIN makes ROUNDING / c of ROUNDING. The arc of skew
    and box offset is the arcsine of a quotient that changes by that times its slope; next to its
    rim, where the quotient is 1, the arcsine makes the square root of it. Both offsets are
    differences of large angles there: the error stays when the angles cancel.
    """
    az, alt = at["az"].astype(float), at["alt"].astype(float)
    sigma, beta, xi, zeta = np.sin(at["p"][:, 2:6].astype(float) * DEG).T
    tilt, toward = np.hypot(xi, zeta), np.arctan2(zeta, xi)
    side = np.copysign(tilt, np.cos(alt))  # in plunge the tilt has the other sign
    upright = np.sqrt(1 - tilt**2)
    x, y, z = np.cos(alt) * np.cos(az - toward), np.cos(alt) * np.sin(az - toward), np.sin(alt)
    sine, c = x * side + z * upright, np.hypot(x * upright - z * side, y)
    with np.errstate(divide="ignore", invalid="ignore"):
        height = ROUNDING / c
        cosine_of_skew = np.sqrt(1 - sigma**2)
        quotient = np.abs((sigma * sine + beta) / (c * cosine_of_skew))
        slope = np.abs((sigma + beta * sine) / (c**2 * cosine_of_skew))
        error = height * slope + ROUNDING * quotient
        ends = np.arcsin(np.clip([quotient - error, quotient + error], -1, 1))
        arc = ends[1] - ends[0]
        # a quarter turn of the azimuth moves the altitude by c
        return height + arc, height + c * arc


def no_number(at: Batch, expected: Batch) -> Mask:  # noqa: ARG001
    """Tell where the oracle's answer is no number."""
    return np.isnan(expected["daz"]) | np.isnan(expected["dalt"])
