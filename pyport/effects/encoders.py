"""Encoders and the axes that they sit on: harmonics of azimuth and of elevation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pyport.angles import Array
from pyport.effects.base import Circumstances, Coefficient, Effect, MissingColumn, stack

_BORKOWSKI = "Borkowski, RT32 Pointing Model (2004), eq. 18 and 19"
_GREVE = "Greve et al. 1996, Radio Science 31, 1053"

#: Harmonic numbers that are tried when none is given.
HARMONICS = range(2, 9)
#: A harmonic of azimuth can be told from anything else only over this much of the circle. [rad]
COVERAGE = np.radians(180)
#: The circle is counted in sectors of this width. [rad]
SECTOR = np.radians(10)


def _need_azimuths(at: Circumstances) -> None:
    """Raise `MissingColumn` unless the recordings cover enough of the circle."""
    sectors = np.unique(np.floor((at.az % (2 * np.pi)) / SECTOR))
    if len(sectors) * SECTOR < COVERAGE:
        raise MissingColumn("azimuths over half of the circle")


def _wave(name: str) -> tuple[Coefficient, Coefficient]:
    return Coefficient(f"{name}_sine"), Coefficient(f"{name}_cosine")


def _family(member: Callable[[int], Effect], at: Circumstances) -> tuple[Effect, ...]:
    """Return a member for each harmonic, where there are azimuths enough."""
    _need_azimuths(at)
    return tuple(map(member, HARMONICS))


def azimuth_eccentricity(at: Circumstances) -> tuple[Array, Array]:
    """Return cos E (sin A, cos A) across."""
    cos_e = np.cos(at.el)
    return stack(at, (cos_e * np.sin(at.az), 0), (cos_e * np.cos(at.az), 0))


def azimuth_harmonics(k: int) -> Effect:
    """Return the k-th harmonic of the azimuth reading: cos E (sin kA, cos kA) across."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        cos_e = np.cos(at.el)
        return stack(at, (cos_e * np.sin(k * at.az), 0), (cos_e * np.cos(k * at.az), 0))

    return Effect(
        "azimuth_harmonics",
        "the azimuth encoder or drive errs with a harmonic of azimuth",
        _BORKOWSKI,
        _wave("azimuth_harmonic"),
        basis,
        variant=f"k = {k}",
        profile=lambda at: _family(azimuth_harmonics, at),
    )


def elevation_harmonics(k: int) -> Effect:
    """Return nodding with the k-th harmonic of azimuth: (sin kA, cos kA) along elevation."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        return stack(at, (0, np.sin(k * at.az)), (0, np.cos(k * at.az)))

    return Effect(
        "elevation_harmonics",
        "the telescope nods with a harmonic of azimuth",
        _BORKOWSKI,
        _wave("elevation_harmonic"),
        basis,
        variant=f"k = {k}",
        profile=lambda at: _family(elevation_harmonics, at),
    )


EFFECTS = (
    Effect(
        "azimuth_eccentricity",
        "the azimuth encoder sits off centre",
        _GREVE,
        _wave("azimuth_eccentricity"),
        azimuth_eccentricity,
    ),
    azimuth_harmonics(2),
    elevation_harmonics(2),
)
