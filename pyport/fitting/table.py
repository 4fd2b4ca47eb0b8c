"""A fit as text: the table of parameters that people know from papers."""

from __future__ import annotations

import math

import numpy as np

from pyport.angles import ARCSEC, DEG
from pyport.fitting.fit import Coefficients, Fit


def text(fit: Fit) -> str:
    """Return a table of values and sigmas, the rms, and how well the data determine it all."""
    lines = []
    for one in fit.coefficients:
        for n, coefficient in enumerate(one.term.effect.coefficients):
            label = f"[{' '.join(one.labels)}]" if any(one.labels) else ""
            lines.append(_line(coefficient.name + label, one, n))
    left = {"cross-elevation": ~fit.stack.is_y, "elevation": fit.stack.is_y}
    lines.append("")
    for axis, rows in left.items():
        if rows.any():
            counted = rows & (fit.weight > 0)
            rms = math.sqrt(float(np.mean(fit.residual[counted] ** 2)))
            over = f"{counted.sum()} of {rows.sum()} offsets"
            lines.append(f"{axis}: rms {rms / ARCSEC:.2f} arcsec over {over}")
    lines.append(f"condition number {fit.condition:.3g}")
    return "\n".join(lines)


def _line(name: str, one: Coefficients, n: int) -> str:
    coefficient = one.term.effect.coefficients[n]
    value, sigma = one.value[n], one.sigma[n]
    if not math.isfinite(value):
        return f"{name:34s} not determined by these recordings"
    if coefficient.unit != "arcsec":
        value, sigma = value / coefficient.scale, sigma / coefficient.scale
        return f"{name:34s} {value:12.4f} +- {sigma:.4f} {coefficient.unit}"
    return (
        f"{name:34s} {value / ARCSEC:10.2f} +- {sigma / ARCSEC:6.2f} arcsec "
        f"= {value / DEG:11.6f} +- {sigma / DEG:.6f} deg"
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
        "condition_number": _number(fit.condition),
    }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
