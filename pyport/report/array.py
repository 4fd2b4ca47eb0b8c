"""An array's report as `report.json` spells it."""

from __future__ import annotations

from typing import Any

import numpy as np

from pyport.angles import ARCMIN, HOUR
from pyport.diagnosis.arrays.places import Comparison, Places
from pyport.diagnosis.arrays.repeat import Repeat, UnseenDays, medians
from pyport.diagnosis.arrays.report import ArrayReport, Session
from pyport.diagnosis.arrays.words import SECOND


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


def unseen_json(found: UnseenDays) -> dict[str, Any]:
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


def _medians(found: UnseenDays, session: str) -> dict[str, float]:
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
