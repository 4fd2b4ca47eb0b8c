"""The same answer on every machine: python tests/reliability/machines.py.

Twelve fixed inputs are diagnosed as this machine does it, and again as others would:
without the processor's newer instructions (numpy's loops, OpenBLAS's kernels and the
compiled kernel's), without the compiled kernel, on one core and on two, and by other
Pythons with other libraries where they are named. Findings, verdicts and every other
word must be equal, and each parameter within a millionth of its sigma. What differs is
printed, with where it differs most; numbers that are no parameters are printed by how
much they differ.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pyport.examiner.sealed.protocol import Spec
from pyport.examiner.sealed.record.files import write_recordings
from pyport.pointing.compiled import KERNEL

ROOT = Path(__file__).parents[2]
#: The greatest difference of a parameter, in its sigmas.
PROMISED_SIGMAS = 1e-6
ROWS = 120
#: The input of which every third pointing was read twice.
AGAIN = "again"
INPUTS = (
    Spec("null", "null", rows=ROWS, noise="white"),
    *(Spec("one", "one", effect, 1.0, ROWS) for effect in ("refraction", "azimuth_harmonics")),
    Spec("degenerate", "degenerate", "latitude", 1.0, ROWS),
    Spec("two", "two", "refraction+beam_squint", 1.0, ROWS),
    Spec("unknown", "unknown", "spiral", 1.0, ROWS),
    Spec("region", "unknown", "region", 1.0, ROWS),
    Spec("curve", "one", "subreflector_jump", 1.0, ROWS),
    Spec("moment", "one", "epoch_offset", 1.0, ROWS),
    Spec("places", "null", rows=2 * ROWS, little="place"),
    Spec(AGAIN, "one", "epoch_tilt", 1.0, ROWS),
)
#: Shipped recordings, one more input, and the model that was published with them.
SHIPPED = ("gmrt-2003-03-31", "gmrt-paper")
#: What a report says of the machine, and what its files' last digits make.
MACHINE = frozenset({"computed_with", "files"})
OLDER_BLAS = ("Haswell", "Nehalem")


@dataclass(frozen=True)
class Machine:
    """A way to run the program: another processor, other cores, another Python or checkout."""

    name: str
    python: str = sys.executable
    environment: dict[str, str] = field(default_factory=dict)
    cores: int = 1
    program: Path = ROOT


def machines(pythons: list[str]) -> list[Machine]:
    """Return this machine first, then what it can stand in for."""
    from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

    newer = [one for one in __cpu_dispatch__ if __cpu_features__[one]]
    found = [Machine("this machine, one core")]
    older = KERNEL.levels()[1:] if KERNEL is not None else []
    found += [Machine(f"kernel by {one}", environment={"PYPORT_KERNEL": one}) for one in older]
    if KERNEL is not None:
        found.append(Machine("without the kernel", environment={"PYPORT_KERNEL": "off"}))
    for number in range(len(newer)):
        off = " ".join(newer[number:])
        found.append(Machine(f"numpy without {off}", environment={"NPY_DISABLE_CPU_FEATURES": off}))
    found += [
        Machine(f"OpenBLAS of a {core}", environment={"OPENBLAS_CORETYPE": core})
        for core in OLDER_BLAS
    ]
    if len(os.sched_getaffinity(0)) > 1:
        two = {"OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2"}
        found.append(Machine("two cores", environment=two, cores=2))
    return found + [Machine(f"by {one}", python=one) for one in pythons]


def written(specs: Iterable[Spec], folder: Path) -> list[tuple[str, ...]]:
    """Write a case of each kind, and return what `diagnosed` is given for it."""
    given = []
    for number, spec in enumerate(specs):
        path = folder / f"{number}-{spec.group}.csv"
        write_recordings(spec.make(number), path)
        if spec.group == AGAIN:
            _read_again(path)
        given.append((str(path),))
    return given


def _read_again(path: Path) -> None:
    """Write every third row of a file of recordings once more, its offsets a little further off."""
    lines = path.read_text().splitlines()
    first = next(number for number, line in enumerate(lines) if not line.startswith("#"))
    names = lines[first].split(",")
    twice = lines[: first + 1]
    for number, line in enumerate(lines[first + 1 :]):
        twice.append(line)
        if number % 3 == 0:
            cells = dict(zip(names, line.split(","), strict=True))
            for name in ("d_az_deg", "d_el_deg"):
                cells[name] = cells[name] and f"{float(cells[name]) + 2e-4:.7f}"
            twice.append(",".join(cells.values()))
    path.write_text("\n".join(twice) + "\n")


def diagnosed(machine: Machine, given: list[tuple[str, ...]], out: Path) -> dict[str, Any]:
    """Return what a machine reports of each input."""
    one_core = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    for words in given:
        done = subprocess.run(
            [machine.python, "-m", "pyport", "diagnose", *words, "--out", str(out), "--quiet"],
            env={**os.environ, **one_core, **machine.environment},
            cwd=machine.program,
            preexec_fn=lambda: _to_cores(machine.cores),
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise SystemExit(f"{machine.name}: {words[0]}: {done.stderr.strip()}")
    found = {path.parent.name: json.loads(path.read_text()) for path in out.glob("*/report.json")}
    return dict(sorted(found.items()))


def _to_cores(count: int) -> None:
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:count])


def leaves(value: object, place: str = "") -> Iterator[tuple[str, object]]:
    """Yield every word and number of a report with its place in it."""
    if isinstance(value, dict):
        for key in sorted(value):
            yield from leaves(value[key], f"{place}.{key}")
    elif isinstance(value, list):
        yield f"{place}.length", str(len(value))
        for number, one in enumerate(value):
            yield from leaves(one, f"{place}[{number}]")
    else:
        yield place, value


def sigmas(report: dict[str, Any], other: dict[str, Any]) -> list[float]:
    """Return how far the parameters of the findings are apart, in sigmas."""
    both = zip(report["findings"], other["findings"], strict=True)
    return [
        abs(a["value"] - b["value"]) / a["sigma"]
        for one, two in both
        for a, b in zip(one["parameters"], two["parameters"], strict=True)
        if a["sigma"]
    ]


def compare(name: str, ours: dict[str, Any], theirs: dict[str, Any]) -> tuple[bool, str]:
    """Tell whether two machines' reports keep the promise, and how they differ."""
    wrong, apart, numbers, most = [], 0.0, 0, (0.0, "nowhere")
    for case, report in ours.items():
        one, two = (dict(leaves(_told(each))) for each in (report, theirs[case]))
        for place in sorted({*one, *two}):
            a, b = one.get(place), two.get(place)
            if _is_number(a) and _is_number(b):
                numbers += a != b
                far = abs(a - b) / max(abs(a), abs(b), 1e-300)
                most = max(most, (far, case + place))
            elif a != b:
                wrong.append(f"{case}{place}: {a!s:.60} here, {b!s:.60} there")
        if not wrong:
            apart = max([apart, *sigmas(report, theirs[case])])
    if apart > PROMISED_SIGMAS:
        wrong.append(f"a parameter is {apart:.1g} sigma off")
    row = f"{name:<34}{len(ours):>7}{len(wrong):>7}{apart:>11.1e}{numbers:>9}  {most[0]:.1e}"
    where = f" at {most[1]}" if numbers else ""
    return not wrong, "\n".join([row + where, *(f"    {one}" for one in wrong[:5])])


def _told(report: dict[str, Any]) -> dict[str, Any]:
    """Return what a report says, without the machine, and the hashes of every last digit."""
    return {key: value for key, value in report.items() if key not in MACHINE}


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def main() -> int:
    """Compare; return 1 where the promise is broken."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", action="append", default=[], help="another, with pyport in it")
    told = parser.parse_args()
    heads = f"{'against this machine, one core':<34}{'inputs':>7}{'words':>7}{'sigmas':>11}"
    print(f"{heads}{'numbers':>9}  farthest apart, relative", flush=True)
    kept = True
    with tempfile.TemporaryDirectory(prefix="machines-") as name:
        folder = Path(name)
        given = [(SHIPPED[0], "--model", SHIPPED[1]), *written(INPUTS, folder)]
        first, *others = machines(told.python)
        ours = diagnosed(first, given, folder / "out-0")
        for number, machine in enumerate(others, start=1):
            theirs = diagnosed(machine, given, folder / f"out-{number}")
            good, text = compare(machine.name, ours, theirs)
            kept &= good
            print(text, flush=True)
    print("the same findings, verdicts and words" if kept else "reports depend on the machine")
    return int(not kept)


if __name__ == "__main__":
    sys.exit(main())
