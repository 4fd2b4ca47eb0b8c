"""The folder of a diagnosis, files of one run and of no other; and its text for the terminal.

report.json is written last and holds the hash of every file beside it. A run
that is killed between two files leaves a folder whose files are not those that
its report names, and that can be seen.
"""

from __future__ import annotations

import csv
import json
import math
import textwrap
from collections.abc import Container, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.diagnosis.diagnose import Diagnosis
from pyport.errors import BadInput
from pyport.files import sha256, write_whole
from pyport.fitting.table import MOST_COMBINATIONS
from pyport.pointing import kernel
from pyport.recordings.schema import counted
from pyport.report.made import report_of
from pyport.report.typed import Dropped, Finding, HeldOut, Report, as_json

_WIDTH = 96
#: Effects shown with their detection limit when nothing was found.
_LIMITS = 6
#: Lines of excluded rows that are shown for each reason.
_LINES = 8


def text(report: Report) -> str:
    """Return a report as plain text."""
    lines = [f"{counted(vars(report.input))}, model {report.model.name}", *_excluded(report)]
    for said in filter(None, (report.misread, report.determines_nothing)):
        lines += _wrapped(said)
    if report.mismatch:
        model = "As the file stands, the model" if report.misread else "The model"
        lines.append(f"{model} leaves something out (chance of noise alone {_chance(report)}).")
        for n, finding in enumerate(report.findings, 1):
            lines += _finding(n, finding)
    else:
        chance = "" if report.too_few else f" (p = {_chance(report)})"
        lines += _wrapped(f"{report.verdict}{chance}.")
        limits = sorted(report.detection_limit_arcsec.items(), key=lambda item: item[1])[:_LIMITS]
        if limits:
            seen = ", ".join(f"{effect} {size:.2g} arcsec" for effect, size in limits)
            lines += _wrapped(f"Would have been seen in half of all cases, as rms: {seen}.")
    for together in report.combinations[:MOST_COMBINATIONS]:
        lines += _wrapped(f"Degenerate terms: {together.sentence}.")
    if (more := len(report.combinations) - MOST_COMBINATIONS) > 0:
        lines.append(f"Degenerate terms: {more} more combinations, see report.json.")
    for one in report.two_axes:
        lines += _wrapped(one.sentence)
    for said in (*report.noise.sentences, *map(_dropped, report.dropped)):
        lines += _wrapped(f"{said}.")
    lines += _improvement(report)
    lines += report.corrections
    for sentence in report.warnings:
        lines += _wrapped(f"Warning: {sentence}.")
    return "\n".join(lines)


def _excluded(report: Report) -> list[str]:
    """Return why rows are excluded, and which; of many lines the first."""
    lines_of: dict[str, list[str]] = {}
    for one in report.input.set_aside:
        lines_of.setdefault(one.reason, []).append(str(one.line))
    said = []
    for reason, lines in lines_of.items():
        more = f" and {len(lines) - _LINES} more" if len(lines) > _LINES else ""
        word = "line" if len(lines) == 1 else "lines"
        said += _wrapped(f"Excluded, {word} {', '.join(lines[:_LINES])}{more}: {reason}.")
    return said


def _finding(n: int, finding: Finding) -> list[str]:
    head = f"{n}. {finding.effect}" + (f" ({finding.variant})" if finding.variant else "")
    lines = [f"{head}, {finding.verdict}: {finding.sentence}."]
    if len(finding.class_) > 1:
        lines.append(f"   Could as well be: {', '.join(finding.class_[1:])}.")
    if finding.looks_like:
        lines.append(f"   Looks like: {finding.looks_like}.")
    if finding.where.between:
        lines.append(f"   It began between {' and '.join(finding.where.between)}.")
    if subset := finding.where.subset.get("antenna"):
        lines.append(f"   Antennas: {' '.join(subset)}.")
    lines.append(f"   {finding.size[0].upper()}{finding.size[1:]}.")
    if (held := finding.heldout) is not None:
        lines.append(
            f"   On data that the fit had not seen ({held.scheme}): rms {_change(held)}, "
            f"noise floor {held.noise_floor_arcsec:.3g}."
        )
    if finding.decide_by:
        lines.append(f"   Next: {finding.decide_by}.")
    return [part for line in lines for part in _wrapped(line)]


def _dropped(one: Dropped) -> str:
    which = f"{one.effect} ({one.variant})" if one.variant else one.effect
    return f"Looked at and dropped: {which}: {one.reason}"


def _wrapped(line: str) -> list[str]:
    indent = " " * (len(line) - len(line.lstrip()) or 3)
    return textwrap.wrap(line, _WIDTH, subsequent_indent=indent, drop_whitespace=True)


def _improvement(report: Report) -> list[str]:
    """Return what became of the rms, over all readings and, for an array, antenna by antenna."""
    held = report.fit.heldout
    change, floor = f"rms per axis {_change(held)}", f"noise floor {held.noise_floor_arcsec:.3g}"
    lines = [_in_fit(report), f"Cross-validated ({held.scheme}): {change}, {floor}."]
    table = [one for one in report.antennas if not one.drowns_in_noise]
    if len(table) > 1 and report.mismatch:
        factor = [one.heldout_before_arcsec / max(one.heldout_after_arcsec, 1e-9) for one in table]
        lines.append(
            f"Antenna by antenna the held-out rms falls by a factor {np.median(factor):.2f} in the "
            f"median; {sum(f >= 2 for f in factor)} of {len(factor)} fall by two or more."
        )
    if report.noisy:
        lines.append(f"Drown in their own noise and are not counted: {' '.join(report.noisy)}.")
    if report.input.outliers:
        lines.append(f"Outliers: {report.input.outliers} readings; see weight in rows.csv.")
    return [part for line in lines for part in _wrapped(line)]


def _change(held: HeldOut) -> str:
    """Return the rms before and after, and by how much it falls with its error."""
    before, after = held.rms_before_arcsec, held.rms_after_arcsec
    change = f"{before:.3g} -> {after:.3g} arcsec"
    if not held.rms_fall_sigma_arcsec:
        return change
    return f"{change} (less by {before - after:.3g} +- {held.rms_fall_sigma_arcsec:.2g})"


def _in_fit(report: Report) -> str:
    """Return the rms in the fit, per axis and on the sky, and what they are of."""
    fits, said = (report.fit.before, report.fit.after), []
    for name, key in (*((axis, key) for key, axis in report.mount.axes.items()), ("sky", "sky")):
        sizes = [getattr(one, f"rms_{key}_arcsec") for one in fits]
        values = [f"{one:.3g}" for one in sizes if one is not None][: 1 + report.mismatch]
        if values:
            said.append(f"{name} {' -> '.join(values)}")
    return (
        f"In the fit, rms: {', '.join(said)} arcsec; per axis, and on the sky the root of the mean "
        "of x^2 + y^2, outliers excluded, not reduced for fitted terms (as TPOINT's sky rms)."
    )


def _chance(report: Report) -> str:
    return f"{report.p_value:.2g}"


REPORT = "report.json"
#: What a diagnosis writes beside its report.
_COMPANIONS = ("rows.csv", "report.html", "finding-[0-9]*-*.png", "array-places.png")


def write(
    diagnosis: Diagnosis, folder: Path, report: Report | None = None, beside: Iterable[Path] = ()
) -> dict[str, Any]:
    """Write rows.csv and then report.json into a folder, each whole or not at all.

    The report, which is returned as JSON has it, holds the hashes of rows.csv and of the files
    that were written `beside` it.
    """
    rows = folder / "rows.csv"
    with write_whole(rows) as file:
        write_rows(diagnosis, file)
    return finish(folder, as_json(report or report_of(diagnosis)), [rows, *beside])


def finish(folder: Path, report: dict[str, Any], companions: Iterable[Path]) -> dict[str, Any]:
    """Write report.json with what computed it and the hashes of the files beside it; return it.

    What earlier runs left there under names of the program's own is removed.
    """
    files = {path.name: sha256(path) for path in companions}
    whole = report | {"computed_with": kernel.path(), "files": files}
    with write_whole(folder / REPORT) as file:
        json.dump(whole, file, indent=1, allow_nan=False)
        file.write("\n")
    for path in _others(folder, whole["files"]):
        path.unlink(missing_ok=True)
    return whole


def check(folder: Path) -> int:
    """Return how many files stand beside a report, all of them written with it.

    Raises `BadInput`: there is no report, or one that names no files, or a file is of another run.
    """
    named = _named(folder / REPORT)
    if not named:
        raise BadInput("no report that names the files beside it: run it again", folder / REPORT)
    for name, expected in sorted(named.items()):
        path = folder / name
        if not path.is_file():
            raise BadInput("this file is missing: run the diagnosis again", path)
        if sha256(path) != expected:
            raise BadInput(
                "this file is not the one that report.json was written with: run the diagnosis"
                " again",
                path,
            )
    for path in _others(folder, named):
        raise BadInput(
            "this file is of another run than report.json: run the diagnosis again", path
        )
    return len(named)


def _others(folder: Path, named: Container[str]) -> list[Path]:
    """Return what stands in a folder under names of a diagnosis's files, and is not named."""
    there = {one for pattern in _COMPANIONS for one in folder.glob(pattern)}
    return sorted(one for one in there if one.name not in named)


def _named(report: Path) -> dict[str, str]:
    """Return name and hash of the files that a report names; nothing where it names none."""
    try:
        files = json.loads(report.read_text(encoding="utf-8"))["files"]
        return {name: str(known) for name, known in files.items() if Path(name).name == name}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {}


def write_rows(diagnosis: Diagnosis, file: Any) -> None:  # noqa: ANN401 - a text file
    """Write one line for each measured number: residuals before and after, and its weight."""
    problem = diagnosis.problem
    at, row = problem.recordings.at, problem.stack.row
    writer = csv.writer(file, lineterminator="\n")
    labels = [name for name in ("antenna", "session", "source", "channel") if name in at]
    quantities = ("residual_before", "residual_after", "heldout_before", "heldout_after")
    in_arcsec = [f"{name}_arcsec" for name in quantities]
    writer.writerow(["line", "axis", *labels, "az_deg", "el_deg", *in_arcsec, "weight"])
    order = np.lexsort((problem.stack.is_y, row))
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
        problem.recordings.line[of].tolist(),
        np.where(problem.stack.is_y[order], "el", "xel").tolist(),
        *(np.asarray(at.column(name))[of].tolist() for name in labels),
        *(shown(angle[of] / DEG, 6) for angle in (at.az, at.el)),
        *(shown(one[order] / ARCSEC, 3) for one in offsets),
        shown(diagnosis.weighed.weights[order], 4),
    ]
    writer.writerows(zip(*columns, strict=True))
