"""The mount's geometry and gravity: encoder zeros, collimation, skew, tilt and sag."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.effects.base import AXES, LASTING, SKY, ZERO, Circumstances, Coefficient, Effect, stack

_FIELD_SYSTEM = "Himwich, Mark IV Field System documentation, Pointing Model (1993)"


def azimuth_zero(at: Circumstances) -> tuple[Array, Array]:
    """Return a cos E across."""
    return stack(at, (np.cos(at.el), 0))


def elevation_zero(at: Circumstances) -> tuple[Array, Array]:
    """Return a constant along elevation."""
    return stack(at, (0, 1))


def collimation(at: Circumstances) -> tuple[Array, Array]:
    """Return a constant across."""
    return stack(at, (1, 0))


def skew(at: Circumstances) -> tuple[Array, Array]:
    """Return c sin E across."""
    return stack(at, (np.sin(at.el), 0))


def tilt(at: Circumstances) -> tuple[Array, Array]:
    """Return the lean of the azimuth axis toward north and toward east.

    A lean t toward azimuth A0 gives t sin E sin(A - A0) across and
    t cos(A - A0) along elevation; its components are t cos A0, t sin A0.
    """
    sin_a, cos_a, sin_e = np.sin(at.az), np.cos(at.az), np.sin(at.el)
    return stack(at, (sin_e * sin_a, cos_a), (-sin_e * cos_a, sin_a))


#: What differs between nights without saying anything of the telescope: refitted on another one.
NIGHTLY = ("azimuth_zero", "elevation_zero", "collimation")


_BORKOWSKI = "Borkowski, RT32 Pointing Model (2004), eq. 17 and 19"


def sag_cosine(at: Circumstances) -> tuple[Array, Array]:
    """Return g cos E along elevation: the moment of a weight about the elevation axis."""
    return stack(at, (0, np.cos(at.el)))


def sag_sine(at: Circumstances) -> tuple[Array, Array]:
    """Return h sin E along elevation: the second quadrature of the same moment."""
    return stack(at, (0, np.sin(at.el)))


EFFECTS = (
    Effect(
        "azimuth_zero",
        "the azimuth encoder's zero is off",
        _FIELD_SYSTEM,
        (Coefficient("azimuth_zero"),),
        azimuth_zero,
        acts_in=AXES,
        in_arrays=ZERO,
        pattern="a constant in azimuth",
        formula=("a cos E", ""),
    ),
    Effect(
        "elevation_zero",
        "the elevation encoder's zero is off",
        _FIELD_SYSTEM,
        (Coefficient("elevation_zero"),),
        elevation_zero,
        acts_in=AXES,
        in_arrays=ZERO,
        pattern="a constant in elevation",
        formula=("", "e"),
    ),
    Effect(
        "collimation",
        "the beam is not perpendicular to the elevation axis",
        _FIELD_SYSTEM,
        (Coefficient("collimation"),),
        collimation,
        acts_in=AXES,
        in_arrays=LASTING,
        pattern="a constant across the sky, the same at all elevations",
        means={"receiver-boxes": "a box beside its place"},
        formula=("b", ""),
    ),
    Effect(
        "skew",
        "the elevation axis is not perpendicular to the azimuth axis",
        _FIELD_SYSTEM,
        (Coefficient("skew"),),
        skew,
        acts_in=AXES,
        in_arrays=LASTING,
        pattern="in cross-elevation, growing with the sine of elevation",
        formula=("c sin E", ""),
    ),
    Effect(
        "tilt",
        "the azimuth axis leans",
        _FIELD_SYSTEM,
        (Coefficient("tilt_north"), Coefficient("tilt_east")),
        tilt,
        acts_in=AXES,
        in_arrays=LASTING,
        pattern="once per turn of azimuth, in both axes",
        formula=("n sin E sin A - e sin E cos A", "n cos A + e sin A"),
    ),
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
        means={"nasmyth": "a mirror, receiver or camera off the elevation axis"},
    ),
)
