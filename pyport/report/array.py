"""An array's report as `report.json` spells it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pyport.angles import ARCMIN, HOUR
from pyport.diagnosis.arrays.places import Comparison, Places
from pyport.diagnosis.arrays.repeat import Repeat, Unseen, medians
from pyport.diagnosis.arrays.report import ArrayReport, Session
from pyport.diagnosis.arrays.words import SECOND
from pyport.report import pictures
from pyport.report.figures import BLUE, GREY, ORANGE, SCREEN_DPI

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


KM = 1000.0
#: So many antennas farthest off the others are named in the picture, and all beyond two sigmas.
NAMED = 8


def write_places(found: ArrayReport, folder: Path) -> Path | None:
    """Draw into `folder`/array-places.png and return the path; None where no site is known."""
    if found.places is None:
        return None
    picture = draw(found.places, found.comparison)
    return pictures.write(picture, folder / "array-places.png", SCREEN_DPI)


def draw(places: Places, comparison: Comparison | None) -> Figure:
    """Draw implied displacements against surveyed ones, or by antenna where there is no survey."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 6.4), layout="constrained")
    axes = figure.add_subplot()
    if comparison is None:
        _by_antenna(axes, places)
    else:
        _beside_survey(axes, places, comparison)
    axes.tick_params(labelsize=9)
    return figure


def _beside_survey(axes: Axes, places: Places, one: Comparison) -> None:
    surveyed, implied = one.surveyed_m / KM, one.implied_m / KM
    at = [places.antennas.index(name) for name in one.antennas]
    reach = 1.08 * np.array([surveyed.min(), surveyed.max()])
    axes.plot(reach, reach, "-", color=GREY, lw=1, label="as surveyed")
    label = f"{one.slope:.2f} $\\pm$ {one.slope_sigma:.2f} of it, correlation {one.correlation:.2f}"
    axes.plot(reach, one.slope * reach, "--", color=ORANGE, lw=1.4, label=label)
    axes.errorbar(
        surveyed,
        implied,
        one.sigma_m / KM,
        fmt="none",
        ecolor=GREY,
        lw=1,
        label="each mount's lean",
    )
    axes.errorbar(
        surveyed,
        implied,
        places.sigma_m[at] / KM,
        fmt="o",
        ms=4,
        color=BLUE,
        capsize=2,
        label="implied by the recordings",
    )
    far = np.argsort(-np.abs(surveyed))[:NAMED]
    for n in np.union1d(far, np.flatnonzero(np.abs(one.misses) > 2)):
        axes.annotate(
            one.antennas[n],
            (surveyed[n], implied[n]),
            xytext=(5, 5),
            textcoords="offset points",
            fontsize=8,
        )
    axes.set_xlabel("surveyed displacement toward east, about the mean [km]")
    axes.set_ylabel("implied displacement toward east, about the mean [km]")
    axes.legend(fontsize=9, loc="upper left")
    axes.set_title(f"{len(one.antennas)} antennas", fontsize=10)


def _by_antenna(axes: Axes, places: Places) -> None:
    order = np.arange(len(places.antennas))
    axes.axhline(0, color=GREY, lw=0.8)
    for some, colour, label in (
        (places.usable, BLUE, "told well"),
        (~places.usable, GREY, "told poorly"),
    ):
        if some.any():
            axes.errorbar(
                order[some],
                places.east_m[some] / KM,
                places.sigma_m[some] / KM,
                fmt="o",
                ms=4,
                color=colour,
                ecolor=colour,
                capsize=2,
                label=label,
            )
    axes.set_xticks(order, places.antennas, rotation=90, fontsize=8)
    axes.set_ylabel("implied displacement toward east of the median antenna [km]")
    axes.legend(fontsize=9)


def as_json(found: ArrayReport) -> dict[str, Any]:
    """Return the report's `array`."""
    parts = found.parts
    return {
        "sessions": [_session(one) for one in found.sessions],
        "time_tag_level_sigma_s": found.tag_level,
        "own": {shape.name: _own(found, n) for n, shape in enumerate(found.shapes)},
        "scatter_between_sessions_arcmin": {
            shape.name: float(scatter / ARCMIN)
            for shape, scatter in zip(found.shapes, parts.scatter, strict=True)
        },
        "repeats": {name: [_repeat(one) for one in days] for name, days in found.repeats.items()},
        "places": None if found.places is None else _places(found.places),
        "survey": None if found.comparison is None else comparison_json(found.comparison),
        "held_out": None if found.unseen is None else unseen_json(found.unseen),
    }


def _session(one: Session) -> dict[str, Any]:
    clock, tag = one.clock or (None, None), one.tag or (None, None)
    return {
        "session": one.name,
        "antennas": one.antennas,
        "hour_angle_h": None if one.hours is None else [hour / HOUR for hour in one.hours],
        "lean_sigma_alone_arcmin": one.sigma / ARCMIN,
        "lean_sigma_inflation": one.inflation,
        "clock_s": None if clock[0] is None else clock[0] / SECOND,
        "clock_sigma_s": None if clock[1] is None else clock[1] / SECOND,
        "time_tag_s": tag[0],
        "time_tag_sigma_s": tag[1],
    }


def _own(found: ArrayReport, shape: int) -> list[dict[str, Any]]:
    values = found.parts.own[:, shape]
    sigmas = np.sqrt(np.diag(found.parts.own_covariance(shape)))
    return [
        {"antenna": name, "value_arcmin": value / ARCMIN, "sigma_arcmin": sigma / ARCMIN}
        for name, value, sigma in zip(found.parts.antennas, values, sigmas, strict=True)
    ]


def _repeat(one: Repeat) -> dict[str, Any]:
    return {
        "session": one.session,
        "antennas": len(one.antennas),
        "common_arcmin": one.common / ARCMIN,
        "common_sigma_arcmin": one.common_sigma / ARCMIN,
        "correlation": one.correlation,
        "own_rms_arcmin": one.size / ARCMIN,
        "left_rms_arcmin": one.left / ARCMIN,
        "expected_of_errors_arcmin": one.noise / ARCMIN,
        "p_value": one.p_value,
    }


def _places(found: Places) -> dict[str, Any]:
    return {
        "metres_per_arcmin": found.radius_m * ARCMIN,
        "antennas": [
            {"antenna": name, "east_m": east, "sigma_m": sigma, "usable": bool(usable)}
            for name, east, sigma, usable in zip(
                found.antennas, found.east_m, found.sigma_m, found.usable, strict=True
            )
        ],
    }


def comparison_json(one: Comparison) -> dict[str, Any]:
    """Return what a survey says of the implied displacements."""
    return {
        "antennas": len(one.antennas),
        "correlation": one.correlation,
        "correlation_of_all": one.correlation_of_all,
        "slope": one.slope,
        "slope_sigma": one.slope_sigma,
        "own_lean_m": one.lean_m,
        "misses_rms_sigma": float(np.sqrt(np.mean(one.misses**2))),
        "within_one_sigma": float(np.mean(np.abs(one.misses) <= 1)),
        "within_two_sigma": float(np.mean(np.abs(one.misses) <= 2)),
        "delta_bic": one.delta_bic,
        "p_value": one.p_value,
        "unseen_before_m": one.unseen_m[0],
        "unseen_after_m": one.unseen_m[1],
        "site_longitude": one.is_the_site,
        "compared": [
            {"antenna": name, "implied_m": implied, "surveyed_m": place, "sigma_m": sigma}
            for name, implied, place, sigma in zip(
                one.antennas, one.implied_m, one.surveyed_m, one.sigma_m, strict=True
            )
        ],
        "missing": list(one.missing),
    }


def unseen_json(found: Unseen) -> dict[str, Any]:
    """Return what was predicted, and what could not be."""
    return {
        "scheme": "each antenna's session from its other sessions and the session's other antennas",
        "sessions": [
            {"session": name, "antennas": len(found.of(name)), **_medians(found, name)}
            for name in found.sessions
        ],
        "antennas": [
            {
                "antenna": one.antenna,
                "session": one.session,
                "pointings": one.pointings,
                "outliers": one.outliers,
                "rms_before_arcmin": one.before / ARCMIN,
                "rms_after_arcmin": one.after / ARCMIN,
                "fitted_before_arcmin": one.fitted_before / ARCMIN,
                "fitted_after_arcmin": one.fitted_after / ARCMIN,
                "noise_arcmin": one.noise / ARCMIN,
                "why": one.why,
                "moved": one.detail,
            }
            for one in found.days
        ],
        "unpredicted": [
            {"antenna": antenna, "session": session, "reason": reason}
            for antenna, session, reason in found.unpredicted
        ],
    }


def _medians(found: Unseen, session: str) -> dict[str, float]:
    one = medians(found.of(session))
    return {
        "rms_before_arcmin": one.before / ARCMIN,
        "rms_after_arcmin": one.after / ARCMIN,
        "fitted_before_arcmin": one.fitted_before / ARCMIN,
        "fitted_after_arcmin": one.fitted_after / ARCMIN,
        "factor_of_medians": one.before / one.after,
        "median_factor": one.factor,
        "fitted_median_factor": one.fitted_factor,
        "by_factor_two": one.enough,
    }
