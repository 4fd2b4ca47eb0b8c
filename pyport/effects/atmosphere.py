"""The atmosphere: refraction."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.effects.base import Circumstances, Coefficient, Effect, stack

_MANGUM = "Mangum & Wallace 2015, PASP 127, 74"

#: Below this elevation cot E leaves what refraction does; the basis is held there. [rad]
LOWEST_EL = np.radians(0.5)


def cotangent(at: Circumstances) -> Array:
    """Return cot E, held constant in magnitude beyond the horizon's last half degree."""
    el = np.clip(at.el, LOWEST_EL, np.pi - LOWEST_EL)
    return np.cos(el) / np.sin(el)


def refraction(at: Circumstances) -> tuple[Array, Array]:
    """Return r cot E along elevation."""
    return stack(at, (0, cotangent(at)))


def refraction_curvature(at: Circumstances) -> tuple[Array, Array]:
    """Return r3 cot^3 E along elevation."""
    return stack(at, (0, cotangent(at) ** 3))


EFFECTS = (
    Effect(
        "refraction",
        "the constant of atmospheric refraction is wrong, or refraction was left out",
        _MANGUM,
        (Coefficient("refraction"),),
        refraction,
        formula=("", "r cot E"),
        common="array",
    ),
    Effect(
        "refraction_curvature",
        "the curvature of atmospheric refraction near the horizon was left out",
        _MANGUM,
        (Coefficient("refraction_curvature"),),
        refraction_curvature,
        formula=("", "r3 cot^3 E"),
        common="array",
    ),
)
