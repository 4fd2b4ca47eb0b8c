"""Which terms are one: their shapes, seen from all over the sky, are parallel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pyport.angles import Array
from pyport.effects import CATALOGUE, Circumstances, Effect, MissingColumn, Site
from pyport.models.terms.shapes import FAMILIES, Shape, Wave, product

#: How far from parallel rounding takes two shapes that are one.
PARALLEL = 1e-9

#: Directions that distinguish shapes, from low to high and all round.
_DIRECTIONS = Circumstances(
    np.linspace(-3.0, 3.1, 37), 0.2 + 1.2 * np.linspace(0, 1, 37) ** 0.5, Site(0.9, 0.3)
)

#: What goes round with azimuth: the axis and what it is multiplied by. A mount turned about the
#: vertical, leaning sideways, leaning backwards.
_ROUND = (("az",), ("xel", Wave("S", "E")), ("el",))


def seen(effect: Effect, column: int = 0) -> Array | None:
    """Return a column of an effect at those directions; None if more than directions shows it."""
    try:
        found = np.concatenate(effect.columns(_DIRECTIONS))[:, column]
    except MissingColumn:
        return None
    return found if found.any() else None


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
    if effect.id not in CATALOGUE:
        return None
    own, k = seen(effect, column), effect.parameter
    if isinstance(k, int) and effect.id not in FAMILIES:
        shapes = [product(axis, Wave(one, "A", k), *more) for axis, *more in _ROUND for one in "SC"]
    else:
        first = Shape(effect.id, 0, int(k or 0) if effect.id in FAMILIES else 0)
        shapes = [replace(first, column=n) for n in range(len(first.parent().coefficients))]
    for shape in shapes:
        times = ratio(own, seen(shape.parent(), shape.column))
        if times:
            return shape, times
    return None
