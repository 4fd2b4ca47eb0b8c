"""The twelve parameters of the RT32's models: what they mean, and their published values.

The table "RT32 Model3 parameters (without refraction)" of Borkowski, RT32
Pointing Model (2004): 3684 points of 2003 and 2004, rms 12.8 arcsec.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pyport.angles import DEG, Array
from pyport.pointing.compiled import RECOVERED_DEG

#: Half a unit of the last digit that the parameters are printed to [rad].
PRINTED_ROUNDING = 0.5e-6 * DEG


@dataclass(frozen=True)
class Rt32Parameter:
    """One of p1..p12.

    `name`: what it is, in the words of the published table.
    `printed_deg`, `printed_sigma_deg`: value and standard error in degrees, digit for digit as
      printed.
    `effect`, `column`: the effect that it is the coefficient of, and which of its columns.
    `sign`: what the coefficient must be multiplied with when azimuth is counted from north through
      east: -1 for what points south or west.
    """

    name: str
    printed_deg: str
    printed_sigma_deg: str
    effect: str
    column: int = 0
    sign: int = 1


#: p1..p12, in order.
PARAMETERS = (
    Rt32Parameter("Zero Az", "-0.049282", "0.000528", "azimuth_zero"),
    Rt32Parameter("Zero Alt", "-0.059632", "0.003008", "elevation_zero"),
    Rt32Parameter("Skew", "0.009452", "0.000702", "skew"),
    Rt32Parameter("Box", "-0.013255", "0.000835", "collimation"),
    Rt32Parameter("Tilt South", "0.001393", "0.000056", "tilt", 0, -1),
    Rt32Parameter("Tilt West", "-0.000304", "0.000057", "tilt", 1, -1),
    Rt32Parameter("Sag", "0.031273", "0.002407", "sag_cosine"),
    Rt32Parameter("Ad hoc Alt (sin Alt)", "0.011458", "0.001949", "sag_sine"),
    Rt32Parameter("Ad hoc Az (sin 2Az)", "-0.011751", "0.000094", "azimuth_harmonics", 0),
    Rt32Parameter("Ad hoc Az (cos 2Az)", "0.004539", "0.000083", "azimuth_harmonics", 1),
    Rt32Parameter("Ad hoc Alt (sin 2Az)", "0.004291", "0.000123", "elevation_harmonics", 0),
    Rt32Parameter("Alt jump", "-0.020392", "0.000621", "subreflector_jump"),
)


def printed() -> Array:
    """Return the published values of p1..p12 [rad], shape (12,)."""
    return np.array([float(one.printed_deg) for one in PARAMETERS]) * DEG


def recovered() -> Array:
    """Return p1..p12 with the digits that the print left out, from the printed table [rad]."""
    return np.array(RECOVERED_DEG) * DEG


def printed_sigmas() -> Array:
    """Return the published standard errors of p1..p12 [rad], shape (12,)."""
    return np.array([float(one.printed_sigma_deg) for one in PARAMETERS]) * DEG
