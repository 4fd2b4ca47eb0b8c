"""Mean refraction of the atmosphere: the named formulae of the literature.

Each is a function of altitude in degrees that returns arcminutes, as its author
wrote it; some take the true altitude, some the apparent one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pyport.angles import ARCMIN, DEG, Array
from pyport.errors import BadInput

_BENNETT = "Bennett 1982, J. Navigation 35, 255"


def _cot(degrees: Array) -> Array:
    return 1 / np.tan(degrees * DEG)


def _none(altitude_deg: Array) -> Array:
    return np.zeros_like(altitude_deg)


def _sixty_arcsec(altitude_deg: Array) -> Array:
    return _cot(altitude_deg)


def _tan_series(altitude_deg: Array) -> Array:
    tan_z = _cot(altitude_deg)
    return (58.294 * tan_z - 0.0668 * tan_z**3) / 60


def _bennett(altitude_deg: Array) -> Array:
    return _cot(altitude_deg + 7.31 / (altitude_deg + 4.4))


def _bennett_improved(altitude_deg: Array) -> Array:
    arcmin = _bennett(altitude_deg)
    return arcmin - 0.06 * np.sin((14.7 * arcmin + 13) * DEG)


def _saemundsson(altitude_deg: Array) -> Array:
    return 1.02 * _cot(altitude_deg + 10.3 / (altitude_deg + 5.11))


@dataclass(frozen=True)
class Formula:
    """A formula of mean refraction.

    Attributes
    ----------
    name
        How it is asked for.
    citation
        Whose it is.
    arcmin
        Altitude [deg] -> refraction [arcmin].
    of
        "true" or "apparent": the altitude that the formula takes.
    """

    name: str
    citation: str
    arcmin: Callable[[Array], Array]
    of: str


FORMULAE = {
    one.name: one
    for one in (
        Formula("none", "no refraction", _none, "true"),
        Formula("sixty-arcsec", "60 arcsec / tan H: Borkowski 2004", _sixty_arcsec, "true"),
        Formula("tan-series", "Smart, Textbook on Spherical Astronomy", _tan_series, "apparent"),
        Formula("bennett", f"{_BENNETT}, formula G", _bennett, "apparent"),
        Formula("bennett-improved", f"{_BENNETT}, formula H", _bennett_improved, "apparent"),
        Formula("saemundsson", "Saemundsson 1986, Sky & Telescope 72, 70", _saemundsson, "true"),
    )
}


def refraction(name: str, altitude: ArrayLike, iterations: int = 6) -> Array:
    """Return how much higher a source stands than its true altitude [rad].

    Parameters
    ----------
    name
        One of :data:`FORMULAE`.
    altitude
        True altitude [rad], 0 to pi/2, any shape.
    iterations
        How often a formula of the apparent altitude is evaluated anew with the
        altitude that it gave; 0 takes the true altitude for the apparent one.

    Raises
    ------
    BadInput
        There is no formula of this name.
    """
    if name not in FORMULAE:
        raise BadInput(f"no refraction is called {name!r}; there are {', '.join(FORMULAE)}")
    formula = FORMULAE[name]
    altitude_deg = np.asarray(altitude, dtype=float) / DEG
    arcmin = formula.arcmin(altitude_deg)
    if formula.of == "apparent":
        for _ in range(iterations):
            arcmin = formula.arcmin(altitude_deg + arcmin / 60)
    return arcmin * ARCMIN
