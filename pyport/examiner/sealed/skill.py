"""How much of what could be gained on unseen data was gained.

The examiner knows the noise, so it can ask of each prediction of a reading that
was held out how far it is from the noiseless truth. R0 is that of the base
alone, R1 that of the tool's model, R* that of a refit of the true form; the
gain is R0^2 - R1^2, what could be gained R0^2 - R*^2.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array
from pyport.errors import BadInput
from pyport.examiner.sealed.judge import numbers, read_table
from pyport.examiner.worlds.case import Case
from pyport.examiner.worlds.projection import altaz_columns

_FOLDS = 10


def skill(case: Case, recordings: Path, rows: Path) -> tuple[float, float] | None:
    """Return gained and gainable mean squares on held-out readings, in units of the noise's.

    `case`: the case of one antenna, made again from its seed.
    `recordings`: what the solver saw.
    `rows`: the solver's residuals on data left out, by line and axis.
    Returns `gained`, `gainable`: or None where the rows do not say what was predicted.
    """
    measured = _measured(recordings)
    before, after = _left_out(rows, recordings, measured.shape[1])
    sigma = _sigma(case)
    clean = np.stack(case.clean)
    noise = measured - clean
    misfit_before, misfit_after = (before - noise) / sigma, (after - noise) / sigma
    misfit_best = (clean - _best(case, measured)) / sigma
    known = np.isfinite(misfit_before) & np.isfinite(misfit_after)
    if not known.any():
        return None
    start, end, best = (
        float(np.mean(misfit[known] ** 2)) for misfit in (misfit_before, misfit_after, misfit_best)
    )
    return start - end, start - best


def _sigma(case: Case) -> Array:
    """Return the noise per axis [rad], shape (2, 1)."""
    noise = case.truth["noise"]
    return np.array([[noise["xel_arcsec"]], [noise["el_arcsec"]]]) * ARCSEC


def _measured(recordings: Path) -> Array:
    """Return both measured offsets [rad], x across, shape (2, n); NaN where not measured."""
    table = read_table(recordings)
    el = numbers(table, "el_deg") * DEG
    measured = np.full((2, len(el)), np.nan)
    on_sky = (("d_az_deg", np.cos(el)), ("d_el_deg", np.ones_like(el)))
    for axis, (column, scale) in enumerate(on_sky):
        if column in table:
            measured[axis] = numbers(table, column) * DEG * scale
    return measured


def _left_out(rows: Path, recordings: Path, count: int) -> tuple[Array, Array]:
    """Return the solver's residuals of readings left out [rad], before and after, (2, n) each."""
    with recordings.open(encoding="utf-8") as file:
        first_line = 2 + sum(1 for line in file if line.startswith("#"))
    before, after = np.full((2, count), np.nan), np.full((2, count), np.nan)
    try:
        with rows.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                place = (0 if row["axis"] == "xel" else 1), int(row["line"]) - first_line
                for values, column in ((before, "before"), (after, "after")):
                    text = row[f"heldout_{column}_arcsec"]
                    values[place] = float(text) * ARCSEC if text else np.nan
    except (KeyError, TypeError, ValueError, IndexError, csv.Error) as error:
        wanted = "expected columns axis, line, heldout_before_arcsec and heldout_after_arcsec"
        raise BadInput(f"{type(error).__name__} {error}: {wanted}", rows) from None
    return before, after


def _best(case: Case, measured: Array) -> Array:
    """Return what the base and the true form, refitted without a fold, predict of it, (2, n)."""
    az, el = (case.columns[name] * DEG for name in ("az_deg", "el_deg"))
    columns = np.stack(altaz_columns(az, el))
    form = np.stack(case.signature)[:, :, None]
    design = np.concatenate([columns, form / (np.abs(form).max() or 1.0)], axis=2)
    sigma = _sigma(case)
    known = np.isfinite(measured)
    predicted = np.full(measured.shape, np.nan)
    fold = _folds(case)
    for one in np.unique(fold):
        fitted = known & (fold != one)
        weighed = (design / sigma[:, :, None])[fitted]
        values, *_ = np.linalg.lstsq(weighed, (measured / sigma)[fitted], rcond=1e-12)
        predicted[:, fold == one] = (design @ values)[:, fold == one]
    return predicted


def _folds(case: Case) -> NDArray[np.intp]:
    """Return the session of each row, or one of ten stretches where a session is what is hidden."""
    if any(cause["effect"].startswith("epoch") for cause in case.truth["effects"]):
        count = len(case.columns["el_deg"])
        return np.arange(count) * 7919 % count * _FOLDS // count
    return np.unique(case.columns["session"], return_inverse=True)[1]
