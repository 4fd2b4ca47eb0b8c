"""The record of a diagnosis: report.json and rows.csv, as the contract spells them."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.diagnosis import noise_words, two_axes_words
from pyport.diagnosis.arrays.record import as_json as array_json
from pyport.diagnosis.arrays.report import ArrayReport
from pyport.diagnosis.completed import completed
from pyport.diagnosis.diagnose import Diagnosis
from pyport.diagnosis.folder import finish
from pyport.diagnosis.joint import Joint, rms
from pyport.diagnosis.soundness import nothing, warnings
from pyport.errors import BadInput
from pyport.files import sha256, write_whole
from pyport.fitting.sizes import ON_SKY, PER_AXIS, axis_rms, sky_rms
from pyport.least_squares.gram import inverted
from pyport.models import toml
from pyport.recordings.schema import Recordings

SCHEMA = "pyport.diagnosis/1"


def write(
    diagnosis: Diagnosis,
    folder: Path,
    array: ArrayReport | None = None,
    beside: Iterable[Path] = (),
) -> dict[str, Any]:
    """Write rows.csv and then report.json into a folder, each whole or not at all.

    The report, which is returned, holds the hashes of rows.csv and of the files that
    were written `beside` it.
    """
    content = as_json(diagnosis)
    if array is not None:
        content["array"] = array_json(array)
    rows = folder / "rows.csv"
    with write_whole(rows) as file:
        _write_rows(diagnosis, file)
    return finish(folder, finite(content), [rows, *beside])


def as_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the report of a diagnosis."""
    recordings, model = diagnosis.setup.recordings, diagnosis.setup.model
    names, matrix = correlation(diagnosis)
    mount = recordings.at.mount
    return {
        "schema": SCHEMA,
        "input": _input(recordings, diagnosis),
        "model": {
            "name": model.name,
            "refit": [c.candidate.effect.id for c in diagnosis.setup.base],
        },
        "mount": {"name": mount.id, "axes": dict(zip(("xel", "el"), mount.names, strict=True))},
        "noise": _noise(diagnosis),
        "verdict": None if diagnosis.mismatch else nothing(diagnosis),
        "mismatch": diagnosis.mismatch,
        "p_value": diagnosis.p_value,
        "detection_limit_arcsec": {
            effect: size / ARCSEC for effect, size in diagnosis.detection_limits.items()
        },
        "findings": [finding.as_json() for finding in diagnosis.findings],
        "fit": {
            "before": _rms(diagnosis, diagnosis.before),
            "after": _rms(diagnosis, diagnosis.after),
            "heldout": diagnosis.heldout.as_json(),
            "rms_per_axis": PER_AXIS,
            "rms_on_sky": ON_SKY,
        },
        "combinations": [one.as_json() for one in diagnosis.combinations],
        "dropped": [vars(one) for one in diagnosis.dropped],
        "two_axes": [two_axes_words.as_json(one, mount.names) for one in diagnosis.two_axes],
        "antennas": _antennas(diagnosis),
        "not_testable": {one.effect: one.reason for one in diagnosis.untestable},
        "correlation": {"names": names, "matrix": matrix},
        "condition_number": diagnosis.after.solution.condition,
        "warnings": warnings(diagnosis),
        "completed_model": _completed(diagnosis),
    }


def _completed(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """Return the completed model, its findings apart, which the report has; None without one.

    There is none where a model has terms, made in Python, that no file can hold.
    """
    try:
        whole = toml.tree(completed(diagnosis))
    except BadInput:
        return None
    whole.pop("finding", None)
    return whole


def _input(recordings: Recordings, diagnosis: Diagnosis) -> dict[str, Any]:
    set_aside = [{"line": one.line, "reason": one.reason} for one in recordings.set_aside]
    file = recordings.file
    reduction = recordings.reduction
    told = {
        "file": file.name,
        "sha256": sha256(file) if file.is_file() else None,
        "rows": len(recordings) + len(set_aside),
        "used": len(recordings),
        "set_aside": set_aside,
        "outliers": int((~diagnosis.weighed.used).sum()),
    }
    if reduction is None:
        return told
    used = reduction.rows - sum(reduction.set_aside.values())
    return told | {"rows": reduction.rows, "used": used, "reduction": vars(reduction)}


def _noise(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the noise per axis: the median over the antennas, and the longest drift time."""
    parts = list(zip(diagnosis.setup.parts, diagnosis.weighed.noises, strict=True))
    axes = {
        name: [noise for part, noise in parts if part.is_y == is_y]
        for name, is_y in (("xel", False), ("el", True))
    }
    times = [noise.time_s for _, noise in parts if noise.time_s is not None]
    return {
        "xel_arcsec": _median_floor(axes["xel"]),
        "el_arcsec": _median_floor(axes["el"]),
        "correlation_time_s": max(times, default=None),
        "how": parts[0][1].how if parts else "reml",
        "departures": noise_words.departures(diagnosis),
        "by_elevation": noise_words.by_elevation(diagnosis),
        "sentences": noise_words.sentences(diagnosis),
    }


def _median_floor(noises: list[Any]) -> float | None:
    return float(np.median([noise.floor for noise in noises])) / ARCSEC if noises else None


def _rms(diagnosis: Diagnosis, fit: Joint) -> dict[str, float | None]:
    left, data, used = diagnosis.left(fit), diagnosis.setup.stack, diagnosis.share > 0
    found = {
        "xel": axis_rms(data, left, used, is_y=False),
        "el": axis_rms(data, left, used, is_y=True),
        "sky": sky_rms(data, left, used),
    }
    return {
        f"rms_{name}_arcsec": None if one is None else one[0] / ARCSEC
        for name, one in found.items()
    }


def antennas(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return for each antenna its rms before and after, in the fit and held out [arcsec]."""
    setup = diagnosis.setup
    of_row = setup.blocks.antenna[setup.block]
    before, after = diagnosis.left(diagnosis.before), diagnosis.left(diagnosis.after)
    found = []
    for name in np.unique(of_row):
        rows = (of_row == name) & diagnosis.weighed.used
        both = (of_row == name) & diagnosis.unseen.counted
        found.append(
            {
                "antenna": str(name),
                "readings": int(rows.sum()),
                "drowns_in_noise": str(name) in diagnosis.noisy,
                "rms_before_arcsec": rms(before[rows]) / ARCSEC,
                "rms_after_arcsec": rms(after[rows]) / ARCSEC,
                "heldout_before_arcsec": rms(diagnosis.unseen.before[both]) / ARCSEC,
                "heldout_after_arcsec": rms(diagnosis.unseen.after[both]) / ARCSEC,
            }
        )
    return found


def _antennas(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    named = np.unique(diagnosis.setup.blocks.antenna)
    return antennas(diagnosis) if len(named) > 1 else []


def correlation(diagnosis: Diagnosis) -> tuple[list[str], list[list[float]]]:
    """Return names and correlations of what one antenna in one session sees, base and findings.

    Coefficients of other antennas are independent of these, so one block, the
    one with the most readings, shows what hangs together.
    """
    setup, fit = diagnosis.setup, diagnosis.after
    if not fit.choices:
        return [], []
    block = int(np.argmax(np.bincount(setup.block)))
    gram = diagnosis.weighed.evidence.gram.matrices[block]
    columns = np.concatenate([c.candidate.columns for c in fit.choices])
    names = [
        c.candidate.effect.coefficients[n].name
        for c in fit.choices
        for n in c.candidate.coefficients
    ]
    covariance, _, _, known = inverted(gram[np.ix_(columns, columns)])
    sigma = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    kept = np.flatnonzero(known)
    matrix = (covariance / np.outer(sigma, sigma))[np.ix_(kept, kept)]
    return [names[n] for n in kept], np.clip(matrix, -1, 1).tolist()


def finite(value: Any) -> Any:  # noqa: ANN401 - whatever JSON holds
    """Replace numbers that JSON cannot spell by null."""
    if isinstance(value, dict):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [finite(one) for one in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return value


def _write_rows(diagnosis: Diagnosis, file: Any) -> None:  # noqa: ANN401 - a text file
    """Write one line for each measured number: residuals before and after, and its weight."""
    setup = diagnosis.setup
    at, row = setup.recordings.at, setup.stack.row
    writer = csv.writer(file, lineterminator="\n")
    labels = [name for name in ("antenna", "session", "source", "channel") if name in at]
    quantities = ("residual_before", "residual_after", "heldout_before", "heldout_after")
    in_arcsec = [f"{name}_arcsec" for name in quantities]
    writer.writerow(["line", "axis", *labels, "az_deg", "el_deg", *in_arcsec, "weight"])
    order = np.lexsort((setup.stack.is_y, row))
    of = row[order]

    def shown(values: Array, digits: int) -> list[str]:
        return [f"{one:.{digits}f}" if math.isfinite(one) else "" for one in values.tolist()]

    offsets = (
        diagnosis.left(diagnosis.before),
        diagnosis.left(diagnosis.after),
        diagnosis.unseen.before,
        diagnosis.unseen.after,
    )
    columns = [
        setup.recordings.line[of].tolist(),
        np.where(setup.stack.is_y[order], "el", "xel").tolist(),
        *(np.asarray(at.column(name))[of].tolist() for name in labels),
        *(shown(angle[of] / DEG, 6) for angle in (at.az, at.el)),
        *(shown(one[order] / ARCSEC, 3) for one in offsets),
        shown(diagnosis.weighed.weights[order], 4),
    ]
    writer.writerows(zip(*columns, strict=True))
