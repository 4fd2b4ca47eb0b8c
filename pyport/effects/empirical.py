"""Shapes without a cause: terms of published models, never the answer of a diagnosis."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.effects.base import SKY, Circumstances, Coefficient, Effect, stack


def hour_angle_wave(at: Circumstances) -> tuple[Array, Array]:
    """Return cos h and sin h along elevation."""
    hour_angle = at.column("hour_angle")
    return stack(at, (0, np.cos(hour_angle)), (0, np.sin(hour_angle)))


EFFECTS = (
    Effect(
        "hour_angle_wave",
        "the elevation offset follows a cosine of hour angle",
        "Lal, Ishwara-Chandra & Rao, The GMRT Antenna Pointing II (2003), section 4",
        (Coefficient("hour_angle_cosine"), Coefficient("hour_angle_sine")),
        hour_angle_wave,
        physical=False,
        acts_in=SKY,
        needs=("hour_angle_h",),
        formula=("", "c cos H + s sin H"),
    ),
)
