"""A fit as text: the table of parameters that people know from papers."""

from __future__ import annotations

import math

import numpy as np

from pyport.angles import ARCSEC
from pyport.effects.empirical.drivers import unit_in_words
from pyport.errors import BadInput
from pyport.fitting import soundness
from pyport.fitting.combinations import Combination, of_fit
from pyport.fitting.fit import LABELS, Fit, by_label, completed, leftover_text, off_by
from pyport.fitting.soundness import ON_SKY, PER_AXIS, largest_offset, rms_of
from pyport.models import complete, toml
from pyport.models.conditions import Completed, Value
from pyport.recordings.schema import as_input, counted

#: Combinations and outliers that the terminal shows.
MOST_COMBINATIONS, MOST_OUTLIERS = 3, 10


def text(fit: Fit) -> str:
    """Return a table of values and sigmas, the rms, and how well the data determine it all."""
    values, together = _values(fit), of_fit(fit)
    largest = largest_offset(fit.stack, fit.recordings.at) / ARCSEC
    shared = {place for one in together for place in one.places}
    fitted = [one for one in values if one.sigma is not None]
    lines = [_line(one, largest if place in shared else None) for place, one in enumerate(fitted)]
    lines += [
        f"{complete.label(one):34s} {one.value:12.4f} {unit_in_words(one.unit)}, fixed"
        for one in values
        if one.sigma is None
    ]
    lines.insert(0, f"{counted(as_input(fit.recordings))}, model {fit.model.name}")
    lines.append("")
    *axes, sky = rms_of(fit.stack, fit.residual, fit.noise.used)
    counts = np.bincount(fit.stack.is_y, minlength=2)
    for axis, found, rows in zip(fit.recordings.at.mount.names, axes, counts, strict=True):
        if found is not None:
            size, used = found
            lines.append(f"{axis}: rms {size / ARCSEC:.2f} arcsec over {used} of {rows} offsets")
    if sky is not None:
        lines.append(f"sky: rms {sky[0] / ARCSEC:.2f} arcsec over {sky[1]} pointings, the {ON_SKY}")
    wrong = off_by(fit.recordings, fit.stack, fit.residual, fit.noise.used)
    lines += [f"outlier: line {line}, {what}" for line, what in wrong[:MOST_OUTLIERS]]
    if len(wrong) > MOST_OUTLIERS:
        lines.append(f"outlier: {len(wrong) - MOST_OUTLIERS} more, see --json")
    lines.append(f"condition number {fit.condition:.3g}")
    lines += [f"warning: {sentence}" for sentence in soundness.warnings(fit)]
    lines += _combined(together)
    lines += leftover_text(fit)
    if complete.has_before(values):
        lines += ["", *complete.lines(Completed({}, tuple(values), np.zeros((0, 0))))]
    return "\n".join(lines)


def _values(fit: Fit) -> tuple[Value, ...]:
    """Return every coefficient of a fit, those that were held last."""
    done = completed(fit).completed
    return () if done is None else done.values


def _combined(together: tuple[Combination, ...]) -> list[str]:
    """Return a line for each combination of coefficients that are not known alone."""
    lines = [f"degenerate terms: {one.sentence}" for one in together[:MOST_COMBINATIONS]]
    if len(together) > MOST_COMBINATIONS:
        lines.append(f"degenerate terms: {len(together) - MOST_COMBINATIONS} more, see --json")
    return lines


def _line(one: Value, largest: float | None) -> str:
    """Return a coefficient's line; one known in combination only, below `largest` [arcsec]."""
    name, value, sigma = complete.label(one), one.value, one.sigma or 0.0
    if not one.determined:
        return f"{name:34s} not determined by these recordings"
    times = f"{abs(value) / sigma:7.1f} sigmas" if sigma > 0 else ""
    if largest is not None:
        if one.unit == "arcsec" and max(abs(value), sigma) > largest:
            return f"{name:34s} larger than the data: known in combination only, see below"
        times = "in combination only"
    if one.unit == "deg":
        return f"{name:34s} {value:14.7f} +- {sigma:.7f} deg {times}"
    if one.unit != "arcsec":
        return f"{name:34s} {value:12.4f} +- {sigma:.4f} {unit_in_words(one.unit)} {times}"
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
        "input": as_input(fit.recordings),
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
            "names": [name for name, _, _ in soundness.named(fit)],
            "matrix": np.round(soundness.correlation(fit), 6).tolist(),
        },
        "condition_number": _number(fit.condition),
        "rms": _rms(fit),
        "outliers": [
            {"line": line, "why": what}
            for line, what in off_by(fit.recordings, fit.stack, fit.residual, fit.noise.used)
        ],
        "combinations": [one.as_json() for one in of_fit(fit)],
        "warnings": list(soundness.warnings(fit)),
        "residuals": {label: by_label(fit, label) for label in LABELS},
        "completed_model": _model(fit),
    }


def _model(fit: Fit) -> dict[str, object] | None:
    """Return the completed model as its file has it; None where no file can hold it."""
    try:
        return toml.tree(completed(fit))
    except BadInput:
        return None


def _rms(fit: Fit) -> dict[str, float | str | None]:
    found = rms_of(fit.stack, fit.residual, fit.noise.used)
    sizes: dict[str, float | str | None] = {
        f"{name}_arcsec": None if one is None else one[0] / ARCSEC
        for name, one in zip(("xel", "el", "sky"), found, strict=True)
    }
    return sizes | {"per_axis": PER_AXIS, "on_sky": ON_SKY}


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
