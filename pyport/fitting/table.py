"""A fit as text: the table of parameters that people know from papers."""

from __future__ import annotations

import math

import numpy as np

from pyport.angles import ARCSEC
from pyport.errors import BadInput
from pyport.fitting import advice, leftover
from pyport.fitting.completed import completed
from pyport.fitting.fit import Fit
from pyport.models import toml, words
from pyport.models.completed import Completed, Value


def text(fit: Fit) -> str:
    """Return a table of values and sigmas, the rms, and how well the data determine it all."""
    values = _values(fit)
    lines = [_line(one) for one in values if one.sigma is not None]
    lines += [
        f"{words.label(one):34s} {one.value:12.4f} {one.unit}, fixed"
        for one in values
        if one.sigma is None
    ]
    left = {"cross-elevation": ~fit.stack.is_y, "elevation": fit.stack.is_y}
    lines.append("")
    for axis, rows in left.items():
        if rows.any():
            counted = rows & fit.noise.used
            rms = math.sqrt(float(np.mean(fit.residual[counted] ** 2)))
            over = f"{counted.sum()} of {rows.sum()} offsets"
            lines.append(f"{axis}: rms {rms / ARCSEC:.2f} arcsec over {over}")
    lines.append(f"condition number {fit.condition:.3g}")
    lines += [f"warning: {sentence}" for sentence in advice.warnings(fit)]
    lines += leftover.text(fit)
    if words.has_before(values):
        lines += ["", *words.lines(Completed({}, tuple(values), np.zeros((0, 0))))]
    return "\n".join(lines)


def _values(fit: Fit) -> tuple[Value, ...]:
    """Return every coefficient of a fit, those that were held last."""
    done = completed(fit).completed
    return () if done is None else done.values


def _line(one: Value) -> str:
    name, value, sigma = words.label(one), one.value, one.sigma or 0.0
    if not one.determined:
        return f"{name:34s} not determined by these recordings"
    times = f"{abs(value) / sigma:7.1f} sigmas" if sigma > 0 else ""
    if one.unit == "deg":
        return f"{name:34s} {value:14.7f} +- {sigma:.7f} deg {times}"
    if one.unit != "arcsec":
        return f"{name:34s} {value:12.4f} +- {sigma:.4f} {one.unit} {times}"
    return (
        f"{name:34s} {value:10.2f} +- {sigma:6.2f} arcsec "
        f"= {value / 3600:11.6f} +- {sigma / 3600:.6f} deg {times}"
    )


def as_json(fit: Fit) -> dict[str, object]:
    """Return the fit's parameters, sigmas and rms for other programs."""
    values = _values(fit)
    labels_of = [one.labels for one in fit.coefficients for _ in one.term.effect.coefficients]
    return {
        "model": fit.model.name,
        "parameters": [
            {
                "name": one.name,
                "labels": list(labels),
                "value": one.value if one.determined else None,
                "sigma": one.sigma if one.determined else None,
                "unit": one.unit,
                "before": one.before,
                "change": one.change if one.determined else None,
            }
            for one, labels in zip(values, labels_of, strict=False)
        ],
        "fixed": [
            {"name": one.name, "value": one.value, "unit": one.unit}
            for one in values[len(labels_of) :]
        ],
        "correlation": {
            "names": [name for name, _, _ in advice.named(fit)],
            "matrix": np.round(advice.correlation(fit), 6).tolist(),
        },
        "condition_number": _number(fit.condition),
        "warnings": list(advice.warnings(fit)),
        "residuals": {label: leftover.by_label(fit, label) for label in leftover.LABELS},
        "completed_model": _model(fit),
    }


def _model(fit: Fit) -> dict[str, object] | None:
    """Return the completed model as its file has it; None where no file can hold it."""
    try:
        return toml.tree(completed(fit))
    except BadInput:
        return None


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
