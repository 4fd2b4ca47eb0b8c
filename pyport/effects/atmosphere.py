"""The atmosphere: refraction, as r cot E and by the formulae of the literature."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.effects.base import SKY, Circumstances, Coefficient, Effect, stack
from pyport.effects.refraction import FORMULAE
from pyport.effects.refraction import refraction as refraction_by_formula

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
        lift = refraction_by_formula(name, np.minimum(el, np.pi - el))
        toward = np.where(el > np.pi / 2, -1.0, 1.0)
        return stack(at, (0, toward * lift / refraction_by_formula(name, np.pi / 4)))

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
)

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
)
