"""The vocabulary of physics: every cause of a pointing offset, each one small function."""

from __future__ import annotations

from pyport.effects import (
    astrometry,
    atmosphere,
    drive,
    empirical,
    encoders,
    epochs,
    geometry,
    gravity,
    propagation,
    rail,
    receiver,
    site,
    sources,
    structure,
    thermal,
)
from pyport.effects.base import (
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    Site,
)

#: The families of effects, in the order of the way from the mount to the sky and back.
FAMILIES = (
    geometry,
    gravity,
    encoders,
    rail,
    site,
    astrometry,
    sources,
    atmosphere,
    propagation,
    drive,
    thermal,
    receiver,
    structure,
    epochs,
    empirical,
)

#: Every effect of the catalogue by its id.
CATALOGUE: dict[str, Effect] = {one.id: one for family in FAMILIES for one in family.EFFECTS}

__all__ = [
    "CATALOGUE",
    "FAMILIES",
    "Circumstances",
    "Coefficient",
    "Effect",
    "MissingColumn",
    "Site",
]
