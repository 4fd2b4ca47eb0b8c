"""The vocabulary of physics: every cause of a pointing offset, each one small function."""

from __future__ import annotations

from pyport.effects import (
    atmosphere,
    drive,
    empirical,
    encoders,
    epochs,
    geometry,
    gravity,
    site,
    structure,
)
from pyport.effects.base import (
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    Site,
)

#: Every effect of the catalogue by its id.
CATALOGUE: dict[str, Effect] = {
    one.id: one
    for family in (
        geometry,
        gravity,
        encoders,
        site,
        atmosphere,
        drive,
        structure,
        epochs,
        empirical,
    )
    for one in family.EFFECTS
}

__all__ = ["CATALOGUE", "Circumstances", "Coefficient", "Effect", "MissingColumn", "Site"]
