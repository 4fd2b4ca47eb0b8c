"""The summary on the terminal: what, where, how big, how sure, what else, what next."""

from __future__ import annotations

import textwrap

import numpy as np

from pyport.angles import ARCSEC
from pyport.diagnosis import noise_words, record, two_axes_words
from pyport.diagnosis.completed import completed
from pyport.diagnosis.diagnose import Diagnosis
from pyport.diagnosis.finding import Finding
from pyport.diagnosis.soundness import nothing, warnings
from pyport.fitting.sizes import axis_rms, sky_rms
from pyport.fitting.table import MOST_COMBINATIONS
from pyport.models import words as corrections

_WIDTH = 96
#: Effects shown with their detection limit when nothing was found.
_LIMITS = 6


def summary(diagnosis: Diagnosis) -> str:
    """Return the diagnosis as plain text."""
    recordings = diagnosis.setup.recordings
    aside, model = len(recordings.set_aside), diagnosis.setup.model.name
    what = f"{len(recordings)} recordings"
    if (made := recordings.reduction) is not None:
        aside = sum(made.set_aside.values())
        what = (
            f"{made.rows} recordings in {made.points} normal points {made.patch_deg:g} deg wide"
            f", {made.outliers} readings outliers"
        )
    lines = [f"{recordings.file.name}: {what}, {aside} excluded, model {model}"]
    if diagnosis.mismatch:
        lines.append(
            f"The model leaves something out (chance of noise alone {_chance(diagnosis)})."
        )
        for n, finding in enumerate(diagnosis.findings, 1):
            lines += _finding(n, finding)
    else:
        chance = "" if diagnosis.too_few else f" (p = {_chance(diagnosis)})"
        lines += _wrapped(f"{nothing(diagnosis)}{chance}.")
        limits = sorted(diagnosis.detection_limits.items(), key=lambda item: item[1])[:_LIMITS]
        if limits:
            seen = ", ".join(f"{effect} {size / ARCSEC:.2g} arcsec" for effect, size in limits)
            lines += _wrapped(f"Would have been seen in half of all cases, as rms: {seen}.")
    lines += _combinations(diagnosis)
    for one in diagnosis.two_axes:
        lines += _wrapped(two_axes_words.sentence(one, diagnosis.setup.recordings.at.mount.names))
    for said in (*noise_words.sentences(diagnosis), *noise_words.dropped(diagnosis)):
        lines += _wrapped(f"{said}.")
    lines += _improvement(diagnosis)
    done = completed(diagnosis)
    if done.completed is not None:
        lines += corrections.lines(done.completed, done.terms)
    for sentence in warnings(diagnosis):
        lines += _wrapped(f"Warning: {sentence}.")
    return "\n".join(lines)


def _combinations(diagnosis: Diagnosis) -> list[str]:
    """Return a line for each combination of coefficients that are not known alone."""
    lines = []
    for together in diagnosis.combinations[:MOST_COMBINATIONS]:
        lines += _wrapped(f"Degenerate terms: {together.sentence}.")
    if (more := len(diagnosis.combinations) - MOST_COMBINATIONS) > 0:
        lines.append(f"Degenerate terms: {more} more combinations, see report.json.")
    return lines


def _finding(n: int, finding: Finding) -> list[str]:
    head = f"{n}. {finding.effect}" + (f" ({finding.variant})" if finding.variant else "")
    lines = [f"{head}, {finding.verdict}: {finding.sentence}."]
    if len(finding.members) > 1:
        lines.append(f"   Could as well be: {', '.join(finding.members[1:])}.")
    if finding.looks_like:
        lines.append(f"   Looks like: {finding.looks_like}.")
    subset = finding.where.subset.get("antenna")
    if subset:
        lines.append(f"   Antennas: {' '.join(subset)}.")
    lines.append(f"   {finding.size[0].upper()}{finding.size[1:]}.")
    if finding.heldout is not None:
        held = finding.heldout
        lines.append(
            f"   On data that the fit had not seen ({held.scheme}): rms "
            f"{held.before / ARCSEC:.3g} -> {held.after / ARCSEC:.3g} arcsec, noise floor "
            f"{held.noise_floor / ARCSEC:.3g}."
        )
    if finding.decide_by:
        lines.append(f"   Next: {finding.decide_by}.")
    return [part for line in lines for part in _wrapped(line)]


def _wrapped(line: str) -> list[str]:
    indent = " " * (len(line) - len(line.lstrip()) or 3)
    return textwrap.wrap(line, _WIDTH, subsequent_indent=indent, drop_whitespace=True)


def _improvement(diagnosis: Diagnosis) -> list[str]:
    """Return what became of the rms, over all readings and, for an array, antenna by antenna."""
    held = diagnosis.heldout
    before, after, floor = (v / ARCSEC for v in (held.before, held.after, held.noise_floor))
    change = f"rms per axis {before:.3g} -> {after:.3g} arcsec, noise floor {floor:.3g}"
    lines = [_in_fit(diagnosis), f"Cross-validated ({held.scheme}): {change}."]
    table = [row for row in record.antennas(diagnosis) if not row["drowns_in_noise"]]
    if len(table) > 1 and diagnosis.mismatch:
        factor = [
            row["heldout_before_arcsec"] / max(row["heldout_after_arcsec"], 1e-9) for row in table
        ]
        lines.append(
            f"Antenna by antenna the held-out rms falls by a factor {np.median(factor):.2f} in the "
            f"median; {sum(f >= 2 for f in factor)} of {len(factor)} fall by two or more."
        )
    if diagnosis.noisy:
        lines.append(f"Drown in their own noise and are not counted: {' '.join(diagnosis.noisy)}.")
    if not diagnosis.weighed.used.all():
        lines.append(
            f"Outliers: {int((~diagnosis.weighed.used).sum())} readings; see weight in rows.csv."
        )
    return [part for line in lines for part in _wrapped(line)]


def _in_fit(diagnosis: Diagnosis) -> str:
    """Return the rms in the fit, per axis and on the sky, and what they are of."""
    setup, used = diagnosis.setup, diagnosis.share > 0
    fits = [diagnosis.left(one) for one in (diagnosis.before, diagnosis.after)]
    told = []
    across, along = setup.recordings.at.mount.names
    for name, found in (
        (across, [axis_rms(setup.stack, one, used, is_y=False) for one in fits]),
        (along, [axis_rms(setup.stack, one, used, is_y=True) for one in fits]),
        ("sky", [sky_rms(setup.stack, one, used) for one in fits]),
    ):
        sizes = [one[0] / ARCSEC for one in found if one is not None]
        if sizes:
            values = " -> ".join(f"{one:.3g}" for one in sizes[: 1 + diagnosis.mismatch])
            told.append(f"{name} {values}")
    return (
        f"In the fit, rms: {', '.join(told)} arcsec; per axis, and on the sky the root of the mean "
        "of x^2 + y^2, outliers excluded, not reduced for fitted terms (as TPOINT's sky rms)."
    )


def _chance(diagnosis: Diagnosis) -> str:
    return f"{diagnosis.p_value:.2g}"
