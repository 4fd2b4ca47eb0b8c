"""The oracle's answers on paper: hexadecimal floats in JSON, with where they came from.

They hold the ports where no Fortran compiler is. ``python -m pyport.parity.stored`` rewrites them
from the installed oracle and touches no file whose numbers stay the same.
"""

from __future__ import annotations

import hashlib
import json
import math
import platform
import sysconfig
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.legacy import intrinsics
from pyport.parity import points
from pyport.parity.answers import OUTPUTS, find_oracle, of_oracle
from pyport.parity.compare import hexadecimal
from pyport.parity.edges import edges
from pyport.parity.points import TABLE_AZ_DEG, Points, Real4

SCHEMA = "pyport.oracle/1"

#: Stored set -> the points that it holds; the rest of the table is held by a digest an azimuth.
SETS: dict[str, Callable[[], Points]] = {
    "table": lambda: points.table(TABLE_AZ_DEG[::15], points.TABLE_ZD_DEG[::6]),
    "edges": edges,
    "random": lambda: points.random(2000, seed=2004),
}


@dataclass(frozen=True)
class Stored:
    """One stored set: points, the oracle's answers (n, 5), and the file's other entries."""

    at: Points
    answers: Real4
    provenance: dict[str, Any]
    digests: list[str]


def folder() -> Path:
    """Return the folder of the stored answers, in a checkout or where a wheel puts them."""
    checkout = Path(__file__).parents[2] / "golden_tables" / "oracle"
    installed = Path(sysconfig.get_path("data")) / "share" / "pyport" / "oracle"
    return checkout if checkout.is_dir() else installed


def load(name: str) -> Stored:
    """Read one of ``SETS`` from its file."""
    path = folder() / f"{name}.json"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise BadInput(f"no JSON ({error}): expected the oracle's stored answers", path) from None
    if content.get("schema") != SCHEMA:
        raise BadInput(f"expected schema {SCHEMA}, found {content.get('schema')}", path)
    parameters = np.array([_numbers(row) for row in content["parameters"]], dtype=np.float32)
    which = np.array([row[0] for row in content["rows"]])
    values = np.array([_numbers(row[1:]) for row in content["rows"]], dtype=np.float32)
    at = Points(values[:, 0], values[:, 1], parameters, which)
    return Stored(at, values[:, 2:], content["provenance"], content["digests"])


def digests(answers: Real4) -> list[str]:
    """Return one digest an azimuth of the whole table's answers, shape (541 * 95, 5)."""
    rows = answers.astype("<f4").reshape(len(TABLE_AZ_DEG), -1)
    return [hashlib.sha256(row.tobytes()).hexdigest()[:16] for row in rows]


def maths_library() -> str:
    """Return a fingerprint of the C library's functions, as the ports and the Fortran call them.

    Where two machines' fingerprints agree their answers must agree bit for bit; another C library,
    or another processor's variant of it, may round a sine the other way.
    """
    arguments = np.linspace(-7, 7, 4001).astype(np.float32)
    double = [
        [f(float(x)) for x in arguments] for f in (intrinsics.dsin, intrinsics.dcos, math.atan)
    ]
    single = [[f(x) for x in arguments] for f in (intrinsics.sin, intrinsics.cos, intrinsics.tan)]
    arcs = [[intrinsics.dasin(float(x) / 7) for x in arguments]]
    results = np.array([*double, *single, *arcs], dtype="<f8")
    return hashlib.sha256(results.tobytes()).hexdigest()[:16]


def describe(oracle: ModuleType) -> dict[str, Any]:
    """Return where the oracle's answers come from: sources, compiler, flags, C library."""
    return {
        **oracle.provenance(),
        "libc": " ".join(platform.libc_ver()),
        "machine": platform.machine(),
        "maths_library": maths_library(),
    }


def write(oracle: ModuleType, name: str, where: Path) -> bool:
    """Write one set's answers; leave a file alone that already holds the same. Tell if written."""
    at = SETS[name]()
    answers = of_oracle(oracle, at)
    content = {
        "schema": SCHEMA,
        "provenance": describe(oracle),
        "units": "az, alt in rad, azimuth from south through west; parameters and answers in deg",
        "columns": ["which parameters", "az", "alt", *(" ".join(output) for output in OUTPUTS)],
        "digests": digests(of_oracle(oracle, points.table())) if name == "table" else [],
        "parameters": [[hexadecimal(v) for v in row] for row in at.parameters],
        "rows": [
            [int(which), *map(hexadecimal, (az, alt, *row))]
            for which, az, alt, row in zip(at.which, at.az, at.alt, answers, strict=True)
        ],
    }
    path = where / f"{name}.json"
    if path.exists():
        old = json.loads(path.read_text(encoding="utf-8"))
        if {**old, "provenance": None} == {**content, "provenance": None}:
            return False
    with write_whole(path) as file:
        file.write(_one_row_a_line(content))
    return True


def _numbers(texts: list[str]) -> list[float]:
    return [float.fromhex(text) for text in texts]


def _one_row_a_line(content: dict[str, Any]) -> str:
    """Return JSON that a line-by-line comparison reads well."""
    parts = []
    for key, value in content.items():
        if isinstance(value, list) and value:
            rows = ",\n".join("  " + json.dumps(row) for row in value)
            parts.append(f'"{key}": [\n{rows}\n ]')
        else:
            parts.append(f'"{key}": {json.dumps(value, indent=2)}')
    return "{\n " + ",\n ".join(parts) + "\n}\n"


def main() -> None:
    """Rewrite every stored set from the installed oracle."""
    oracle = find_oracle()
    if oracle is None:
        raise SystemExit("the compiled routines are not installed: pip install ./legacy_fortran")
    for name in SETS:
        changed = write(oracle, name, folder())
        print(f"{folder() / name}.json: {'rewritten' if changed else 'unchanged'}")  # noqa: T201


if __name__ == "__main__":
    main()
