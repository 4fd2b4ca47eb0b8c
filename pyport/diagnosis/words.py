"""Plain words: what an observer would write in the logbook."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pyport.angles import ARCSEC, handy
from pyport.diagnosis.finding import Parameter, Where
from pyport.effects.base import Effect
from pyport.effects.mounts import meaning
from pyport.mounts import ALTAZ

if TYPE_CHECKING:
    from pyport.diagnosis.identify import Name
    from pyport.fitting.combinations import Combination

UNKNOWN = "something is left that no effect of the catalogue explains"
WATCH = "look at the region and the column that it follows, and record what changes there"
#: Longer lists are cut short in a sentence; the report has them whole.
_SHOWN = 6


def since(effect: Effect) -> str | None:
    """Return when a step happened, as ISO 8601 UTC; None for an effect that is no step in time."""
    if effect.changes_with != "session" or effect.parameter is None:
        return None
    return f"{np.datetime64(round(effect.parameter), 's')}Z"


def number(parameter: Parameter) -> str:
    """Return a value with its error, the digits that the error allows, in a handy unit."""
    value, sigma, unit = parameter.value, parameter.sigma, parameter.unit
    if unit == "arcsec":
        radians, unit = handy(abs(value) * ARCSEC)
        value, sigma = value / (radians / ARCSEC), sigma / (radians / ARCSEC)
    digits = 3 if sigma <= 0 else max(0, min(6, 1 - int(np.floor(np.log10(sigma)))))
    return f"{value:.{digits}f} +- {sigma:.{digits}f} {unit}"


def sentence(
    effect: Effect,
    parameters: Sequence[Parameter],
    where: Where,
    together: Combination | None = None,
    mounts: tuple[str, ...] = (),
    names: tuple[str, str] = ALTAZ.names,
) -> str:
    """Return what the recordings show of an effect, how large, and what that means.

    `together` is the combination in which its coefficients are known, if none is known alone;
    `mounts` is what was declared of the mount, `names` what it calls its axes.
    """
    called = dict(zip(("xel", "el"), names, strict=True))
    axes = " and ".join(called[axis] for axis in where.axes)
    said = f"{effect.pattern or effect.sentence} (seen in {axes})"
    cause = meaning(effect, mounts)
    if together is not None:
        return f"{said}: {cause}; {together.sentence}"
    sizes = [f"{p.name.replace('_', ' ')} {number(p)}" for p in parameters[:_SHOWN]]
    more = f" and {len(parameters) - _SHOWN} more" if len(parameters) > _SHOWN else ""
    return f"{said}, {', '.join(sizes)}{more}: {cause}"


def common(effect: Effect, parameters: Sequence[Parameter], *, several: bool) -> str:
    """Return a sentence about what all antennas share."""
    sizes = ", ".join(f"{p.name.replace('_', ' ')} {number(p)}" for p in parameters)
    how = "by one amount in each session" if several else "by the same amount"
    return f"{_shown(effect)}, for all antennas {how}: {sizes}"


def own(
    effect: Effect, parameters: Sequence[Parameter], standing: Sequence[str], antennas: int
) -> str:
    """Return a sentence about what each antenna has of its own."""
    shown = [p for p in parameters if any(p.name.endswith(f"[{name}]") for name in standing)]
    low, high = min(shown, key=lambda p: p.value), max(shown, key=lambda p: p.value)
    return (
        f"{_shown(effect)}, each antenna by its own amount ({len(standing)} of {antennas} beyond "
        f"three sigmas), from {number(low)} in {_inside(low)} to {number(high)} in {_inside(high)}"
    )


def _shown(effect: Effect) -> str:
    """Return what recordings show of an effect, and its cause."""
    return f"{effect.pattern}: {effect.sentence}" if effect.pattern else effect.sentence


def _inside(parameter: Parameter) -> str:
    return parameter.name.rpartition("[")[2].rstrip("]")


def looks_like(effect: Effect, called: Name) -> str:
    """Describe a shape that has no name, with the nearest effect."""
    shape = effect.variant or effect.id
    runner = called.runner_up
    nearest = "" if runner is None else f"; the nearest effect is {runner.candidate.effect.id}"
    return f"{effect.sentence} ({shape}){nearest}"
