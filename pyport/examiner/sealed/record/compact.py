"""Answers as they are kept: what the score is computed from, small enough for a repository."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from pyport.errors import BadInput

#: Keys of a report, and of its findings, that are kept: what a judge may ask.
_REPORT = ("mismatch", "p_value", "detection_limit_arcsec", "findings", "two_axes")
_FINDING = (
    *("effect", "variant", "class", "verdict", "where", "parameters", "evidence", "heldout"),
    *("visible_rms_arcsec", "true_rms_arcsec"),
)
#: Readings that were held out and are kept of a case, and steps in their rms: a skill of 0.9 is
#: known from so many to 0.01, and a step of a twentieth adds 2e-4 of the noise's square.
_MOST_READINGS, _STEPS = 400, 20
_DIGITS = 6
_AXES = ("xel", "el")


def compact(report: dict[str, Any], rows: Path) -> dict[str, Any]:
    """Return what is kept of a report, with the readings held out where `rows` has them.

    Raises `BadInput`: there are rows without the columns that are scored.
    """
    kept = {key: report[key] for key in _REPORT if key in report}
    findings = kept.get("findings") or []
    kept["findings"] = [{key: one[key] for key in _FINDING if key in one} for one in findings]
    kept = _rounded(kept)
    if rows.exists():
        kept["left_out"] = _left_out(rows)
    return kept


def _rounded(value: Any) -> Any:  # noqa: ANN401 - whatever JSON holds
    if isinstance(value, dict):
        return {key: _rounded(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_rounded(one) for one in value]
    return float(f"{value:.{_DIGITS}g}") if isinstance(value, float) else value


def _left_out(rows: Path) -> dict[str, Any]:
    """Return residuals of readings held out, in steps, each as far from the one before as it is."""
    try:
        with rows.open(encoding="utf-8", newline="") as file:
            known = [
                (
                    _AXES.index(one["axis"]),
                    int(one["line"]),
                    float(one["heldout_before_arcsec"]),
                    float(one["heldout_after_arcsec"]),
                )
                for one in csv.DictReader(file)
                if one["heldout_before_arcsec"] and one["heldout_after_arcsec"]
            ]
    except (KeyError, TypeError, ValueError, csv.Error) as error:
        wanted = "expected columns axis, line, heldout_before_arcsec and heldout_after_arcsec"
        raise BadInput(f"{type(error).__name__} {error}: {wanted}", rows) from None
    if not known:
        return {}
    axis, line, before, after = np.array(known).T
    some = np.arange(0, len(known), -(-len(known) // _MOST_READINGS))
    step = float(f"{np.sqrt(np.mean(after**2)) / _STEPS:.2g}") or 1.0
    found: dict[str, Any] = {"step_arcsec": step}
    for number, name in enumerate(_AXES):
        own = some[axis[some] == number]
        last = np.round(after[own] / step).astype(int)
        found[name] = {
            "line": np.diff(line[own].astype(int), prepend=0).tolist(),
            "after": last.tolist(),
            "gained": (np.round(before[own] / step).astype(int) - last).tolist(),
        }
    return found


def rows_of(left_out: dict[str, Any]) -> str:
    """Return readings held out as a judge reads them: rows.csv."""
    lines = ["axis,line,heldout_before_arcsec,heldout_after_arcsec"]
    step = left_out["step_arcsec"]
    for name in _AXES:
        own = left_out[name]
        for line, after, gained in zip(
            np.cumsum(own["line"]).tolist(), own["after"], own["gained"], strict=True
        ):
            lines.append(f"{name},{line},{(after + gained) * step:.6g},{after * step:.6g}")
    return "\n".join([*lines, ""])
