"""What a hidden cause is to the examiner: a way to spoil a world by any amount."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pyport.angles import ARCSEC
from pyport.examiner.worlds.world import World


@dataclass(frozen=True)
class Fault:
    """One hidden cause, its shape drawn, its size still open."""

    effect: str  #: its name in the catalogue of effects, or "unknown" where it is in none
    apply: Callable[[World, float], World]  #: (world, size) -> the world with it
    unit: str = "arcsec"  #: what a size of 1 is
    pilot: float = 30.0  #: a size at which its offsets are of the order of half a minute of arc
    #: True where nature gives the size (1), so that the noise has to be scaled instead.
    fixed: bool = False
    #: Names that no recordings of this plan can distinguish from it, besides its own.
    same: tuple[str, ...] = ()
    #: Names that may rightly be spoken as well, because they are part of it.
    beside: tuple[str, ...] = ()
    #: Where it shows, as a report would say it: axes, subset, region, curve, since.
    where: dict[str, Any] = field(default_factory=dict)
    facts: dict[str, Any] = field(default_factory=dict)  #: what was drawn
    #: Coefficients as the catalogue names them, for each unit of size.
    parameters: dict[str, float] = field(default_factory=dict)


Draw = Callable[[World, np.random.Generator], Fault]


def on_mount(effect: str, axes: tuple[str, ...], parts: dict[str, Any], **more: Any) -> Fault:  # noqa: ANN401 - the rest of a Fault
    """Return a fault that adds `parts` (per arcsecond of size) to fields of the mount."""

    def apply(world: World, size: float) -> World:
        return world.with_mount(**{name: size * ARCSEC * value for name, value in parts.items()})

    where = {"axes": list(axes), **more.pop("where", {})}
    return Fault(effect, apply, where=where, **more)


def phase(rng: np.random.Generator) -> tuple[float, float, float]:
    """Return a random angle [rad], its sine and its cosine."""
    angle = rng.uniform(0, 2 * np.pi)
    return angle, float(np.sin(angle)), float(np.cos(angle))
