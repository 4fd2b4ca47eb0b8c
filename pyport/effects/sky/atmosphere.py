"""The atmosphere: refraction by dry air, water vapour and the ionosphere.

A formula of the literature is a function of altitude in degrees that returns arcminutes, as its
author wrote it; some take the true altitude, some the apparent one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pyport.angles import ARCMIN, DEG, Array
from pyport.effects.base import SKY, Circumstances, Coefficient, Effect, MissingColumn, stack
from pyport.errors import BadInput

_BENNETT = "Bennett 1982, J. Navigation 35, 255"

#: What formulae with weather in them are given: pressure [hPa], temperature [C], humidity.
STANDARD_AIR = (1010.0, 10.0, 0.5)

#: Degrees in a radian as the RT32's steering table has them: cut short, not rounded.
_SHORT_RADIAN = 57.29


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


def _field_system(altitude_deg: Array) -> Array:
    """Return the Field System's refraction, held below 1 deg, in its own standard weather."""
    altitude_deg = np.maximum(altitude_deg, 1.0)
    pressure_hpa, temperature_c, humidity_pct = 1000.0, 15.0, 50.0
    dryness = 0.9 * (100 - humidity_pct)
    dew_point_c = temperature_c - dryness * (
        0.136667 + 1.33333e-3 * dryness + 1.5e-3 * temperature_c
    )
    vapour_mmhg = np.polynomial.polynomial.polyval(
        dew_point_c, [4.58675, 0.322009, 1.03452e-2, 2.74777e-4, 1.57115e-6]
    )
    kelvin = temperature_c + 273
    refractivity = 77.6 * (pressure_hpa + 4810 * 1.33289 * vapour_mmhg / kelvin) / kelvin
    bend = 0.57295787e-4 * (_cot(altitude_deg) - 42.5 / (altitude_deg + 0.4) ** 2.64)
    return 60 * (bend * refractivity - 40 / (altitude_deg + 2.7) ** 4)


def _erfa_radio(altitude_deg: Array) -> Array:
    """Return A tan z + B tan^3 z with ERFA's constants for radio waves in standard air."""
    import erfa

    a, b = erfa.refco(*STANDARD_AIR, 1e6)
    tan_z = _cot(altitude_deg)
    return (a * tan_z + b * tan_z**3) / ARCMIN


def _rt32_table(altitude_deg: Array) -> Array:
    """Return the refraction in the RT32's 3model table, as recovered from its digits.

    Bennett's improved formula, with three turns of its own: it is evaluated once more
    at the apparent altitude that it gives, its correction comes from the first
    evaluation, and a radian has 57.29 degrees. Near the zenith the formula falls below
    zero; the table holds its magnitude.
    """
    per_radian = _SHORT_RADIAN
    degrees = altitude_deg * DEG * per_radian

    def first_term(h: Array) -> Array:
        return 1 / np.tan((h + 7.31 / (h + 4.4)) / per_radian)

    first = first_term(degrees)
    second = first_term(degrees + first / 60)
    return np.abs(second - 0.06 * np.sin((14.7 * first + 13) / per_radian))


@dataclass(frozen=True)
class Formula:
    """A formula of mean refraction."""

    name: str  #: how it is asked for
    citation: str  #: whose it is
    arcmin: Callable[[Array], Array]  #: altitude [deg] -> refraction [arcmin]
    of: str  #: "true" or "apparent": the altitude that the formula takes


FORMULAE = {
    one.name: one
    for one in (
        Formula("none", "no refraction", _none, "true"),
        Formula("sixty-arcsec", "60 arcsec / tan H: Borkowski 2004", _sixty_arcsec, "true"),
        Formula("tan-series", "Smart, Textbook on Spherical Astronomy", _tan_series, "apparent"),
        Formula("bennett", f"{_BENNETT}, formula G", _bennett, "apparent"),
        Formula("bennett-improved", f"{_BENNETT}, formula H", _bennett_improved, "apparent"),
        Formula("saemundsson", "Saemundsson 1986, Sky & Telescope 72, 70", _saemundsson, "true"),
        Formula("field-system", "Mark IV Field System, function refr", _field_system, "true"),
        Formula("erfa-radio", "ERFA refco, 1010 hPa, 10 C, 50 %", _erfa_radio, "apparent"),
        Formula("rt32-table", f"{_BENNETT}, formula H, as in the 3model", _rt32_table, "true"),
    )
}

#: So many evaluations bring a formula of the apparent altitude to rest above 1 deg.
ITERATIONS = 12


def mean_refraction(name: str, altitude: ArrayLike, iterations: int = ITERATIONS) -> Array:
    """Return how much higher a source stands than its true altitude [rad].

    `name`: one of :data:`FORMULAE`.
    `altitude`: true altitude [rad], 0 to pi/2, any shape.
    `iterations`: how often a formula of the apparent altitude is evaluated anew with the altitude
      that it gave; 0 takes the true altitude for the apparent one.
    Raises `BadInput`: there is no formula of this name.
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


_TOO_MUCH = "more refraction was taken off than there is"
_MANGUM = "Mangum & Wallace 2015, PASP 127, 74"

#: Below this elevation cot E leaves what refraction does; the basis is held there. [rad]
LOWEST_EL = np.radians(0.5)

#: Above this elevation the formulae of refraction differ by less than an arcsecond. [rad]
LOW_EL = np.radians(10)

#: The formulae that hold down to the horizon; the others are r cot E and its cube.
SHAPES = ("bennett", "bennett-improved", "saemundsson", "field-system", "rt32-table")


def cotangent(at: Circumstances) -> Array:
    """Return cot E, held constant in magnitude beyond the horizon's last half degree."""
    el = np.clip(at.el, LOWEST_EL, np.pi - LOWEST_EL)
    return np.cos(el) / np.sin(el)


def refraction(at: Circumstances) -> tuple[Array, Array]:
    """Return r cot E along elevation."""
    return stack(at, (0, cotangent(at)))


def formula_of_refraction(name: str) -> Effect:
    """Return refraction with the shape that a formula of `FORMULAE` gives it.

    The coefficient is the refraction at an elevation of 45 deg, where all of them
    have about an arcminute. Behind the zenith it lifts the other way.
    """

    def basis(at: Circumstances) -> tuple[Array, Array]:
        el = np.clip(at.el, LOWEST_EL, np.pi - LOWEST_EL)
        lift = mean_refraction(name, np.minimum(el, np.pi - el))
        toward = np.where(el > np.pi / 2, -1.0, 1.0)
        return stack(at, (0, toward * lift / mean_refraction(name, np.pi / 4)))

    return Effect(
        "refraction",
        "the constant of atmospheric refraction is wrong, or refraction was left out",
        FORMULAE[name].citation,
        (Coefficient("refraction"),),
        basis,
        formula=("", f"r R(E) / R(45 deg), R by {name}"),
        variant=name,
        profile=_shapes,
        common="array",
        member={"formula": name},
        make=_refraction,
        acts_in=SKY,
        pattern="in elevation, growing toward the horizon",
        reversed=_TOO_MUCH,
    )


def _refraction(formula: str = "") -> Effect:
    """Return refraction by a formula, or r cot E."""
    return formula_of_refraction(formula) if formula else _COTANGENT


def _shapes(at: Circumstances) -> tuple[Effect, ...]:
    """Return r cot E, and every formula where elevations are low enough to distinguish them."""
    low = len(at) > 0 and bool(np.nanmin(np.abs(np.sin(at.el))) < np.sin(LOW_EL))
    return (_COTANGENT, *(formula_of_refraction(name) for name in SHAPES if low))


def refraction_curvature(at: Circumstances) -> tuple[Array, Array]:
    """Return r3 cot^3 E along elevation."""
    return stack(at, (0, cotangent(at) ** 3))


_COTANGENT = Effect(
    "refraction",
    "the constant of atmospheric refraction is wrong, or refraction was left out",
    _MANGUM,
    (Coefficient("refraction"),),
    refraction,
    formula=("", "r cot E"),
    profile=_shapes,
    common="array",
    make=_refraction,
    acts_in=SKY,
    pattern="in elevation, growing toward the horizon",
    reversed=_TOO_MUCH,
)


#: Radius of the Earth, and height of the thin shell that stands for the ionosphere [km].
EARTH_KM, SHELL_KM = 6371.0, 400.0
REFERENCE_MHZ = 1000.0


def vapour_pressure_hpa(at: Circumstances) -> Array:
    """Return the pressure of water vapour [hPa], from humidity and temperature.

    Over water, Buck 1981, J. Appl. Meteorol. 20, 1527 (1996 constants).
    """
    humidity = at.numbers("humidity_pct")
    t = at.numbers("temperature_c")
    return humidity / 100 * 6.1121 * np.exp((18.678 - t / 234.5) * t / (257.14 + t))


def wet_refraction(at: Circumstances) -> tuple[Array, Array]:
    """Return w e cot E along elevation, e the pressure of water vapour in hPa."""
    return stack(at, (0, vapour_pressure_hpa(at) * cotangent(at)))


def ionosphere(at: Circumstances) -> tuple[Array, Array]:
    """Return the lift by a thin shell, tan z sec^2 z at the shell, in units of 1 GHz.

    A plane layer bends the ray back to where it came from; what is left over
    comes from the curvature of the shell, and grows with f^-2.
    """
    sin_z = np.cos(at.el) * EARTH_KM / (EARTH_KM + SHELL_KM)
    cos2_z = 1 - sin_z**2
    lift = sin_z / np.sqrt(cos2_z) / cos2_z
    frequency = at.numbers("frequency_mhz") / REFERENCE_MHZ
    if np.any(frequency <= 0):
        raise MissingColumn("positive frequency_mhz")
    return stack(at, (0, lift / frequency**2))


EFFECTS = (
    _COTANGENT,
    Effect(
        "refraction_curvature",
        "the curvature of atmospheric refraction near the horizon was left out",
        _MANGUM,
        (Coefficient("refraction_curvature"),),
        refraction_curvature,
        formula=("", "r3 cot^3 E"),
        acts_in=SKY,
        pattern="in elevation, near the horizon alone",
        common="array",
    ),
    Effect(
        "wet_refraction",
        "refraction by water vapour was left out",
        "Mangum & Wallace 2015, PASP 127, 74; vapour pressure: Buck 1981",
        (Coefficient("wet_refraction", "arcsec/hPa"),),
        wet_refraction,
        acts_in=SKY,
        pattern="in elevation, growing toward the horizon and with the vapour in the air",
        common="array",
        needs=("humidity_pct", "temperature_c"),
        formula=("", "w e cot E, e the pressure of water vapour"),
        driver="humidity_pct",
    ),
    Effect(
        "ionosphere",
        "refraction by the ionosphere was left out",
        "Thompson, Moran & Swenson 2017, Interferometry and Synthesis, ch. 14",
        (Coefficient("ionosphere_at_1_ghz"),),
        ionosphere,
        acts_in=SKY,
        pattern="in elevation, growing toward the horizon and with the wavelength squared",
        common="array",
        needs=("frequency_mhz",),
        formula=("", "i (f / GHz)^-2 tan z / cos^2 z, z the zenith angle at 400 km"),
    ),
)
