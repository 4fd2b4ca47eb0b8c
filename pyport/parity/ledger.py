"""The ledger of deviations: where the published routines leave their own equations, and why.

``deviations.toml`` has a row for each cause: an input, the routine's answer and the true value.
A region says at which points a cause is at work: there the vectorised port, which follows the
equations, may leave the routines by more than their own spread.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG
from pyport.parity.answers import OUTPUTS
from pyport.parity.edges import MODELA_PLUNGE
from pyport.parity.points import Points, Real4
from pyport.pointing import jump_altitude

#: Within this of the mount's zenith [rad], 25 arcsec, the azimuth offset has less than REAL*4's
#: digits: DASIN leaves the cosine c of the altitude with an error of 2**-52/c; relative to c that
#: passes 2**-26, a quarter ulp.
ZENITH_RADIUS = 2.0**-13

Mask = NDArray[np.bool_]

#: The curve of Hjump may be taken for this much higher or lower [rad]: REAL*4 pi has an error of
#: 1.1e-7, the curve is as high as 112 deg; with the roundings on the way 7e-5 deg at most.
CURVE_WIDTH = 1e-4 * DEG


@dataclass(frozen=True)
class Deviation:
    """One cause: what `routine` does for the example, and what its equations say.

    `az`, `alt` [rad], `p` [deg] and `oracle` [deg] are hexadecimal literals of REAL*4, `true` [deg]
    a decimal number. `port` says whom the vectorised port follows, "true" or "oracle".
    """

    id: str
    routine: str
    output: str
    fortran: str
    cause: str
    port: str
    az: str
    alt: str
    p: tuple[str, ...]
    oracle: str
    true: str

    @property
    def column(self) -> int:
        """Return the column of the output in an array of answers."""
        return OUTPUTS.index((self.routine, self.output))


def deviations() -> list[Deviation]:
    """Read the ledger."""
    text = Path(__file__).with_name("deviations.toml").read_text(encoding="utf-8")
    return [Deviation(**{**row, "p": tuple(row["p"])}) for row in tomllib.loads(text)["deviation"]]


def _at_the_curve(at: Points, expected: Real4) -> Mask:  # noqa: ARG001 - one signature for all
    return (at.alt > 0) & (np.abs(at.alt - jump_altitude(at.az)) <= CURVE_WIDTH)


def _between_the_zeniths(at: Points, expected: Real4) -> Mask:  # noqa: ARG001
    return (at.alt.astype(float) > math.pi / 2) & (at.alt <= np.float32(MODELA_PLUNGE))


def _in_plunge(at: Points, expected: Real4) -> Mask:  # noqa: ARG001
    return at.alt > np.float32(MODELA_PLUNGE)


def _second_turn(at: Points, expected: Real4) -> Mask:  # noqa: ARG001
    return np.abs(expected[:, 0]) > np.float32(180)


def _at_the_mounts_zenith(at: Points, expected: Real4) -> Mask:  # noqa: ARG001
    az, alt = at.az.astype(float), at.alt.astype(float)
    xi, zeta = np.sin(at.p[:, 4:6].astype(float) * DEG).T
    tilt, toward = np.hypot(xi, zeta), np.arctan2(zeta, xi)
    side = np.copysign(tilt, np.cos(alt))  # in plunge the tilt has the other sign
    sine = np.sqrt(1 - tilt**2) * np.sin(alt) + side * np.cos(alt) * np.cos(toward - az)
    return sine >= math.cos(ZENITH_RADIUS)


def _no_number(at: Points, expected: Real4) -> Mask:  # noqa: ARG001
    return np.any(np.isnan(expected), axis=1)


#: Entry of the ledger -> where it is at work, and the columns of the answers that it touches.
REGIONS: dict[str, tuple[Callable[[Points, Real4], Mask], tuple[int, ...]]] = {
    "curve-in-single": (_at_the_curve, (1, 3, 4)),
    "zenith-in-single": (_between_the_zeniths, (3,)),
    "turn-in-single": (_in_plunge, (3,)),
    "wrapped-once": (_second_turn, (0,)),
    "asin-near-zenith": (_at_the_mounts_zenith, (0, 1)),
    "tilted-zenith": (_no_number, (0, 1)),
}


def explained(at: Points, expected: Real4) -> dict[str, Mask]:
    """Return for each region which of the oracle's answers it explains, shape (n, 5)."""
    masks = {}
    for name, (region, columns) in REGIONS.items():
        masks[name] = np.zeros(expected.shape, dtype=bool)
        masks[name][:, columns] = region(at, expected)[:, None]
    return masks
