"""The oracle's answers on paper: hexadecimal floats in JSON, with where they came from.

They hold the ports where no Fortran compiler is; :mod:`pyport.parity.golden` writes them.
"""

from __future__ import annotations

import hashlib
import json
import math
import platform
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from pyport.errors import BadInput
from pyport.legacy import intrinsics
from pyport.parity.points import Points, Real4
from pyport.steering.grid import RT32_GRID

SCHEMA = "pyport.oracle/1"

#: The stored answers; `golden_tables/oracle` in the source tree.
FOLDER = Path(__file__).parent / "oracle"

#: The stored sets; the first has a digest for each azimuth of the whole table as well.
SETS = ("table", "edges", "random")


@dataclass(frozen=True)
class Stored:
    """One stored set of n points.

    Attributes
    ----------
    at
        The points.
    answers
        What the oracle answered, shape (n, 5).
    spread
        The least and greatest of its own answers there, shape (2, n, 5); see
        :mod:`pyport.parity.spread`.
    provenance
        Sources, compiler, flags, C library.
    digests
        One for each azimuth of the whole table, else empty.
    """

    at: Points
    answers: Real4
    spread: Real4
    provenance: dict[str, Any]
    digests: list[str]


def load(name: str, folder: Path = FOLDER) -> Stored:
    """Read one of ``SETS`` from its file."""
    path = folder / f"{name}.json"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise BadInput(f"no JSON ({error}): expected the oracle's stored answers", path) from None
    if content.get("schema") != SCHEMA:
        raise BadInput(f"expected schema {SCHEMA}, found {content.get('schema')}", path)
    which = np.array([row[0] for row in content["rows"]])
    columns = numbers([row[1:] for row in content["rows"]])
    az, alt = columns[:, :2].T
    answers, low, high = np.split(columns[:, 2:], 3, axis=1)
    at = Points(az, alt, numbers(content["parameters"]), which)
    return Stored(at, answers, np.stack([low, high]), content["provenance"], content["digests"])


def numbers(rows: list[list[str]]) -> Real4:
    """Return rows of hexadecimal literals as REAL*4."""
    return np.array([[float.fromhex(text) for text in row] for row in rows], dtype=np.float32)


def digests(answers: Real4) -> list[str]:
    """Return one digest an azimuth of the whole table's answers, shape (541 * 95, 5)."""
    rows = answers.astype("<f4").reshape(len(RT32_GRID.az_deg), -1)
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
