"""A fitted model as a picture and a story."""

from __future__ import annotations

import math

import numpy as np

from pyport.angles import Array
from pyport.fitting import soundness
from pyport.fitting.combinations import of_fit as combined
from pyport.fitting.fit import Fit, completed, off_by
from pyport.fitting.table import MOST_COMBINATIONS
from pyport.models.model import Model
from pyport.page.markup import as_file, linear
from pyport.page.of_diagnosis import bars_of, picture_of, source_of
from pyport.page.picture import Layer, Picture, sides
from pyport.page.story import Story, rows_of, sky_rms

#: A heat map of more coefficients than this cannot be read.
MOST_NAMES = 40


def of_fit(fit: Fit) -> tuple[Picture, Story]:
    """Return what the panels draw of a fit, and what the page says of it."""
    names, curves = _terms(fit)
    before = fit.residual + sum(curves, np.zeros(len(fit.residual)))
    counted = (fit.noise.used).astype(float)
    x, y = sides(fit.recordings, fit.stack, before, curves, counted)
    layers = tuple(Layer(name.replace("_", " ")) for name in names)
    names_of = ("before the fit", "after the fit")
    whole = completed(fit)
    again = linear(whole, fit.recordings)
    picture = picture_of(fit.recordings, layers, x, y, names_of, "after", again)
    return picture, _story(fit, picture, whole)


def _terms(fit: Fit) -> tuple[list[str], list[Array]]:
    """Return the name of each term and what it takes off the numbers (m,).

    Several terms may be of one effect, each with another number in it: sines of 2A and 3A.
    """
    curves: dict[int, Array] = {}
    names: dict[int, str] = {}
    for one in fit.coefficients:
        rows = np.ones(len(fit.recordings), bool)
        for label, value in zip(one.term.per, one.labels, strict=True):
            rows &= fit.recordings.label(label).astype(str) == value
        columns = fit.stack.columns(one.term.effect, fit.recordings.at)
        curve = rows[fit.stack.row] * (columns @ np.nan_to_num(one.value))
        curves[id(one.term)] = curves.get(id(one.term), 0.0) + curve
        names[id(one.term)] = one.term.effect.id
    return list(names.values()), list(curves.values())


def _story(fit: Fit, picture: Picture, whole: Model) -> Story:
    recordings = fit.recordings
    names, matrix = _correlation(fit)
    together = combined(fit)[:MOST_COMBINATIONS]
    warnings = tuple(f"{one}." for one in soundness.warnings(fit))
    warnings += tuple(f"{one.sentence[0].upper()}{one.sentence[1:]}." for one in together)
    bars = bars_of(picture)
    said = " and ".join(f"{one.after:.3g} arcsec in {one.name}" for one in bars)
    facts = [(one.name, f"{one.before:.3g} → {one.after:.3g}", "arcsec rms") for one in bars]
    condition = "not bounded" if not math.isfinite(fit.condition) else f"{fit.condition:.3g}"
    aside = len(recordings.set_aside)
    facts += [
        *sky_rms(whole),
        ("condition number", condition, "columns of unit length"),
        ("recordings", f"{len(recordings):,}", f"{aside:,} rows excluded"),
    ]
    return Story(
        kind="fit",
        source=source_of(recordings),
        model=fit.model.name,
        headline=f"{fit.model.name} fits to {' and '.join(f'{one.after:.3g}' for one in bars)} "
        "arcsec.",
        lead=f"Rms of what is left: {said}. "
        "Whether physics is left out, a diagnosis tells: pyport diagnose.",
        good=not warnings,
        facts=tuple(facts),
        warnings=warnings,
        bars=bars,
        rows=rows_of(whole),
        correlation=(tuple(names), tuple(tuple(row) for row in matrix)),
        condition=fit.condition,
        outliers=off_by(recordings, fit.stack, fit.residual, fit.noise.used),
        model_file=as_file(whole),
    )


def _correlation(fit: Fit) -> tuple[list[str], list[list[float]]]:
    """Return names and correlations of the coefficients of one group, the first of each term."""
    first: dict[str, tuple[str, ...]] = {}
    for one in fit.coefficients:
        first.setdefault(one.term.effect.id, one.labels)
    kept = [
        (place, one.term.effect.coefficients[n].name)
        for place, (_, one, n) in enumerate(soundness.named(fit))
        if one.labels == first[one.term.effect.id] and math.isfinite(one.value[n])
    ][:MOST_NAMES]
    places = [place for place, _ in kept]
    return [name for _, name in kept], soundness.correlation(fit)[np.ix_(places, places)].tolist()
