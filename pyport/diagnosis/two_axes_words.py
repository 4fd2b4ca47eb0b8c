"""What is said of an effect that comes out different from the two axes, in words and as data."""

from __future__ import annotations

from typing import Any

import numpy as np

from pyport.diagnosis.finding import Parameter
from pyport.diagnosis.two_axes import Disagreement, Split
from pyport.diagnosis.words import number
from pyport.fitting.two_axes import Difference
from pyport.mounts import ALTAZ
from pyport.thresholds import SEEN, SIGNIFICANT

#: Coefficients told in a sentence, those that differ most.
_SHOWN = 2


def sentence(one: Disagreement, axes: tuple[str, str] = ALTAZ.names) -> str:
    """Return what both axes say of an effect, where they part, and what would settle it."""
    effect, found = one.chosen.candidate.effect, one.found
    name = effect.id.replace("_", " ")
    spread = np.hypot(found.sigma_first, found.sigma_second)
    most = np.argsort(-np.abs(found.first - found.second) / spread, kind="stable")[:_SHOWN]
    told = ", ".join(_against(one, place) for place in sorted(most))
    differ = (
        f"The {name} seen in {axes[0]} and that seen in {axes[1]} differ by "
        f"{found.sigmas:.1f} sigma (chance {found.p_value:.1g}): {told}."
    )
    said = [differ, f"No {name} does that: something acts on one axis alone."]
    said.append(_place(one.splits, name, axes))
    if one.causes:
        causes = ", ".join(f"{which} ({left.sigmas:.1f})" for which, left in one.causes)
        said.append(f"Fitted besides would take it away, but for so many sigma: {causes}.")
    return " ".join(said)


def _against(one: Disagreement, place: int) -> str:
    first, second = _parameters(one, place)
    return f"{first.name.replace('_', ' ')} {number(first)} against {number(second)}"


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
        for value, sigma in (
            (found.first, found.sigma_first),
            (found.second, found.sigma_second),
        )
    )
    return x, y


def _place(splits: tuple[Split, ...], name: str, axes: tuple[str, str]) -> str:
    """Say in which axis and which half of the recordings the matter lies."""
    apart = [
        (own.sigmas, axis, split)
        for split in splits
        for axis, own in enumerate((split.in_x, split.in_y))
        if own is not None
    ]
    most = max(apart, key=lambda one: one[0], default=None)
    if most is None or most[0] < SIGNIFICANT:
        return "Each axis by itself says the same in either half of the sky and of the time."
    sigmas, axis, split = most
    here, there = split.halves
    lies = f"It lies in {axes[axis]}, whose {name} {here.name} is not that {there.name}"
    said = [f"{lies} ({sigmas:.1f} sigma)"]
    other = (split.in_y, split.in_x)[axis]
    if other is not None and other.sigmas < SEEN:
        said.append(f"{axes[1 - axis]} has one in both ({other.sigmas:.1f})")
    seen = [f"{half.axes.sigmas:.1f} {half.name}" for half in split.halves if half.axes]
    said.append(f"the axes are apart by {' and '.join(seen)}")
    return "; ".join(said) + "."


def as_json(one: Disagreement, axes: tuple[str, str] = ALTAZ.names) -> dict[str, Any]:
    """Return a disagreement for report.json."""
    pairs = [_parameters(one, place) for place in range(len(one.found.of))]
    return {
        "effect": one.chosen.candidate.effect.id,
        "sentence": sentence(one, axes),
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
