"""Refraction by following a ray through layers of air, down to the telescope.

Nothing of cot E is in here: Snell's law in spheres, a troposphere that cools
with height and carries its own weight, vapour that thins faster than air.
"""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.examiner.worlds.earth import EARTH_RADIUS_M
from pyport.examiner.worlds.sky import Air

_ZERO_C_K = 273.15
_LAPSE_K_M = 6.5e-3
_COLDEST_K = 216.65
#: Gravity over the gas constant of dry air. [K/m]
_GRAVITY_K_M = 9.80665 / 287.053
_VAPOUR_HEIGHT_M = 2000.0
_TOP_M = 80e3
_LAYERS = 160


def bending(el: Array, air: Air) -> Array:
    """Return how far the air lifts sources that stand at vacuum elevations, [rad], shape (n,).

    Good where rays meet the layers at an angle, some degrees above the horizon.
    """
    height = _TOP_M * np.linspace(0, 1, _LAYERS + 1) ** 2
    index = 1 + 1e-6 * refractivity(height, air)
    radius = EARTH_RADIUS_M + height
    lift = np.zeros_like(el)
    for _ in range(5):
        # n r sin z is the same all along the ray (Bouguer).
        ray = index[..., :1] * radius[0] * np.cos(el + lift)[:, None]
        sine = ray / (index * radius)
        tangent = sine / np.sqrt(1 - sine**2)
        middle = (tangent[:, 1:] + tangent[:, :-1]) / 2
        lift = np.sum(middle * -np.diff(np.log(index), axis=-1), axis=1)
    return lift


def refractivity(height_m: Array, air: Air) -> Array:
    """Return (n - 1) * 10^6 of air over the telescope, shape (n, heights).

    Constants of Rueger 2002, FIG XXII, "best average"; vapour pressure by Magnus.
    """
    ground_k, pressure, humidity = (
        np.atleast_1d(np.asarray(value, float))[:, None]
        for value in (air.temperature_c + _ZERO_C_K, air.pressure_hpa, air.humidity)
    )
    celsius = ground_k - _ZERO_C_K
    vapour = humidity * 6.112 * np.exp(17.62 * celsius / (243.12 + celsius))
    kelvin = np.maximum(ground_k - _LAPSE_K_M * height_m, _COLDEST_K)
    # Where the air stops cooling its pressure falls exponentially instead of as a power.
    bend_m = np.maximum(ground_k - _COLDEST_K, 0) / _LAPSE_K_M
    cooled = (kelvin / ground_k) ** (_GRAVITY_K_M / _LAPSE_K_M)
    thinned = np.exp(-_GRAVITY_K_M / _COLDEST_K * np.maximum(height_m - bend_m, 0))
    e = vapour * np.exp(-height_m / _VAPOUR_HEIGHT_M)
    dry = (pressure - vapour) * cooled * thinned
    return 77.6890 * dry / kelvin + 71.2952 * e / kelvin + 375463 * e / kelvin**2
