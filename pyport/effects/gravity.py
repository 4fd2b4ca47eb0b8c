"""Gravity: how a dish sags as it is lowered."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.effects.base import LASTING, SKY, Circumstances, Coefficient, Effect, stack

_BORKOWSKI = "Borkowski, RT32 Pointing Model (2004), eq. 17 and 19"


def sag_cosine(at: Circumstances) -> tuple[Array, Array]:
    """Return g cos E along elevation: the moment of a weight about the elevation axis."""
    return stack(at, (0, np.cos(at.el)))


def sag_sine(at: Circumstances) -> tuple[Array, Array]:
    """Return h sin E along elevation: the second quadrature of the same moment."""
    return stack(at, (0, np.sin(at.el)))


EFFECTS = (
    Effect(
        "sag_cosine",
        "the structure sags under gravity, most at the horizon",
        _BORKOWSKI,
        (Coefficient("sag_cosine"),),
        sag_cosine,
        formula=("", "g cos E"),
        acts_in=SKY,
        in_arrays=LASTING,
        pattern="in elevation, with the cosine of elevation",
    ),
    Effect(
        "sag_sine",
        "the structure sags under gravity, most at the zenith",
        _BORKOWSKI,
        (Coefficient("sag_sine"),),
        sag_sine,
        formula=("", "h sin E"),
        acts_in=SKY,
        pattern="in elevation, with the sine of elevation",
    ),
)
