"""Diagnose ten fixed inputs with this program and with an earlier commit, and compare the reports.

`make same BASE=COMMIT`. Who moves code promises that nothing else changes. Keys that are new are
allowed, and other words in sentences; keys that are gone and values that differ are listed, and
end it with status 1.
"""

from __future__ import annotations

import argparse
import io
import json
import math
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pyport.examiner.sealed.record.files import write_recordings
from pyport.examiner.worlds.kinds import Spec

ROOT = Path(__file__).parents[2]
#: What is shipped, and what is drawn beside it.
SHIPPED = ("gmrt-2003-03-31", "gmrt-2003-06-01", "gmrt-2003-06-05")
DRAWN = (
    Spec("one", "one", "refraction", 0.5, 300),
    Spec("one", "one", "oscillation", 1.0, 600),
    Spec("one", "one", "epoch_tilt", 1.0, 600),
    Spec("one", "one", "subreflector_jump", 1.0, 600),
    Spec("mounts", "one", "sag_sine", 1.0, 300, mount="fork"),
    Spec("array", "array", rho=0.7, rows=600),
    Spec("unknown", "unknown", "notch_azimuth", 1.0, 600),
)
#: Numbers that differ by less are equal: other loops, other rounding.
ROUNDING = 1e-6


def inputs(folder: Path) -> Iterator[str]:
    """Yield the names of the shipped inputs, and write the others."""
    yield from SHIPPED
    for seed, spec in enumerate(DRAWN):
        path = folder / f"{seed}-{spec.effect or spec.kind}.csv"
        write_recordings(spec.make(seed), path)
        yield str(path)


def report(program: Path, given: str, folder: Path) -> dict[str, Any]:
    """Return what a program says of an input, as report.json holds it."""
    subprocess.run(
        [sys.executable, "-m", "pyport", "diagnose", given, "--out", str(folder), "--quiet"],
        env={**os.environ, "PYTHONPATH": str(program)},
        cwd=folder.parent,
        check=True,
        stdout=subprocess.DEVNULL,
    )
    (found,) = folder.rglob("report.json")
    return json.loads(found.read_text(encoding="utf-8"))


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield every number, word and truth value of a report with its path."""
    if isinstance(value, dict | list):
        for key, one in value.items() if isinstance(value, dict) else enumerate(value):
            yield from leaves(one, f"{path}/{key}")
    else:
        yield path, value


def alike(one: Any, other: Any) -> bool:
    """Tell whether two values are equal to rounding, or both sentences."""
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=ROUNDING, abs_tol=ROUNDING)
    if isinstance(one, str) and isinstance(other, str):
        return one == other or (" " in one and " " in other)
    return bool(one == other)


def main() -> int:
    """Compare, print what differs, return the status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("base", help="the earlier commit")
    parser.add_argument("program", nargs="?", help="another commit in place of this tree")
    asked = parser.parse_args()
    status = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        before = checked_out(asked.base, folder / "before")
        after = checked_out(asked.program, folder / "after") if asked.program else ROOT
        for n, given in enumerate(inputs(folder)):
            both = (
                dict(leaves(report(p, given, folder / f"{n}-{p.name}"))) for p in (before, after)
            )
            old, new = both
            gone = [path for path in old if path not in new]
            other = [path for path in old if path in new and not alike(old[path], new[path])]
            print(f"{Path(given).stem}: {len(old)} values, {len(new)} now; ", end="")
            print(f"{len(gone)} gone, {len(other)} other", flush=True)
            for path in [*gone, *other][:8]:
                print(f"    {path}: {old[path]} -> {new.get(path, 'gone')}")
            status |= bool(gone or other)
    return status


def checked_out(commit: str, folder: Path) -> Path:
    """Return the program of a commit."""
    wanted = [
        "git",
        "-C",
        str(ROOT),
        "archive",
        commit,
        "pyport",
        "golden_tables",
        "legacy_fortran",
    ]
    done = subprocess.run(wanted, capture_output=True, check=True)
    folder.mkdir()
    with tarfile.open(fileobj=io.BytesIO(done.stdout)) as packed:
        packed.extractall(folder, filter="data")
    return folder


if __name__ == "__main__":
    sys.exit(main())
