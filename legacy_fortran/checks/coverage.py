"""Count the branches of the published routines that the property tests take.

    python legacy_fortran/checks/coverage.py

Installs the oracle, instrumented, in a folder of its own, runs the tests of the legacy port against
it, and asks gcov. Exit status 1 when a branch was never taken, or when the tests fail.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from pyport.files import write_whole
from pyport.parity import golden, stored

ROOT = Path(__file__).resolve().parents[2]


def instrumented(folder: Path) -> Path:
    """Install the oracle with coverage counters; return the folder of the reference's objects."""
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps"]
    options = ["-Csetup-args=-Db_coverage=true", f"-Cbuild-dir={folder / 'build'}"]
    _call([*pip, "--target", str(folder / "site"), *options, str(ROOT / "legacy_fortran")])
    return next((folder / "build").glob("_converted.*.p"))


def run_tests(folder: Path) -> None:
    """Run the legacy port's tests against the instrumented oracle."""
    path = os.pathsep.join([str(folder / "site"), str(ROOT)])
    tests = [sys.executable, "-m", "pytest", "-q", "-m", "oracle", "tests/legacy"]
    _call(tests, env={**os.environ, "PYTHONPATH": path, "PYPORT_ORACLE": "required"})


def branches(objects: Path) -> list[dict]:
    """Return each branch of the routines: file, line, and how often each way was taken."""
    rows = []
    for routine in ("model", "modela", "hjump"):
        counts = next(objects.glob(f"*converted_{routine}.f.gcda"))
        report = subprocess.run(  # noqa: S603 - our own files
            ["gcov", "--json-format", "--stdout", "--branch-probabilities", counts.name],  # noqa: S607
            cwd=objects,
            check=True,
            capture_output=True,
            text=True,
        )
        source = (objects.parent / f"converted_{routine}.f").read_text().splitlines()
        rows += [
            {
                "line": f"{routine}.f:{line['line_number']}",
                "text": source[line["line_number"] - 1].strip(),
                "taken": [branch["count"] for branch in line["branches"]],
            }
            for line in json.loads(report.stdout)["files"][0]["lines"]
            if line["branches"]
        ]
    return rows


def _call(command: list[str], **options: object) -> None:
    if subprocess.run(command, cwd=ROOT, check=False, **options).returncode:  # noqa: S603
        sys.exit(f"failed: {' '.join(command)}")


def main() -> None:
    """Count, print and store; complain of branches never taken."""
    with tempfile.TemporaryDirectory() as name:
        objects = instrumented(Path(name))
        run_tests(Path(name))
        rows = branches(objects)
    never = [row for row in rows if 0 in row["taken"]]
    for row in rows:
        print(f"{row['line']:12} {row['text']:60} {' / '.join(map(str, row['taken']))}")  # noqa: T201
    total = sum(len(row["taken"]) for row in rows)
    print(f"{total - len(never)} of {total} branches taken")  # noqa: T201
    content = {
        "schema": "pyport.parity-coverage/1",
        "branches": [{**row, "taken": [count > 0 for count in row["taken"]]} for row in rows],
    }
    with write_whole(stored.FOLDER / "coverage.json") as file:
        file.write(golden.one_row_a_line(content))
    sys.exit(bool(never))


if __name__ == "__main__":
    main()
