"""Plain words: what an observer would write in the logbook."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pyport.angles import ARCSEC, decimals, handy
from pyport.diagnosis.disagreements import Disagreement, Halves
from pyport.diagnosis.naming.finding import Parameter, Where
from pyport.effects.base import Effect
from pyport.effects.circumstances import utc
from pyport.effects.empirical.drivers import unit_in_words
from pyport.effects.mounts import meaning
from pyport.fitting.two_axes import Difference
from pyport.mounts import ALTAZ
from pyport.thresholds import MOSTLY, SEEN, SIGNIFICANT

if TYPE_CHECKING:
    from pyport.diagnosis.naming.classes import Name
    from pyport.fitting.combinations import Combination


_LEFT = "something is left that"
_PARTED = "look for what parts the circle there: a limit, a cable, an encoder that slipped"
#: What to do about a misfit without a name, where its form says more than where it is.
WATCH = {
    "levels": "observe one source by turns with one value and another",
    "cycle": "find what turns once in that angle: a tooth, a worm, a line of the encoder",
    "sector": _PARTED,
    "stretch": _PARTED,
    "repeat": "find what is switched or comes back so often: a heater, a cooler, a pump, a fan",
}
#: Longer lists are cut short in a sentence; the report has them whole.
_SHOWN = 6


def moments(effect: Effect) -> tuple[str | None, str | None]:
    """Return when a step happened and when it stepped back, as ISO 8601 UTC; None where it did not.

    Neither for an effect that is no step in time.
    """
    if effect.changes_with != "session" or effect.parameter is None:
        return None, None
    return utc(effect.parameter), utc(effect.until) if effect.came_back else None


def nameless(effect: Effect, called: Name, *, few: bool) -> str:
    """Return why a finding has no name: none fits, or there are not `few` that do."""
    if effect.physical and not few:
        return f"{_LEFT} {len(called.members)} effects draw alike: {', '.join(called.members)}"
    return f"{_LEFT} no effect of the catalogue explains"


def watch(effect: Effect) -> str:
    """Return what to look at where a misfit has no name."""
    return WATCH.get(
        effect.member.get("bumps", {}).get("kind"),
        "look at the region and at what it follows, and record what changes there",
    )


def number(parameter: Parameter) -> str:
    """Return a value with its error, the digits that the error allows, in a handy unit."""
    value, sigma, unit = parameter.value, parameter.sigma, unit_in_words(parameter.unit)
    if unit == "arcsec":
        radians, unit = handy(abs(value) * ARCSEC)
        value, sigma = value / (radians / ARCSEC), sigma / (radians / ARCSEC)
    digits = decimals(sigma, 6)
    return f"{value:.{digits}f} +- {sigma:.{digits}f} {unit}"


def spoken(name: str, names: tuple[str, str] = ALTAZ.names) -> str:
    """Return the name of a coefficient as it is said: `wind_tilt_at_10_m_s`, at 10 m/s.

    One that ends in `_xel` or `_el` is said to be in the axis, where `names` are those of others.
    """
    bare, bracket, label = name.partition("[")
    for short, axis in zip(("_xel", "_el"), names, strict=True):
        if names != ALTAZ.names and bare.endswith(short):
            bare = f"{bare.removesuffix(short)} in {axis}"
    return (bare + bracket + label).replace("_m_s", "_m/s").replace("_", " ")


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
    pattern, cause = effect.pattern or effect.sentence, meaning(effect, mounts)
    if effect.reversed and all(p.value < -SEEN * p.sigma for p in parameters):
        pattern, cause = f"{pattern}, with the opposite sign", effect.reversed
    said = f"{pattern} (seen in {axes})"
    if together is not None:
        return f"{said}: {cause}; {together.sentence}"
    shown = parameters if len(parameters) <= _SHOWN else sorted(parameters, key=_chance)[:_SHOWN]
    sizes = [f"{spoken(p.name, names)} {number(p)}" for p in shown]
    more = f" and {len(parameters) - _SHOWN} more" if len(parameters) > _SHOWN else ""
    return f"{said}, {', '.join(sizes)}{more}: {cause}"


def _chance(parameter: Parameter) -> float:
    """Return a key that is smaller the more sigmas a value is from zero."""
    return -abs(parameter.value) / parameter.sigma if parameter.sigma > 0 else -np.inf


def common(effect: Effect, parameters: Sequence[Parameter], *, several: bool) -> str:
    """Return a sentence about what all antennas share."""
    sizes = ", ".join(f"{spoken(p.name)} {number(p)}" for p in parameters)
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


def looks_like(effect: Effect, called: Name, refuting: Sequence[str], gain: float) -> str:
    """Describe a shape that has no name, with what refutes its own and the nearest effect.

    Of some `gain`: an effect that gains less than most of it is not near.
    """
    shape = effect.variant or effect.id
    what = effect.sentence if shape in effect.sentence else f"{effect.sentence} ({shape})"
    runner, nearest = called.runner_up, ""
    if runner is not None and runner.gain > MOSTLY * gain:
        nearest = f"; the nearest effect is {runner.candidate.effect.id}"
    but = f", but {' and '.join(refuting)}" if refuting else ""
    return f"{what}{but}{nearest}"


def two_axes_sentence(one: Disagreement, axes: tuple[str, str] = ALTAZ.names) -> str:
    """Return what both axes say of an effect, where they part, and what would settle it."""
    effect, found = one.chosen.candidate.effect, one.found
    name = effect.id.replace("_", " ")
    spread = np.hypot(found.sigma_first, found.sigma_second)
    # the two that differ most
    most = np.argsort(-np.abs(found.first - found.second) / spread, kind="stable")[:2]
    each = ", ".join(_against(one, place) for place in sorted(most))
    differ = (
        f"The {name} seen in {axes[0]} and that seen in {axes[1]} differ by "
        f"{found.sigmas:.1f} sigma (chance {found.p_value:.1g}): {each}."
    )
    said = [
        differ,
        f"No {name} does that: something besides acts otherwise on one axis than on the other.",
    ]
    said.append(_place(one.splits, name, axes))
    if one.causes:
        causes = ", ".join(f"{which} ({left.sigmas:.1f})" for which, left in one.causes)
        said.append(f"Fitted besides would take it away, but for so many sigma: {causes}.")
    return " ".join(said)


def _against(one: Disagreement, place: int) -> str:
    first, second = _parameters(one, place)
    return f"{spoken(first.name)} {number(first)} against {number(second)}"


def _parameters(one: Disagreement, place: int) -> tuple[Parameter, Parameter]:
    """Return a coefficient as each axis has it."""
    candidate, found = one.chosen.candidate, one.found
    which = candidate.coefficients[int(found.of[place]) % len(candidate.columns)]
    coefficient = candidate.effect.coefficients[which]
    name = coefficient.name + (f"[{one.labels[place]}]" if one.labels[place] else "")
    x, y = (
        Parameter(
            name,
            float(value[place] / coefficient.scale),
            float(sigma[place] / abs(coefficient.scale)),
            coefficient.unit,
        )
        for value, sigma in ((found.first, found.sigma_first), (found.second, found.sigma_second))
    )
    return x, y


def _place(splits: tuple[Halves, ...], name: str, axes: tuple[str, str]) -> str:
    """Say in which axis and which half of the recordings the matter lies."""
    apart = [
        (own.sigmas, axis, split)
        for split in splits
        for axis, own in enumerate((split.in_x, split.in_y))
        if own is not None
    ]
    if not apart:
        return "Neither axis can be compared with itself in halves of the recordings."
    sigmas, axis, split = max(apart, key=lambda one: one[0])
    if sigmas < SIGNIFICANT:
        halves = dict.fromkeys(" and ".join(one.name for one in s.halves) for *_, s in apart)
        return f"Each axis by itself says the same {', '.join(halves)}."
    here, there = split.halves
    lies = f"It lies in {axes[axis]}, whose {name} {here.name} is not that {there.name}"
    said = [f"{lies} ({sigmas:.1f} sigma)"]
    other = (split.in_y, split.in_x)[axis]
    if other is not None and other.sigmas < SEEN:
        said.append(f"{axes[1 - axis]} has one in both ({other.sigmas:.1f})")
    seen = [f"{half.axes.sigmas:.1f} {half.name}" for half in split.halves if half.axes]
    said.append(f"the axes are apart by {' and '.join(seen)}")
    return "; ".join(said) + "."


def two_axes_json(one: Disagreement, axes: tuple[str, str]) -> dict[str, Any]:
    """Return a disagreement for report.json."""
    pairs = [_parameters(one, place) for place in range(len(one.found.of))]
    return {
        "effect": one.chosen.candidate.effect.id,
        "sentence": two_axes_sentence(one, axes),
        **_figures(one.found),
        "parameters": [
            {
                "name": x.name,
                "unit": x.unit,
                "xel": {"value": x.value, "sigma": x.sigma},
                "el": {"value": y.value, "sigma": y.sigma},
            }
            for x, y in pairs
        ],
        "halves": [
            {
                "between_axes": {half.name: _figures(half.axes) for half in split.halves},
                "between_halves": {"xel": _figures(split.in_x), "el": _figures(split.in_y)},
            }
            for split in one.splits
        ],
        "causes": [{"effect": name, "leaves": _figures(left)} for name, left in one.causes],
    }


def _figures(found: Difference | None) -> dict[str, float | None]:
    if found is None:
        return {"sigmas": None, "p_value": None}
    return {"sigmas": found.sigmas, "p_value": found.p_value}
