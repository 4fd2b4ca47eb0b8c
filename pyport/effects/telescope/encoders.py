"""Encoders and the axes that they sit on: eccentricity, harmonics and rates."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pyport.angles import ARCSEC, DEG, Array, wrap
from pyport.effects.base import AXES, Circumstances, Coefficient, Effect, MissingColumn, stack
from pyport.effects.mounts import times

_BORKOWSKI = "Borkowski, RT32 Pointing Model (2004), eq. 18 and 19"
_GREVE = "Greve et al. 1996, Radio Science 31, 1053"
_WALLACE = "Wallace, TPOINT Telescope Pointing Analysis System, standard terms"

#: Harmonic numbers that are tried when none is given.
HARMONICS = range(2, 9)
#: Shortest period of waves that come oftener, whose number is found from the recordings: worms and
#: teeth of large mounts have a degree or two. [deg]
SHORTEST_DEG = 1.0
#: Recordings over half of the circle distinguish all harmonics of azimuth from anything else, those
#: over this much of it some: an X-Y mount turns through no more than 160 deg. [rad]
HALF, COVERAGE = np.radians(180), np.radians(150)
#: The circle is counted in sectors of this width. [rad]
SECTOR = np.radians(10)
#: On a coarse grid the circle is covered where azimuths are no further apart, and a harmonic is
#: resolved by so many of them to a wave. [rad]
APART, TO_A_WAVE = np.radians(60), 4


def harmonics(at: Circumstances) -> list[int]:
    """Return the harmonics of azimuth that the recordings can distinguish.

    Raises `MissingColumn` where they cover too little of the circle.
    """
    az = at.az % (2 * np.pi)
    sectors = len(np.unique(np.floor(az / SECTOR)))
    if sectors * SECTOR >= HALF:
        return list(HARMONICS)
    distinct = np.unique(az)
    gaps = np.diff(distinct, append=distinct[:1] + 2 * np.pi)
    resolved = [k for k in HARMONICS if TO_A_WAVE * k <= sectors]
    if not resolved or gaps[gaps <= APART].sum() < COVERAGE:
        raise MissingColumn("azimuths over 150 deg of the circle")
    return resolved


def _wave(name: str) -> tuple[Coefficient, Coefficient]:
    return Coefficient(f"{name}_sine"), Coefficient(f"{name}_cosine")


def _family(member: Callable[[float], Effect], at: Circumstances) -> tuple[Effect, ...]:
    """Return a member for each harmonic, where there are azimuths enough."""
    return tuple(map(member, harmonics(at)))


def _often(k: float) -> str:
    """Return how often a wave comes: in words, or by its period beyond the harmonics."""
    return times(k) if k <= HARMONICS[-1] else f"a wave of {360 / k:.4g} deg, {k:.5g}"


def _with(axis: str, k: float) -> str:
    """Return what an encoder or drive errs with."""
    if k <= HARMONICS[-1]:
        return f"a harmonic of {axis}"
    return f"a period of {360 / k:.4g} deg, as teeth, a worm, a rack or an encoder's lines do"


def azimuth_eccentricity(at: Circumstances) -> tuple[Array, Array]:
    """Return cos E (sin A, cos A) across."""
    cos_e = np.cos(at.el)
    return stack(at, (cos_e * np.sin(at.az), 0), (cos_e * np.cos(at.az), 0))


def azimuth_harmonics(k: float) -> Effect:
    """Return the k-th harmonic of the azimuth reading: cos E (sin kA, cos kA) across."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        cos_e = np.cos(at.el)
        return stack(at, (cos_e * np.sin(k * at.az), 0), (cos_e * np.cos(k * at.az), 0))

    return Effect(
        "azimuth_harmonics",
        "the azimuth encoder or drive errs with " + _with("azimuth", k),
        _BORKOWSKI,
        _wave("azimuth_harmonic"),
        basis,
        variant=f"k = {k:.5g}",
        profile=lambda at: _family(azimuth_harmonics, at),
        acts_in=AXES,
        pattern=f"{_often(k)} per turn of azimuth, in azimuth alone",
        formula=("cos E (s sin kA + c cos kA), k >= 2", ""),
        parameter=k,
        member={"k": k},
        make=azimuth_harmonics,
    )


def elevation_harmonics(k: float) -> Effect:
    """Return nodding with the k-th harmonic of azimuth: (sin kA, cos kA) along elevation."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        return stack(at, (0, np.sin(k * at.az)), (0, np.cos(k * at.az)))

    return Effect(
        "elevation_harmonics",
        "the telescope nods with a harmonic of azimuth",
        _BORKOWSKI,
        _wave("elevation_harmonic"),
        basis,
        variant=f"k = {k:.5g}",
        profile=lambda at: _family(elevation_harmonics, at),
        acts_in=AXES,
        pattern=f"{_often(k)} per turn of azimuth, in elevation alone",
        means={
            "wheel-and-track": "the track, not level",
            "bearing": "the azimuth bearing, not flat",
        },
        formula=("", "s sin kA + c cos kA, k >= 2"),
        parameter=k,
        member={"k": k},
        make=elevation_harmonics,
    )


def elevation_encoder_harmonics(k: float) -> Effect:
    """Return the k-th harmonic of the elevation reading: (sin kE, cos kE) along elevation."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        return stack(at, (0, np.sin(k * at.el)), (0, np.cos(k * at.el)))

    return Effect(
        "elevation_encoder_harmonics",
        "the elevation encoder or drive errs with " + _with("elevation", k),
        _GREVE,
        _wave("elevation_encoder_harmonic"),
        basis,
        variant=f"k = {k:.5g}",
        profile=lambda _: tuple(map(elevation_encoder_harmonics, HARMONICS)),
        acts_in=AXES,
        pattern=f"{_often(k)} per turn of elevation, in elevation alone",
        formula=("", "s sin kE + c cos kE, k >= 2"),
        parameter=k,
        member={"k": k},
        make=elevation_encoder_harmonics,
    )


def _azimuth_scale(variant: str) -> Effect:
    unwrapped = _CUTS[variant]

    def basis(at: Circumstances) -> tuple[Array, Array]:
        return stack(at, (unwrapped(at.az) * np.cos(at.el), 0))

    return Effect(
        "azimuth_scale",
        "the azimuth reading runs at a wrong rate",
        _WALLACE,
        (Coefficient("azimuth_scale", "arcsec/deg", ARCSEC / DEG),),
        basis,
        variant=variant,
        profile=_azimuth_scales,
        acts_in=AXES,
        pattern="in proportion to azimuth, in azimuth alone",
        means={"cable-wrap": "the wrap that drags"},
        formula=("s A cos E, A unwrapped as the cable is", ""),
        member={"variant": variant},
        make=_azimuth_scale,
    )


def _azimuth_scales(at: Circumstances) -> tuple[Effect, ...]:
    """Return the scale of the azimuth as recorded and, if others may be meant, about the cuts."""
    recorded, *cuts = _CUTS
    axis = (at if at.sky is None else at.sky).mount.first
    if axis.high - axis.low <= 2 * np.pi:  # its angle is never counted on beyond a turn
        return (_azimuth_scale(recorded),)
    chosen = [name for name in cuts if np.ptp(_CUTS[name](at.az) - at.az) > np.pi]
    return tuple(map(_azimuth_scale, (recorded, *chosen)))


#: Where azimuth may be cut open when it was recorded without the turns of the cable.
_CUTS: dict[str, Callable[[Array], Array]] = {
    "azimuth as recorded": lambda az: az,
    "azimuth cut in the south": wrap,
    "azimuth cut in the north": lambda az: az % (2 * np.pi),
}


#: So many rows must stand on each of two turns, in directions that both reach: their scatter is
#: then known to a sixth, and with it what lies between the turns.
ON_A_TURN = 20
#: Where the turns of azimuth are counted from: what a member says, and the azimuth [rad].
_COUNTED = {"turns counted from north": 0.0, "turns counted from south": np.pi}


def turn_of(az: Array, start: float) -> Array:
    """Return the number of the turn that each azimuth [rad] is on, for turns from a start."""
    return np.floor((az - start) / (2 * np.pi))


def _azimuth_turns(variant: str) -> Effect:
    start = _COUNTED[variant]

    def basis(at: Circumstances) -> tuple[Array, Array]:
        return stack(at, (turn_of(at.az, start) * np.cos(at.el), 0))

    return Effect(
        "azimuth_turns",
        "the azimuth zero differs from one turn to the next",
        _WALLACE,
        (Coefficient("azimuth_zero_per_turn"),),
        basis,
        variant=variant,
        profile=_azimuth_turns_tried,
        acts_in=AXES,
        pattern="a step in azimuth from one turn to the next, in azimuth alone",
        means={"cable-wrap": "the wrap that drags, or a count of turns that is off"},
        formula=("a n cos E, n the turn that A is on, unwrapped as the cable is", ""),
        member={"variant": variant},
        make=_azimuth_turns,
    )


def _azimuth_turns_tried(at: Circumstances) -> tuple[Effect, ...]:
    """Return the turns as they may be counted, where directions were measured on two of them."""
    found = [name for name, start in _COUNTED.items() if _twice(at.az, start)]
    if not found:
        raise MissingColumn("azimuths over more than a turn")
    return tuple(map(_azimuth_turns, found))


def _twice(az: Array, start: float) -> bool:
    """Tell whether enough rows stand on each of two turns, in sectors that both reach."""
    turn, sector = turn_of(az, start), np.floor((az - start) % (2 * np.pi) / SECTOR)
    reached = np.unique(np.stack([sector, turn]), axis=1)[0]
    sectors, turns = np.unique(reached, return_counts=True)
    rows = np.unique(turn[np.isin(sector, sectors[turns > 1])], return_counts=True)[1]
    return int(np.count_nonzero(rows >= ON_A_TURN)) > 1


def elevation_scale(at: Circumstances) -> tuple[Array, Array]:
    """Return s E along elevation."""
    return stack(at, (0, at.el))


EFFECTS = (
    Effect(
        "azimuth_eccentricity",
        "the azimuth encoder sits off centre",
        _GREVE,
        _wave("azimuth_eccentricity"),
        azimuth_eccentricity,
        acts_in=AXES,
        pattern="once per turn of azimuth, in azimuth alone",
        formula=("cos E (s sin A + c cos A)", ""),
    ),
    azimuth_harmonics(2),
    elevation_harmonics(2),
    elevation_encoder_harmonics(2),
    _azimuth_scale(next(iter(_CUTS))),
    _azimuth_turns(next(iter(_COUNTED))),
    Effect(
        "elevation_scale",
        "the elevation encoder runs at a wrong rate",
        _WALLACE,
        (Coefficient("elevation_scale", "arcsec/deg", ARCSEC / DEG),),
        elevation_scale,
        acts_in=AXES,
        pattern="in proportion to elevation, in elevation alone",
        formula=("", "s E"),
    ),
)
