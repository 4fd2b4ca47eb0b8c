"""Rewrite the oracle's stored answers: ``python -m pyport.parity.golden``.

A file whose numbers stay the same is left alone, its provenance too: the header says which build
first gave the numbers, and any build that gives them again is the same program.
"""

from __future__ import annotations

import json
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from pyport.files import write_whole
from pyport.parity import points, stored
from pyport.parity.answers import OUTPUTS, find_oracle, of_oracle
from pyport.parity.compare import hexadecimal
from pyport.parity.edges import edges
from pyport.parity.points import Points
from pyport.parity.spread import spread


def points_of(name: str, folder: Path) -> Points:
    """Return the points of a stored set; the random ones, once drawn, are those in the file."""
    if name == "table":
        return points.table(every_az=15, every_zd=6)
    if name == "edges":
        return edges()
    if (folder / f"{name}.json").exists():
        return stored.load(name, folder).at
    return points.random(2000, seed=2004)


def write(oracle: ModuleType, name: str, folder: Path = stored.FOLDER) -> bool:
    """Write one set's answers; leave a file alone that already holds the same. Tell if written."""
    at = points_of(name, folder)
    answers = of_oracle(oracle, at)
    low, high = spread(oracle, at, answers)
    rows = zip(at.which, np.column_stack([at.az, at.alt, answers, low, high]), strict=True)
    columns = [
        " ".join([*output, *what]) for what in ((), ("least",), ("greatest",)) for output in OUTPUTS
    ]
    content = {
        "schema": stored.SCHEMA,
        "provenance": stored.describe(oracle),
        "units": "az, alt in rad, azimuth from south through west; parameters and answers in deg",
        "columns": ["which parameters", "az", "alt", *columns],
        "digests": stored.digests(of_oracle(oracle, points.table())) if name == "table" else [],
        "parameters": [[hexadecimal(value) for value in row] for row in at.parameters],
        "rows": [[int(which), *map(hexadecimal, row)] for which, row in rows],
    }
    path = folder / f"{name}.json"
    if path.exists():
        old = json.loads(path.read_text(encoding="utf-8"))
        if {**old, "provenance": None} == {**content, "provenance": None}:
            return False
    with write_whole(path) as file:
        file.write(one_row_a_line(content))
    return True


def one_row_a_line(content: dict[str, Any]) -> str:
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
    for name in stored.SETS:
        changed = write(oracle, name)
        print(f"{name}.json: {'rewritten' if changed else 'unchanged'}")  # noqa: T201


if __name__ == "__main__":
    main()
