"""Hidden causes by name: of the catalogue, and outside it."""

from __future__ import annotations

from pyport.examiner.worlds.faults import (
    heavens,
    mount,
    occasions,
    surroundings,
    uncatalogued,
)
from pyport.examiner.worlds.faults.surroundings import Draw, Fault

#: Causes that the catalogue of effects names, by its names ("ut1" is a `clock`, a
#: "wandering_oscillation" an `oscillation`).
CATALOGUED: dict[str, Draw] = {
    **mount.FAULTS,
    **heavens.FAULTS,
    **surroundings.MOVING,
    **surroundings.FAULTS,
    **surroundings.TIMES,
}

#: Causes that act at times, in places, on conditions, and those of other mounts.
OCCASIONAL: dict[str, Draw] = {**occasions.FAULTS, **mount.TURNED}

#: Causes that no catalogue names, and the twenty forms among them.
UNCATALOGUED: dict[str, Draw] = uncatalogued.FAULTS
UNKNOWN = tuple(uncatalogued.UNKNOWN)

ALL: dict[str, Draw] = {**CATALOGUED, **OCCASIONAL, **UNCATALOGUED}

#: Causes that the altaz base swallows whole, or all but: hidden only from a model that is held.
SWALLOWED = (
    "azimuth_zero",
    "elevation_zero",
    "collimation",
    "skew",
    "tilt",
    "sag_cosine",
    "site_latitude",
    "site_longitude",
    "clock",
    "ut1",
    "polar_motion",
)

#: Causes that are smaller than what any of these telescopes measures.
TOO_SMALL = ("diurnal_aberration",)

__all__ = [
    "ALL",
    "CATALOGUED",
    "OCCASIONAL",
    "SWALLOWED",
    "TOO_SMALL",
    "UNCATALOGUED",
    "UNKNOWN",
    "Draw",
    "Fault",
]
