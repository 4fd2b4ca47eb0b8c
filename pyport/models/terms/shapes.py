"""The shapes that terms have on the sky: one column of an effect, or a product of waves.

A wave is "S" or "C" (sine or cosine) of a multiple of "A" (azimuth from north
through east) or of "E". Products that the catalogue knows under a name of its
own are given by that name, so that two programs' words for one thing are one shape.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pyport.angles import Array
from pyport.effects import Circumstances, Coefficient, Effect, MissingColumn, Site, known
from pyport.effects.base import AXES, stack
from pyport.effects.telescope.encoders import (
    azimuth_harmonics,
    elevation_encoder_harmonics,
    elevation_harmonics,
)
from pyport.mounts import ALTAZ, BY_MODEL, Mount

#: The id of a product of waves that no effect of the catalogue has.
PRODUCT = "wave_product"

#: Effects that come as a family, with k for the harmonic: sine in column 0, cosine in 1.
FAMILIES: dict[str, Callable[[int], Effect]] = {
    "azimuth_harmonics": azimuth_harmonics,
    "elevation_harmonics": elevation_harmonics,
    "elevation_encoder_harmonics": elevation_encoder_harmonics,
}


class Wave(NamedTuple):
    """Sine ("S") or cosine ("C") of k times azimuth ("A") or elevation ("E").

    Or the k-th power ("P") of elevation or zenith distance ("Z") in radians.
    """

    function: str
    of: str
    k: int = 1

    def __call__(self, at: Circumstances) -> Array:
        """Return the wave at the pointings, shape (n,)."""
        if self.function == "P":
            return np.asarray((np.pi / 2 - at.el if self.of == "Z" else at.el) ** self.k)
        angle = self.k * (at.az if self.of == "A" else at.el)
        return np.sin(angle) if self.function == "S" else np.cos(angle)

    def __str__(self) -> str:
        """Return it as a formula: `sin 2A`."""
        if self.function == "P":
            return self.of if self.k == 1 else f"{self.of}^{self.k}"
        return f"{'sin' if self.function == 'S' else 'cos'} {self.k if self.k > 1 else ''}{self.of}"


@dataclass(frozen=True)
class Shape:
    """What one coefficient multiplies."""

    effect: str  #: an id of the catalogue, or `PRODUCT`
    column: int = 0  #: which of the effect's coefficients
    k: int = 0  #: which harmonic of a family; 0 where there is no choice
    #: `axis`, `waves`: of a product: "az" (a coordinate, times cos E on the sky), "xel" or "el",
    #: and the factors.
    axis: str = ""
    waves: tuple[Wave, ...] = ()

    @classmethod
    def of(
        cls,
        effect: str,
        column: int = 0,
        k: int = 0,
        axis: str = "",
        waves: Sequence[Sequence[Any]] = (),
    ) -> Shape:
        """Return the shape that `as_stored` gave."""
        return cls(effect, column, k, axis, tuple(Wave(*one) for one in waves))

    @property
    def as_stored(self) -> dict[str, Any]:
        """Return it as a file holds it."""
        whole = {
            "effect": self.effect,
            "column": self.column,
            "k": self.k,
            "axis": self.axis,
            "waves": [list(one) for one in self.waves],
        }
        return {key: value for key, value in whole.items() if value}

    def parent(self) -> Effect:
        """Return the effect that this is a column of."""
        if self.effect == PRODUCT:
            return _product(self.axis, self.waves)
        if self.k:
            return FAMILIES[self.effect](self.k)
        effect = known(self.effect)
        if effect is None:
            raise KeyError(self.effect)
        return effect

    def columns(self, at: Circumstances) -> tuple[Array, Array]:
        """Return (x, y), shape (n,) each, for one internal unit of the coefficient."""
        x, y = self.parent().columns(at)
        return x[:, self.column], y[:, self.column]

    @property
    def formula(self) -> str:
        """Return what it adds to the offsets, as text."""
        return _FORMULA.get((self.effect, self.column)) or _wave_formula(*wave_product(self))


def _product(axis: str, waves: tuple[Wave, ...]) -> Effect:

    def basis(at: Circumstances) -> tuple[Array, Array]:
        value = np.prod([wave(at) for wave in waves], axis=0)
        if axis == "el":
            return stack(at, (0, value))
        return stack(at, (value * (np.cos(at.el) if axis == "az" else 1.0), 0))

    return Effect(
        PRODUCT,
        "the offset follows a product of waves of azimuth and elevation",
        "Wallace, TPOINT Telescope Pointing Analysis System, harmonics",
        (Coefficient("wave_product"),),
        basis,
        physical=False,
        variant=_wave_formula(axis, waves),
        acts_in=AXES,
    )


#: Products of waves with a name in the catalogue.
_KNOWN: dict[tuple[str, tuple[Wave, ...]], Shape] = {
    ("az", (Wave("S", "A"),)): Shape("azimuth_eccentricity", 0),
    ("az", (Wave("C", "A"),)): Shape("azimuth_eccentricity", 1),
    ("xel", (Wave("S", "E"),)): Shape("skew"),
    ("xel", (Wave("C", "E"),)): Shape("azimuth_zero"),
    ("el", (Wave("S", "E"),)): Shape("sag_sine"),
    ("el", (Wave("C", "E"),)): Shape("sag_cosine"),
}
_WAVES_OF = {shape: product for product, shape in _KNOWN.items()}

#: The families: axis and angle -> effect.
_FAMILY = {
    ("az", "A"): "azimuth_harmonics",
    ("el", "A"): "elevation_harmonics",
    ("el", "E"): "elevation_encoder_harmonics",
}
_ANGLE_OF = {effect: place for place, effect in _FAMILY.items()}

_FORMULA = {
    ("azimuth_zero", 0): "x = cos E",
    ("elevation_zero", 0): "y = 1",
    ("collimation", 0): "x = 1",
    ("skew", 0): "x = sin E",
    ("tilt", 0): "x = sin E sin A, y = cos A",
    ("tilt", 1): "x = -sin E cos A, y = sin A",
    ("refraction", 0): "y = cot E",
    ("elevation_scale", 0): "y = E",
    ("azimuth_scale", 0): "x = A cos E",
    ("nasmyth", 0): "x = cos E, y = sin E",
    ("nasmyth", 1): "x = -sin E, y = cos E",
}


def product(axis: str, *waves: Wave) -> Shape:
    """Return the shape of a product of waves, under the catalogue's name where it has one."""
    known = _KNOWN.get((axis, waves))
    if known is not None:
        return known
    if len(waves) == 1 and waves[0].function != "P" and (axis, waves[0].of) in _FAMILY:
        function, of, k = waves[0]
        return Shape(_FAMILY[axis, of], 0 if function == "S" else 1, k)
    return Shape(PRODUCT, axis=axis, waves=waves)


def wave_product(shape: Shape) -> tuple[str, tuple[Wave, ...]]:
    """Return the axis and waves that make a shape; no waves where it is no such product."""
    if shape.effect == PRODUCT:
        return shape.axis, shape.waves
    if shape.k:
        axis, of = _ANGLE_OF[shape.effect]
        return axis, (Wave("SC"[shape.column], of, shape.k),)
    return _WAVES_OF.get(shape, ("", ()))


def _wave_formula(axis: str, waves: tuple[Wave, ...]) -> str:
    text = " ".join(map(str, waves))
    return f"y = {text}" if axis == "el" else f"x = {text}{' cos E' if axis == 'az' else ''}"


#: How far from parallel rounding takes two shapes that are one.
PARALLEL = 1e-9

#: Directions that distinguish shapes, from low to high and all round.
_DIRECTIONS = Circumstances(
    np.linspace(-3.0, 3.1, 37), 0.2 + 1.2 * np.linspace(0, 1, 37) ** 0.5, Site(0.9, 0.3)
)

#: What goes round with azimuth: the axis and what it is multiplied by. A mount turned about the
#: vertical, leaning sideways, leaning backwards.
_ROUND = (("az",), ("xel", Wave("S", "E")), ("el",))


def seen(effect: Effect, column: int = 0, mount: Mount | None = None) -> Array | None:
    """Return a column of an effect at those directions; None if more than directions shows it.

    On a mount that the effect concerns where none is given.
    """
    at = replace(_DIRECTIONS, mount=mount or _mount_of(effect))
    try:
        found = np.concatenate(effect.columns(at))[:, column]
    except MissingColumn:
        return None
    return found if found.any() else None


def _mount_of(effect: Effect) -> Mount:
    return BY_MODEL[effect.mounts[0]] if effect.mounts else ALTAZ


def ratio(one: Array | None, other: Array | None) -> float:
    """Return how many of another shape one is, 0 where they are not parallel."""
    if one is None or other is None:
        return 0.0
    lengths = float(np.linalg.norm(one) * np.linalg.norm(other))
    product = float(one @ other)
    if abs(abs(product) / lengths - 1) > PARALLEL:
        return 0.0
    return product / float(other @ other)


def shape_of(effect: Effect, column: int) -> tuple[Shape, float] | None:
    """Return which shape of the vocabularies a coefficient is, and how many of it.

    A column of the catalogue's effect of this id, or of an effect that comes with k for the
    harmonic a wave of k times azimuth.
    """
    identity, mount = effect.on_altaz, _mount_of(effect)
    if known(identity) is None:
        return None
    own, k = seen(effect, column), effect.parameter
    if isinstance(k, int) and identity not in FAMILIES:
        shapes = [product(axis, Wave(one, "A", k), *more) for axis, *more in _ROUND for one in "SC"]
    else:
        first = Shape(identity, 0, int(k or 0) if identity in FAMILIES else 0)
        shapes = [replace(first, column=n) for n in range(len(first.parent().coefficients))]
    for shape in shapes:
        times = ratio(own, seen(shape.parent(), shape.column, mount))
        if times:
            return shape, times
    return None
