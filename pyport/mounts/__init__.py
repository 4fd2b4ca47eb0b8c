"""Mounts: one file a kind, all that are here known by the word of a file's `# mount:`."""

from __future__ import annotations

import importlib
import pkgutil

from pyport.mounts.altaz import ALTAZ
from pyport.mounts.base import Axis, Mount, turned

#: Every mount by its id: a module of this folder that has `MOUNTS` adds its own.
KINDS: dict[str, Mount] = {
    one.id: one
    for module in pkgutil.iter_modules(__path__)
    for one in getattr(importlib.import_module(f"{__name__}.{module.name}"), "MOUNTS", ())
}

#: A mount for each built-in model of the classical terms: the first that has it.
BY_MODEL: dict[str, Mount] = {one.model: one for one in reversed(KINDS.values())}

__all__ = ["ALTAZ", "BY_MODEL", "KINDS", "Axis", "Mount", "turned"]
