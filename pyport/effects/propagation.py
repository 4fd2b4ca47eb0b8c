"""Media that bend the ray beside dry air: water vapour, and the electrons of the ionosphere."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.effects.atmosphere import cotangent
from pyport.effects.base import SKY, Circumstances, Coefficient, Effect, MissingColumn, stack

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
