"""Count the branches of the Fortran that the inputs take, with gcov."""

from __future__ import annotations

import dataclasses
import json
import shutil
import subprocess
import tempfile
from multiprocessing import Process
from pathlib import Path
from typing import Any

import numpy as np

from pyport.errors import BadInput
from pyport.parity import promise
from pyport.parity.compare import Comparison, Pair
from pyport.parity.compiled import build as building
from pyport.parity.compiled import driver, oracle, stored
from pyport.parity.compiled.oracle import Oracle
from pyport.parity.compiled.oracle import of as oracle_of
from pyport.parity.described import inputs
from pyport.parity.described.description import Batch, Build, Description, Port, Routine
from pyport.parity.described.functions import filled, part, size
from pyport.parity.report import ulp
from pyport.runs.stages import track


def coverage(description: Description, random_points: int) -> dict[str, Any]:
    """Compile with counters, ask every routine at every group's points, and count.

    Returns for each branch its line, text, and whether each way was taken; the lines never
      reached.
    """
    gcov = shutil.which("gcov")
    if gcov is None:
        raise BadInput("no gcov on this machine: expected GNU's compilers")
    flags = (*description.reference.flags, "--coverage")
    counted = dataclasses.replace(description.reference, flags=flags)
    texts = building.sources(description, description.reference)
    library = building.library(description, counted, changed={})
    try:
        process = Process(target=_ask_all, args=(description, str(library), random_points))
        process.start()
        process.join()
        if process.exitcode != 0:
            raise BadInput("a routine ends the program (STOP, or a crash): expected it to return")
        rows, silent = [], []
        for path in description.files:
            counts = _counts(gcov, library.parent, path)
            text = texts[path.name].splitlines()
            for line in counts:
                place = f"{path.name}:{line['line_number']}"
                said = text[line["line_number"] - 1].strip()
                if line["branches"]:
                    taken = [branch["count"] > 0 for branch in line["branches"]]
                    rows.append({"line": place, "text": said, "taken": taken})
                if not line["count"]:
                    silent.append({"line": place, "text": said})
    finally:
        shutil.rmtree(library.parent, ignore_errors=True)
    return {"schema": "pyport.parity-coverage/1", "branches": rows, "never_reached": silent}


def _counts(gcov: str, folder: Path, path: Path) -> list[dict[str, Any]]:
    with tempfile.TemporaryDirectory() as elsewhere:
        report = subprocess.run(  # noqa: S603 - gcov on our own files
            [gcov, "--json-format", "--stdout", "--branch-probabilities", "-o", str(folder),
             str(folder / f"{path.stem}.gcda")],
            cwd=elsewhere, check=False, capture_output=True, text=True,
        )  # fmt: skip
    if report.returncode or not report.stdout.strip():
        raise BadInput(f"gcov says nothing of {path.name}: {report.stderr.strip()}")
    files = json.loads(report.stdout)["files"]
    lines: list[dict[str, Any]] = [line for one in files for line in one["lines"]]
    return lines


def _ask_all(description: Description, library: str, random_points: int) -> None:
    """Call every loop at every group's points, and have the counters written."""
    loaded = oracle.imported(library)
    for number, routine in enumerate(description.routines):
        for group in description.groups:
            batch = inputs.points(description, group, routine, random_points, 0)
            whole = filled(routine, batch)
            arrays = [whole[one.key] for one in driver.passed(routine)]
            oracle.call(loaded, number, arrays)
    getattr(loaded, driver.WRITE_COUNTERS)()


def show(content: dict[str, Any]) -> str:
    """Return the branches as text."""
    rows = content["branches"]
    lines = []
    for row in rows:
        taken = " / ".join("yes" if one else "NO" for one in row["taken"])
        lines.append(f"{row['line']:16} {row['text']:60} {taken}")
    never = sum(row["taken"].count(False) for row in rows)
    total = sum(len(row["taken"]) for row in rows)
    lines += [f"never reached: {row['line']} {row['text']}" for row in content["never_reached"]]
    return "\n".join([*lines, f"{total - never} of {total} branches taken"])


def complete(content: dict[str, Any]) -> bool:
    """Tell whether every branch was taken, both ways."""
    return all(all(row["taken"]) for row in content["branches"])


#: Where answers are compared as numbers: within the limits, zeros of either sign equal no others.
_ANY = Port("any", "ulp")


def matrix(description: Description, random_points: int) -> dict[str, Any]:
    """Build, ask and compare every build whose compiler is installed; distances in ulp.

    Distances in the outputs' units leave out what the ledger of deviations explains, where a last
    bit decides between two answers.
    """
    reference = oracle_of(description.path, "reference")
    asked: list[tuple[Routine, Batch, Batch]] = []
    for routine in description.routines:
        at = inputs.some(description, routine, random_points, 10)
        at = part(at, promise.promised(routine, at))
        asked.append((routine, at, reference.ask(routine, at)))
    rows = [
        _row(description, dataclasses.replace(one, compiler=command), asked)
        for one in track(description.matrix, "Building")
        if (command := building.command_of(one.compiler))
    ]
    return {
        "schema": "pyport.parity-matrix/2",
        "points": max(size(at) for _, at, _ in asked),
        "provenance": stored.describe(description),
        "rows": rows,
    }


def _row(
    description: Description, build: Build, asked: list[tuple[Routine, Batch, Batch]]
) -> dict[str, Any]:
    oracle = Oracle(description, build)
    pairs: list[tuple[Comparison, Comparison]] = []
    for routine, at, expected in asked:
        answers = oracle.ask(routine, at)
        with np.errstate(over="ignore"):
            actual = {one.key: answers[one.key].astype(one.type.dtype()) for one in routine.outputs}
        pair = Pair(routine, at, expected, actual)
        held = promise.hold(description, _ANY, pair)
        pairs += zip(pair.compare(), held.outside, strict=True)
    oracle.close()
    return {
        "build": build.name,
        "compiler": building.version(build.compiler),
        "outputs": [
            {
                "routine": plain.routine,
                "output": plain.output,
                "differing": plain.differing,
                "p99_ulp": plain.quantile(0.99),
                "max_distance": float(f"{outside.physical:.2g}"),
            }
            for plain, outside in pairs
        ],
    }


def show_matrix(content: dict[str, Any]) -> str:
    """Return the matrix as text: answers that differ / p99 ulp / worst in the output's unit."""
    head = "differing / p99 ulp / worst distance"
    names = [f"{o['routine']} {o['output']}" for o in content["rows"][0]["outputs"]]
    lines = [f"{head:52}" + "".join(f"{name:>26}" for name in names)]
    for one in content["rows"]:
        cells = [
            f"{o['differing']:,} / {ulp(o['p99_ulp'])} / {o['max_distance']:g}"
            for o in one["outputs"]
        ]
        lines.append(f"{one['build']:52}" + "".join(f"{cell:>26}" for cell in cells))
    return "\n".join(lines)
