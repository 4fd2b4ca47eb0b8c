"""The vocabulary of physics: every cause of a pointing offset, each one small function."""

from __future__ import annotations

import functools
from types import ModuleType

from pyport.effects.base import Circumstances, Coefficient, Effect, MissingColumn, Site
from pyport.mounts import ALTAZ, KINDS, Mount

#: The families of effects, in the order of the way from the mount to the sky and back.
FAMILIES: tuple[ModuleType, ...]

#: Every effect that an alt-azimuth mount may have, by its id.
CATALOGUE: dict[str, Effect]


@functools.cache
def _families() -> tuple[ModuleType, ...]:
    """Import the families, in their order."""
    from pyport.effects import mounts
    from pyport.effects.empirical import drifts, driven, epochs, oscillations
    from pyport.effects.sky import astrometry, atmosphere, site
    from pyport.effects.telescope import (
        drive,
        encoders,
        geometry,
        receiver,
        rotation,
        structure,
        thermal,
        track,
    )

    mount = geometry, encoders, track, mounts
    sky = site, astrometry, atmosphere
    telescope = drive, thermal, receiver, rotation, structure
    return *mount, *sky, *telescope, epochs, drifts, oscillations, driven


def __getattr__(name: str) -> object:
    """Import the families when the catalogue is asked for: who makes a table needs none."""
    if name not in ("FAMILIES", "CATALOGUE"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()["FAMILIES"] = _families()
    globals()["CATALOGUE"] = catalogue(ALTAZ)
    return globals()[name]


@functools.cache
def catalogue(mount: Mount) -> dict[str, Effect]:
    """Return every effect that a mount may have, in its words, by its id."""
    from pyport.effects.mounts import concerns, on

    effects = [one for family in _families() for one in family.EFFECTS if concerns(one, mount)]
    return {one.id: one for one in (on(each, mount) for each in effects)}


def register(effect: Effect) -> None:
    """Add an effect to the catalogue of every mount that has it, as long as the program runs."""
    from pyport.effects.mounts import concerns, on

    for mount in KINDS.values():
        if concerns(effect, mount):
            added = on(effect, mount)
            catalogue(mount)[added.id] = added


def known(name: str) -> Effect | None:
    """Return the effect of an id, in the words of whichever mount has it; None without one."""
    return next((had[name] for mount in KINDS.values() if name in (had := catalogue(mount))), None)


__all__ = [
    "CATALOGUE",
    "FAMILIES",
    "Circumstances",
    "Coefficient",
    "Effect",
    "MissingColumn",
    "Site",
    "catalogue",
    "known",
    "register",
]
