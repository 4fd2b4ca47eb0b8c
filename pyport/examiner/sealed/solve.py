"""Solving a sealed set: each case in a process of its own that has the recordings and no more."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.examiner.sealed.record.compact import compact, rows_of
from pyport.examiner.sealed.record.published import check_report, read_json, read_seal
from pyport.examiner.sealed.seal import Folder, check_untouched
from pyport.examiner.worlds.kinds import files_of
from pyport.files import sha256, write_file
from pyport.runs.stages import track

#: What solves, when nothing else is asked for: a module and its first arguments.
SOLVER = ("pyport", "diagnose")
_TIMEOUT_S = 900.0
#: Signals that come from outside (a key, a shutdown, a machine out of memory) and say nothing of
#: the solver.
_FROM_OUTSIDE = frozenset({-signal.SIGINT, -signal.SIGTERM, -signal.SIGKILL})


@dataclass(frozen=True)
class Task:
    """One case to solve, and by whom."""

    folder: Folder
    case: str
    arguments: tuple[str, ...]
    solver: tuple[str, ...]


def unsolved(root: Path, solver: Sequence[str]) -> list[Task]:
    """Return the cases that have no report yet."""
    folder = Folder(root)
    return [
        Task(folder, one["case"], tuple(one["arguments"]), tuple(solver))
        for one in read_seal(folder.seal)["cases"]
        if not folder.report(one["case"]).exists()
    ]


def run(
    root: Path, jobs: int = 1, solver: Sequence[str] = SOLVER, cluster: str | None = None
) -> int:
    """Solve what is not solved yet and return how many cases that were.

    Every report is kept as soon as it is there: killed and called again, it goes on.
    The workers of a Dask `cluster` must see the set under the same name.

    Raises `BadInput`: the set has been opened, or is not what was sealed.
    """
    check_untouched(root)
    if Folder(root).answers.exists():
        raise BadInput("this set has been opened: expected a sealed one", root)
    tasks = unsolved(root.resolve() if cluster else root, solver)
    if cluster is not None:
        from pyport.runs.workers import workers

        with workers(cluster=cluster) as spread:
            return sum(1 for _ in track(spread(solve, tasks), "solving", total=len(tasks)))
    with ThreadPoolExecutor(jobs) as pool:
        return sum(1 for _ in track(pool.map(solve, tasks), "solving", total=len(tasks)))


def solve(task: Task) -> None:
    """Solve one case; a solver that fails is recorded as having failed, with what it said."""
    with tempfile.TemporaryDirectory(prefix="cell-") as name:
        cell = Path(name)
        recordings = cell / "recordings.csv"
        shutil.copyfile(task.folder.recordings(task.case), recordings)
        for name_, text in files_of(task.arguments).items():
            (cell / name_).write_text(text, encoding="utf-8")
        started = time.monotonic()
        failure = _sit(task, recordings, cell / "out")
        took_s = time.monotonic() - started
        _keep(task, cell / "out" / recordings.stem, failure, took_s)


def _sit(task: Task, recordings: Path, out: Path) -> str | None:
    """Let the solver work; return why it failed, or None."""
    module, *first = task.solver
    command = [
        *(
            sys.executable,
            "-m",
            "pyport.examiner.sealed.cell",
            str(task.folder.vault.resolve()),
            module,
        ),
        *(*first, recordings.name, "--out", str(out), *task.arguments),
    ]
    kept = {
        key: os.environ[key] for key in ("PATH", "HOME", "LANG", "PYTHONPATH") if key in os.environ
    }
    try:
        done = subprocess.run(  # noqa: S603 - our own interpreter
            command,
            cwd=recordings.parent,
            env={**kept, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
            capture_output=True,
            text=True,
            timeout=_TIMEOUT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"no answer within {_TIMEOUT_S:.0f} s"
    if done.returncode in _FROM_OUTSIDE:
        raise KeyboardInterrupt  # no answer, to be asked again
    if done.returncode:
        return done.stderr.strip()[-2000:] or f"exit status {done.returncode}"
    return None


def _keep(task: Task, answer: Path, failure: str | None, took_s: float) -> None:
    """Write an answer into the set."""
    examined: dict[str, Any] = {"seconds": round(took_s, 2)}
    content: dict[str, Any] = {}
    if failure is None:
        content, failure = _answered(answer)
    if failure is not None:
        examined["failed"] = failure
    else:
        examined["report_sha256"] = sha256(answer / "report.json")
    keep(task.folder, task.case, {**content, "examined": examined})


def keep(folder: Folder, case: str, report: dict[str, Any]) -> None:
    """Write a compact report, last, so that a report means that all is there, and its rows."""
    if report.get("left_out"):
        write_file(folder.rows(case), rows_of(report["left_out"]))
    text = json.dumps(report, separators=(",", ":"), ensure_ascii=False)
    write_file(folder.report(case), text)


def _answered(answer: Path) -> tuple[dict[str, Any], str | None]:
    """Return what is kept of a solver's report, or nothing and why there is none to score."""
    report = answer / "report.json"
    if not report.exists():
        return {}, "the solver ended well and left no report.json"
    try:
        return compact(check_report(read_json(report), report), answer / "rows.csv"), None
    except BadInput as error:
        return {}, f"the solver's report.json cannot be scored: {error.message}"
