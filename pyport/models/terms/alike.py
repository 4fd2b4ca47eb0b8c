"""Which terms are one: their shapes, seen from all over the sky, are parallel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pyport.angles import Array
from pyport.effects import Circumstances, Effect, MissingColumn, Site, known
from pyport.models.terms.shapes import FAMILIES, Shape, Wave, product
from pyport.mounts import ALTAZ, BY_MODEL, Mount

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


def shape_of(effect: Effect, column: int = 0) -> tuple[Shape, float] | None:
    """Return which shape of the vocabularies a coefficient is, and how many of it.

    A column of the catalogue's effect of this id, or of an effect that comes with k for the
    harmonic a wave of k times azimuth.
    """
    identity, mount = effect.of or effect.id, _mount_of(effect)
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
