"""The vocabulary of physics: every cause of a pointing offset, each one small function."""

from __future__ import annotations

import importlib
from types import ModuleType

from pyport.effects.base import (
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    Site,
)

#: The families of effects, in the order of the way from the mount to the sky and back.
FAMILIES: tuple[ModuleType, ...]

#: Every effect of the catalogue by its id.
CATALOGUE: dict[str, Effect]

_FAMILIES = (
    "geometry",
    "gravity",
    "encoders",
    "rail",
    "site",
    "astrometry",
    "sources",
    "atmosphere",
    "propagation",
    "drive",
    "thermal",
    "receiver",
    "rotation",
    "structure",
    "epochs",
    "driven",
    "empirical",
)


def __getattr__(name: str) -> object:
    """Import the families when the catalogue is asked for: who makes a table needs none."""
    if name not in ("FAMILIES", "CATALOGUE"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    families = tuple(importlib.import_module(f"{__name__}.{one}") for one in _FAMILIES)
    globals()["FAMILIES"] = families
    globals()["CATALOGUE"] = {one.id: one for family in families for one in family.EFFECTS}
    return globals()[name]


__all__ = [
    "CATALOGUE",
    "FAMILIES",
    "Circumstances",
    "Coefficient",
    "Effect",
    "MissingColumn",
    "Site",
]
