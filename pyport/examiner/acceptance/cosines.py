"""How much of each unknown form the program's best term can take: cosines beside the model.

The forms are the examiner's, the columns the program's: this measures, it draws and judges nothing.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Problem
from pyport.diagnosis.preparing import prepare
from pyport.examiner import program
from pyport.examiner.sealed.record.files import write_recordings
from pyport.examiner.worlds.case import Case as Made
from pyport.examiner.worlds.faults import UNKNOWN
from pyport.examiner.worlds.kinds import make_case
from pyport.formats.models import load
from pyport.recordings import read

ROWS = 600
#: Columns that the model leaves less than this share of are nothing beside it.
_LEAST = 1e-6


@dataclass(frozen=True)
class Case:
    """Which form is drawn, and from which seed."""

    form: str
    seed: int


def cases(count: int, seed: int) -> list[Case]:
    """Return `count` cases of each form."""
    return [Case(form, seed + n) for n in range(count) for form in UNKNOWN]


def examine(case: Case) -> dict[str, Any]:
    """Return the largest cosine of a form with what has a name."""
    made = make_case("unknown", case.seed, effect=case.form, rows=ROWS, rho=1.0, noise="white")
    return {**vars(case), "program": program.version(), **of_made(made)}


def of_made(made: Made) -> dict[str, Any]:
    """Return the largest cosine of what is hidden in a case behind the classical model."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "recordings.csv"
        write_recordings(made, file)
        problem = prepare(read(file), load("altaz"), None, 0)
    cosine, name = largest(problem, made, problem.candidates)
    return {"named_cosine": cosine, "named": name}


def largest(problem: Problem, made: Made, some: Sequence[Candidate]) -> tuple[float, str]:
    """Return the largest cosine of a hidden form with candidates beside the model, and whose."""
    axis, row = problem.stack.is_y.astype(int), problem.stack.row
    base = np.linalg.qr(np.stack(made.base)[axis, row])[0]

    def left(columns: Array) -> Array:
        return np.asarray(columns - base @ (base.T @ columns))

    form = left(np.stack(made.signature)[axis, row])
    best = (0.0, "none")
    for one in some:
        before = problem.picked(one.columns)
        beside = left(before)
        size = np.linalg.norm(beside, axis=0)
        seen = size > _LEAST * np.linalg.norm(before, axis=0)
        if seen.any():
            basis, strength, _ = np.linalg.svd(beside[:, seen] / size[seen], full_matrices=False)
            along = basis[:, strength > _LEAST].T @ form
            name = f"{one.effect.id} {one.effect.variant}".strip()
            best = max(best, (float(np.linalg.norm(along) / np.linalg.norm(form)), name))
    return best


def text(outcomes: Iterable[dict[str, Any]]) -> str:
    """Return a line for each form: its largest cosine, and with what."""
    outcomes = list(outcomes)
    lines = [f"{'form':20}{'cosine':>7}  with"]
    for form in dict.fromkeys(one["form"] for one in outcomes):
        own = [one for one in outcomes if one["form"] == form]
        most = max(own, key=lambda one: float(one["named_cosine"]))
        lines.append(f"{form:20}{most['named_cosine']:7.2f}  {most['named']}")
    return "\n".join(lines)
