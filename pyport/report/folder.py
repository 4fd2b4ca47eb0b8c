"""The folder of a diagnosis: files of one run, and of no other.

report.json is written last and holds the hash of every file beside it. A run
that is killed between two files leaves a folder whose files are not those that
its report names, and that can be seen.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Container, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.diagnosis.diagnose import Diagnosis
from pyport.errors import BadInput
from pyport.files import sha256, write_whole
from pyport.pointing import kernel
from pyport.report.made import report_of
from pyport.report.typed import Report, as_json

REPORT = "report.json"
#: What a diagnosis writes beside its report.
_COMPANIONS = ("rows.csv", "report.html", "finding-[0-9]*-*.png", "array-places.png")


def write(
    diagnosis: Diagnosis,
    folder: Path,
    report: Report | None = None,
    beside: Iterable[Path] = (),
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
