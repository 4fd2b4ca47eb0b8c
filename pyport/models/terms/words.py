"""A word: what a program calls a coefficient, which shapes it multiplies, and its unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.effects import Circumstances, Coefficient, Effect
from pyport.effects.base import stack
from pyport.effects.mounts import on
from pyport.models.terms.shapes import PRODUCT, Shape
from pyport.mounts import BY_MODEL

#: Internal units in one of a word's units.
SCALES = {"arcsec": ARCSEC, "deg": DEG, "": 1.0}


@dataclass(frozen=True)
class Word:
    """A program's name for a coefficient."""

    name: str  #: as the program spells it
    #: The shapes that it multiplies, each with a weight; no part means that the program does
    #: nothing with it.
    parts: tuple[tuple[Shape, float], ...]
    unit: str  #: "arcsec", "deg", or "" for a ratio
    #: Of a word without parts: the program takes any value and does nothing with it.
    silent: bool = False
    #: The model of the mounts in whose words it is (`Mount.model`), "" where it has none.
    mount: str = ""
    mounts: tuple[str, ...] = ()  #: the models of the mounts that may have it; empty for all

    def columns(self, at: Circumstances) -> tuple[Array, Array]:
        """Return (x, y), shape (n,) each, for one internal unit of the coefficient."""
        x, y = np.zeros(len(at)), np.zeros(len(at))
        for shape, weight in self.parts:
            own_x, own_y = shape.columns(at)
            x, y = x + weight * own_x, y + weight * own_y
        return x, y

    def effect(self) -> Effect:
        """Return the effect that this word alone is the coefficient of.

        It has the id of the catalogue's effect, so that a diagnosis knows what
        the model has.
        """
        parent = self.parts[0][0].parent()
        if self.mount:
            parent = on(parent, BY_MODEL[self.mount])
        parts = [{**shape.as_stored, "weight": weight} for shape, weight in self.parts]
        several = len({shape.effect for shape, _ in self.parts}) > 1
        return Effect(
            PRODUCT if several else parent.id,
            parent.sentence,
            parent.citation,
            (Coefficient(self.name, self.unit, SCALES[self.unit]),),
            lambda at: stack(at, self.columns(at)),
            common=parent.common,
            physical=parent.physical and not several,
            variant=parent.variant,
            formula=parent.formula,
            parameter=parent.parameter,
            member={"word": self.name, "unit": self.unit, "parts": parts}
            | ({"mount": self.mount} if self.mount else {}),
            mounts=(self.mount,) if self.mount else self.mounts,
            of=parent.of,
        )

    @classmethod
    def of_member(cls, member: Mapping[str, Any]) -> Word:
        """Return the word that an effect's `member` tells.

        Raises `KeyError`, `TypeError`: it tells none.
        """
        parts = [dict(one) for one in member["parts"]]
        weights = [float(one.pop("weight")) for one in parts]
        shapes = [Shape.of(**one) for one in parts]
        if member["unit"] not in SCALES or not parts:
            raise KeyError(member["unit"])
        weighted = tuple(zip(shapes, weights, strict=True))
        return cls(member["word"], weighted, member["unit"], mount=str(member.get("mount", "")))
