"""A fit as text: the table of parameters that people know from papers."""

from __future__ import annotations

import math

import numpy as np

from pyport.angles import ARCSEC, DEG
from pyport.effects import Coefficient
from pyport.fitting import advice, leftover
from pyport.fitting.combinations import Combination, of_fit
from pyport.fitting.fit import Coefficients, Fit
from pyport.fitting.sizes import ON_SKY, PER_AXIS, axis_rms, sky_rms

#: Combinations that the terminal shows.
MOST_COMBINATIONS = 3


def text(fit: Fit) -> str:
    """Return a table of values and sigmas, the rms, and how well the data determine it all."""
    together = of_fit(fit)
    largest = float(np.abs(fit.stack.value).max(initial=0.0))
    shared = {place for one in together for place in one.places}
    lines = [
        _line(name, one, n, largest if place in shared else None)
        for place, (name, one, n) in enumerate(advice.named(fit))
    ]
    lines += [
        f"{coefficient.name:34s} {value / coefficient.scale:12.4f} {coefficient.unit}, fixed"
        for coefficient, value in fixed(fit)
    ]
    lines.append("")
    for axis, is_y in (("cross-elevation", False), ("elevation", True)):
        rows = int((fit.stack.is_y == is_y).sum())
        found = axis_rms(fit.stack, fit.residual, fit.noise.used, is_y=is_y)
        if found is not None:
            size, counted = found
            lines.append(f"{axis}: rms {size / ARCSEC:.2f} arcsec over {counted} of {rows} offsets")
    sky = sky_rms(fit.stack, fit.residual, fit.noise.used)
    if sky is not None:
        lines.append(f"sky: rms {sky[0] / ARCSEC:.2f} arcsec over {sky[1]} pointings, the {ON_SKY}")
    lines.append(f"condition number {fit.condition:.3g}")
    lines += [f"warning: {sentence}" for sentence in advice.warnings(fit)]
    lines += _combined(together)
    lines += leftover.text(fit)
    return "\n".join(lines)


def fixed(fit: Fit) -> list[tuple[Coefficient, float]]:
    """Return the coefficients that were held, with their values in internal units."""
    held = [(term.effect.coefficients, term.values) for term in fit.model.terms if term.fixed]
    return [
        pair
        for names, values in held
        for pair in zip(names, values or (0.0,) * len(names), strict=True)
    ]


def _combined(together: tuple[Combination, ...]) -> list[str]:
    """Return a line for each combination of coefficients that are not known alone."""
    lines = [f"degenerate terms: {one.sentence}" for one in together[:MOST_COMBINATIONS]]
    if len(together) > MOST_COMBINATIONS:
        lines.append(f"degenerate terms: {len(together) - MOST_COMBINATIONS} more, see --json")
    return lines


def _line(name: str, one: Coefficients, n: int, largest: float | None = None) -> str:
    """Return a coefficient's line; one known in combination only, below `largest` [rad]."""
    coefficient = one.term.effect.coefficients[n]
    value, sigma = one.value[n], one.sigma[n]
    if not math.isfinite(value):
        return f"{name:34s} not determined by these recordings"
    times = f"{abs(value) / sigma:7.1f} sigmas" if sigma > 0 else ""
    if largest is not None:
        if coefficient.unit == "arcsec" and max(abs(value), sigma) > largest:
            return f"{name:34s} larger than the data: known in combination only, see below"
        times = "in combination only"
    if coefficient.unit == "deg":
        value, sigma = value / DEG, sigma / DEG
        return f"{name:34s} {value:14.7f} +- {sigma:.7f} deg {times}"
    if coefficient.unit != "arcsec":
        value, sigma = value / coefficient.scale, sigma / coefficient.scale
        return f"{name:34s} {value:12.4f} +- {sigma:.4f} {coefficient.unit} {times}"
    return (
        f"{name:34s} {value / ARCSEC:10.2f} +- {sigma / ARCSEC:6.2f} arcsec "
        f"= {value / DEG:11.6f} +- {sigma / DEG:.6f} deg {times}"
    )


def as_json(fit: Fit) -> dict[str, object]:
    """Return the fit's parameters, sigmas and rms for other programs."""
    return {
        "model": fit.model.name,
        "parameters": [
            {
                "name": coefficient.name,
                "labels": list(one.labels),
                "value": _number(one.value[n] / coefficient.scale),
                "sigma": _number(one.sigma[n] / coefficient.scale),
                "unit": coefficient.unit,
            }
            for one in fit.coefficients
            for n, coefficient in enumerate(one.term.effect.coefficients)
        ],
        "fixed": [
            {"name": one.name, "value": value / one.scale, "unit": one.unit}
            for one, value in fixed(fit)
        ],
        "correlation": {
            "names": [name for name, _, _ in advice.named(fit)],
            "matrix": np.round(advice.correlation(fit), 6).tolist(),
        },
        "condition_number": _number(fit.condition),
        "rms": _rms(fit),
        "combinations": [one.as_json() for one in of_fit(fit)],
        "warnings": list(advice.warnings(fit)),
        "residuals": {label: leftover.by_label(fit, label) for label in leftover.LABELS},
    }


def _rms(fit: Fit) -> dict[str, float | str | None]:
    found = {
        "xel": axis_rms(fit.stack, fit.residual, fit.noise.used, is_y=False),
        "el": axis_rms(fit.stack, fit.residual, fit.noise.used, is_y=True),
        "sky": sky_rms(fit.stack, fit.residual, fit.noise.used),
    }
    sizes: dict[str, float | str | None] = {
        f"{name}_arcsec": None if one is None else one[0] / ARCSEC for name, one in found.items()
    }
    return sizes | {"per_axis": PER_AXIS, "on_sky": ON_SKY}


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
