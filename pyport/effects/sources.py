"""Sources: positions of a catalogue that are wrong, targets that are near."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array
from pyport.effects.astrometry import parallactic
from pyport.effects.base import SKY, Basis, Circumstances, Coefficient, Effect, MissingColumn, stack
from pyport.effects.celestial import hour_angle

#: A source tells its position when it was seen at so many hour angles, this far apart. [rad]
ENOUGH_HOUR_ANGLES = 3
APART = 1 * DEG
#: So many single sources are tried by themselves, those that were observed most.
MOST_SOURCES = 20

#: Names under which observers record what is near enough to have a parallax.
SOLAR_SYSTEM = frozenset(
    {
        *("sun", "moon", "mercury", "venus", "mars", "jupiter", "saturn", "uranus", "neptune"),
        *("pluto", "ceres", "pallas", "juno", "vesta"),
    }
)


def _source_position(
    basis: Basis,
    coefficients: tuple[Coefficient, ...] = (),
    variant: str = "every source",
    sources: Sequence[str] = (),
) -> Effect:
    return Effect(
        "source_position",
        "the catalogue's position of a source is wrong",
        "Smart, Textbook on Spherical Astronomy, ch. II: the parallactic angle",
        coefficients,
        basis,
        common="array",
        variant=variant,
        profile=_source_positions,
        acts_in=SKY,
        pattern=f"an offset of {variant} on the sky",
        belongs_to="source",
        needs=("source", "latitude_deg"),
        formula=("-e cos q + n sin q, shifted by e eastward, n northward", "e sin q + n cos q"),
        member={"sources": list(sources), "variant": variant} if sources else {},
        make=_shifted,
    )


def _shifted(sources: Sequence[str], variant: str) -> Effect:
    """Return a shift in right ascension and declination of each of some sources."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        east, north = parallactic(at)
        source = at.column("source")
        pairs = [
            (np.where(source == name, x, 0.0), np.where(source == name, y, 0.0))
            for name in sources
            for x, y in (east, north)
        ]
        return stack(at, *pairs)

    axes = ("ra_cos_dec", "dec")
    coefficients = tuple(Coefficient(f"{axis}[{name}]") for name in sources for axis in axes)
    return _source_position(basis, coefficients, variant, sources)


def _source_positions(at: Circumstances) -> tuple[Effect, ...]:
    """Return a wrong position of each source that moved over the sky, and of all of them.

    One source alone cannot tell: its shift is taken for the mount's.
    """
    names = _moving(at)
    single = [_shifted([name], name) for name in names[:MOST_SOURCES]]
    if len(names) <= MOST_SOURCES:
        return _shifted(sorted(names), "every source"), *single
    return tuple(single)


def _moving(at: Circumstances) -> list[str]:
    """Name the sources seen at several hour angles, the one observed most first."""
    names, source, count = np.unique(at.column("source"), return_inverse=True, return_counts=True)
    if len(names) < 2:
        raise MissingColumn("a second source")
    steps = np.round(hour_angle(at) / APART)
    places = np.unique(np.stack([source, steps]), axis=1)[0].astype(int)
    enough = np.bincount(places, minlength=len(names)) >= ENOUGH_HOUR_ANGLES
    order = np.argsort(-count, kind="stable")
    moving = [str(names[k]) for k in order if enough[k] and names[k] != ""]
    if not moving:
        raise MissingColumn("a source at three hour angles")
    return moving


def _every_source(at: Circumstances) -> tuple[Array, Array]:
    return _source_positions(at)[0].basis(at)


def _near(at: Circumstances) -> NDArray[np.bool_]:
    """Tell which rows may have a parallax: solar-system targets, or all where none is named."""
    if "source" not in at or np.all(at.column("source") == ""):
        return np.ones(len(at), bool)
    near = np.isin(np.char.lower(at.column("source").astype(str)), sorted(SOLAR_SYSTEM))
    if not near.any():
        raise MissingColumn("a solar-system target")
    return near


def parallax(at: Circumstances) -> tuple[Array, Array]:
    """Return -HP cos E along elevation: what is near stands lower than from the Earth's centre."""
    return stack(at, (0, np.where(_near(at), -np.cos(at.el), 0.0)))


EFFECTS = (
    _source_position(_every_source),
    Effect(
        "parallax",
        "the target is near and its parallax was left out",
        "Smart, Textbook on Spherical Astronomy, ch. IX: geocentric parallax",
        (Coefficient("horizontal_parallax"),),
        parallax,
        acts_in=SKY,
        pattern="in elevation, with the cosine of elevation, for near targets",
        common="array",
        formula=("", "-HP cos E"),
    ),
)
