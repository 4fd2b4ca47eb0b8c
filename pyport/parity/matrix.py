"""Compare builds of the same Fortran with the reference: flags, precision, another compiler."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from pyport.parity import build as building
from pyport.parity import inputs, promise, stored
from pyport.parity.batches import part, size
from pyport.parity.compare import Comparison, Pair
from pyport.parity.description import Batch, Build, Description, Port, Routine
from pyport.parity.oracle import Oracle
from pyport.parity.oracle import of as oracle_of
from pyport.parity.report import ulp
from pyport.progress import track

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


def show(content: dict[str, Any]) -> str:
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
