"""The RT32's own fit as a picture and a story."""

from __future__ import annotations

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.page.of_diagnosis import off_by, picture_of, source_of
from pyport.page.picture import Layer, Picture, sides
from pyport.page.story import Bar, Row, Story
from pyport.pointing import PARAMETERS
from pyport.studies.rt32.fit import Rt32Fit


def of_rt32(fit: Rt32Fit, honest: Array) -> tuple[Picture, Story]:
    """Return what the panels draw of a fit of p1..p12, and what the page says of it.

    `fit`: the fit; each parameter is a layer, linear about the solution.
    `honest`: standard errors by whole sessions [rad], shape (P,).
    """
    values = np.nan_to_num(fit.values)
    curves = [fit.columns[:, k] * value for k, value in enumerate(values)]
    before = fit.residual + sum(curves, np.zeros(len(fit.residual)))
    x, y = sides(fit.recordings, fit.stack, before, curves, fit.inside.astype(float))
    layers = tuple(Layer(_name(k)) for k in range(len(values)))
    titles = ("before the fit", "after the fit")
    picture = picture_of(fit.recordings, layers, x, y, titles, "after")
    return picture, _story(fit, honest, picture)


def _name(k: int) -> str:
    return f"p{k + 1} {PARAMETERS[k].name}" if k < len(PARAMETERS) else "step of the box offset"


def _story(fit: Rt32Fit, honest: Array, picture: Picture) -> Story:
    form = "exact" if fit.exact else "approximate"
    inside, level = int(fit.inside.sum()), fit.level / ARCSEC
    made_up = " The recordings are simulated." if "simulated" in fit.recordings.meta else ""
    correlation = np.nan_to_num(fit.correlation)
    names = tuple(f"p{k + 1}" if k < len(PARAMETERS) else "step" for k in range(len(fit.values)))
    rows = tuple(
        Row(_name(k), "", _known(value), _known(honest[k]), "arcsec")
        for k, value in enumerate(fit.values)
    )
    outliers = tuple(
        off_by(fit.recordings, fit.stack, n, fit.residual[n]) for n in np.flatnonzero(~fit.inside)
    )
    return Story(
        kind="fit",
        source=source_of(fit.recordings),
        model=f"rt32-{form}, {fit.method}",
        headline=f"The {form} form fits to {fit.rms / ARCSEC:.3g} arcsec.",
        lead=f"Rms of the {inside:,} of {len(fit.stack):,} offsets within {level:.3g} arcsec. "
        f"Errors are those between whole sessions.{made_up}",
        good=True,
        facts=(
            ("rms within the level", f"{fit.rms / ARCSEC:.3g}", "arcsec, both axes"),
            ("offsets within", f"{inside:,}", f"of {len(fit.stack):,}"),
            ("condition number", f"{fit.condition:.3g}", "columns of unit length"),
            ("recordings", f"{len(fit.recordings):,}", f"{fit.rounds} rounds of votes"),
        ),
        bars=tuple(
            Bar(name, side.rms(side.before) / ARCSEC, side.rms(side.after) / ARCSEC)
            for name, side in picture.sides()
        ),
        rows=rows,
        correlation=(names, tuple(tuple(row) for row in correlation.tolist())),
        condition=fit.condition,
        outliers=outliers,
    )


def _known(value: float) -> float | None:
    return float(value / ARCSEC) if np.isfinite(value) else None
