"""The report of a diagnosis, made from what was computed: every number and word of it."""

from __future__ import annotations

from typing import Any

import numpy as np

from pyport.angles import ARCSEC
from pyport.diagnosis.arrays.report import ArrayReport
from pyport.diagnosis.diagnose import Diagnosis
from pyport.diagnosis.disagreements import Disagreement
from pyport.diagnosis.joint import Joint, rms
from pyport.diagnosis.naming import words
from pyport.diagnosis.naming.noise_remarks import NoiseRemarks, noise_remarks, sentences
from pyport.diagnosis.naming.remarks import determines_nothing, nothing, warnings
from pyport.errors import BadInput
from pyport.fitting.soundness import ON_SKY, PER_AXIS, rms_of
from pyport.least_squares.gram import inverted
from pyport.models import complete as corrections
from pyport.models import toml
from pyport.models.model import Model
from pyport.recordings.schema import Recordings, as_input
from pyport.report.array import as_json as array_json
from pyport.report.finding import combination_of, completed, finding_of, held_out_of
from pyport.report.typed import (
    SCHEMA,
    Antenna,
    Cause,
    Correlation,
    Departure,
    Drift,
    Dropped,
    Excluded,
    Figures,
    Fits,
    Growth,
    Halves,
    Held,
    Input,
    MountOf,
    Noise,
    OfAxis,
    OfBoth,
    Report,
    Rms,
    TwoAxes,
)  # fmt: skip


def report_of(diagnosis: Diagnosis, array: ArrayReport | None = None) -> Report:
    """Return what a diagnosis says; of several antennas with what they share."""
    problem, mount = diagnosis.problem, diagnosis.problem.recordings.at.mount
    whole, noise = completed(diagnosis), noise_remarks(diagnosis)
    open_ = whole.completed is not None and whole.completed.undetermined
    return Report(
        schema=SCHEMA,
        input=_input(problem.recordings, diagnosis),
        model=Held(problem.model.name, tuple(c.candidate.effect.id for c in problem.base)),
        mount=MountOf(mount.id, dict(zip(("xel", "el"), mount.names, strict=True))),
        noise=_noise(diagnosis, noise),
        verdict=None if diagnosis.mismatch else nothing(diagnosis, noise),
        mismatch=diagnosis.mismatch,
        p_value=diagnosis.p_value,
        detection_limit_arcsec={
            effect: size / ARCSEC for effect, size in diagnosis.detection_limits.items()
        },
        findings=tuple(map(finding_of, diagnosis.findings)),
        fit=Fits(
            _rms(diagnosis, diagnosis.before),
            _rms(diagnosis, diagnosis.after),
            held_out_of(diagnosis.heldout),
            PER_AXIS,
            ON_SKY,
        ),
        combinations=() if open_ else tuple(map(combination_of, diagnosis.combinations)),
        dropped=tuple(
            Dropped(**vars(one)) for one in (*diagnosis.dropped, diagnosis.nearest) if one
        ),
        two_axes=tuple(_two_axes(one, mount.names) for one in diagnosis.two_axes),
        antennas=_antennas(diagnosis),
        not_testable={one.effect: one.reason for one in diagnosis.untestable},
        correlation=correlation(diagnosis),
        condition_number=diagnosis.after.solution.condition,
        warnings=(*problem.recordings.notes, *warnings(diagnosis, noise)),
        completed_model=_completed(whole),
        array=None if array is None else array_json(array),
        misread=diagnosis.misread,
        determines_nothing=determines_nothing(diagnosis),
        too_few=diagnosis.too_few is not None,
        noisy=tuple(diagnosis.noisy),
        corrections=tuple(_corrections(diagnosis, whole)),
    )


def _corrections(diagnosis: Diagnosis, whole: Model) -> list[str]:
    """Return the table of what to enter; none of a file that may have been misread."""
    if whole.completed is None:
        return []
    if diagnosis.misread:
        return ["nothing to enter before it is known how this file is to be read"]
    return corrections.lines(whole.completed, whole.terms)


def _two_axes(one: Disagreement, names: tuple[str, str]) -> TwoAxes:
    found = words.two_axes_json(one, names)
    return TwoAxes(
        **found
        | {
            "parameters": tuple(
                OfBoth(each["name"], each["unit"], OfAxis(**each["xel"]), OfAxis(**each["el"]))
                for each in found["parameters"]
            ),
            "halves": tuple(
                Halves(_figures(each["between_axes"]), _figures(each["between_halves"]))
                for each in found["halves"]
            ),
            "causes": tuple(
                Cause(each["effect"], Figures(**each["leaves"])) for each in found["causes"]
            ),
        }
    )


def _figures(figures: dict[str, dict[str, float | None]]) -> dict[str, Figures]:
    return {name: Figures(**one) for name, one in figures.items()}


def _completed(model: Model) -> dict[str, Any] | None:
    """Return the completed model, its findings apart, which the report has; None without one.

    There is none where a model has terms, made in Python, that no file can hold, or more
    coefficients than offsets were measured.
    """
    try:
        whole = toml.tree(model)
    except BadInput:
        return None
    whole.pop("finding", None)
    return whole


def _input(recordings: Recordings, diagnosis: Diagnosis) -> Input:
    values = as_input(recordings)
    aside = tuple(Excluded(**one) for one in values.pop("set_aside"))
    return Input(**values, set_aside=aside, outliers=int((~diagnosis.weighed.used).sum()))


def _noise(diagnosis: Diagnosis, does: NoiseRemarks) -> Noise:
    """Return the noise per axis: the median over the antennas, and the longest drift time."""
    parts = list(zip(diagnosis.problem.parts, diagnosis.weighed.covariance.shown, strict=True))
    across, along = ([noise for part, noise in parts if part.is_y == is_y] for is_y in (0, 1))
    times = [noise.time_s for _, noise in parts if noise.time_s is not None]
    return Noise(
        _median_floor(across),
        _median_floor(along),
        max(times, default=None),
        parts[0][1].how if parts else "reml",
        tuple(Departure(**one) for one in does.departing),
        tuple(Drift(**one) for one in does.drifting),
        tuple(Growth(**one) for one in does.growing),
        tuple(sentences(does, diagnosis.problem.recordings.meta)),
    )


def _median_floor(noises: list[Any]) -> float | None:
    return float(np.median([noise.floor for noise in noises])) / ARCSEC if noises else None


def _rms(diagnosis: Diagnosis, fit: Joint) -> Rms:
    sizes = rms_of(diagnosis.problem.stack, diagnosis.left(fit), diagnosis.share > 0)
    return Rms(*(None if one is None else one[0] / ARCSEC for one in sizes))


def _antennas(diagnosis: Diagnosis) -> tuple[Antenna, ...]:
    """Return for each antenna of an array its rms before and after, in the fit and held out."""
    problem = diagnosis.problem
    names = np.unique(problem.antenna)
    in_fit = diagnosis.left(diagnosis.before), diagnosis.left(diagnosis.after)
    held_out = diagnosis.unseen.before, diagnosis.unseen.after
    found = []
    for name in names if len(names) > 1 else ():
        rows = (problem.antenna == name) & diagnosis.weighed.used
        both = (problem.antenna == name) & diagnosis.unseen.counted
        found.append(
            Antenna(
                str(name),
                int(rows.sum()),
                str(name) in diagnosis.noisy,
                *(rms(one[rows]) / ARCSEC for one in in_fit),
                *(rms(one[both]) / ARCSEC for one in held_out),
            )
        )
    return tuple(found)


def correlation(diagnosis: Diagnosis) -> Correlation:
    """Return names and correlations of what one antenna in one session sees, base and findings.

    Coefficients of other antennas are independent of these, so one block, the
    one with the most readings, shows what hangs together.
    """
    problem, fit = diagnosis.problem, diagnosis.after
    if not fit.choices:
        return Correlation((), ())
    block = int(np.argmax(np.bincount(problem.block)))
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
    rows = tuple(map(tuple, np.clip(matrix, -1, 1).tolist()))
    return Correlation(tuple(names[n] for n in kept), rows)
