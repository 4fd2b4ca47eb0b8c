"""Compare builds of the published routines with the reference: flags, precision, another compiler.

    python legacy_fortran/checks/matrix.py          prints the table and rewrites matrix.json

Every build is asked at the whole table, the edges and 100,000 random points. Distances on the sky
leave out what the ledger of deviations explains, where a last bit decides between two answers.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from builds import REFERENCE, Build, answers, compile_library, sources

from pyport.files import write_whole
from pyport.parity import golden, points, promise, stored
from pyport.parity.answers import OUTPUTS, find_oracle, of_oracle
from pyport.parity.compare import compare
from pyport.parity.edges import edges
from pyport.parity.ledger import explained
from pyport.parity.report import ulp
from pyport.parity.ulp import ulps
from pyport.progress import track

RANDOM_POINTS = 100_000

GFORTRAN = [
    REFERENCE,
    ("-O0",),
    ("-O2",),
    ("-O3",),
    ("-O3", "-march=native"),
    ("-O3", "-march=native", "-ffp-contract=off"),
    ("-O0", "-mfpmath=387"),
    ("-O2", "-mfpmath=387"),
    ("-O3", "-ffast-math"),
    ("-O3", "-march=native", "-ffast-math"),
]
PROMOTED = (*REFERENCE, "-freal-4-real-8")


def builds() -> list[Build]:
    """Return the builds to compare; flang, the advisory ones, only where it is installed."""
    result = [Build(f"gfortran {' '.join(flags)}", flags) for flags in GFORTRAN]
    result.append(Build(f"gfortran {' '.join(PROMOTED)}", PROMOTED, promoted=True))
    flang = second_compiler()
    if flang:
        result += [Build(f"flang {level} (advisory)", (level,), flang) for level in ("-O0", "-O2")]
    return result


def second_compiler() -> str | None:
    """Return flang's command, which carries a version on some systems."""
    names = [path.name for path in Path("/usr/bin").glob("flang*")]
    return next(filter(shutil.which, ["flang", *sorted(names, reverse=True)]), None)


def version(compiler: str) -> str:
    """Return the first line of what a compiler says of itself."""
    asked = subprocess.run([compiler, "--version"], check=True, capture_output=True, text=True)  # noqa: S603
    return asked.stdout.splitlines()[0]


def row(build: Build, at: points.Points, expected: points.Real4) -> dict:
    """Build, ask, and compare: one row of the matrix."""
    with tempfile.TemporaryDirectory() as folder:
        library = compile_library(build, sources(promoted=build.promoted), Path(folder))
        with np.errstate(over="ignore"):
            actual = answers(library, build, at).astype(np.float32)
    apart = ulps(expected, actual)
    decided = np.any(list(explained(at, expected).values()), axis=0)
    on_the_sky = compare(expected, actual, at, np.where(decided, 0, apart))
    return {
        "build": build.name,
        "compiler": version(build.compiler),
        "outputs": [
            {
                "differing": comparison.differing,
                "p99_ulp": comparison.quantile(0.99),
                "max_sky_arcsec": float(f"{sky.arcsec:.2g}"),
            }
            for comparison, sky in zip(
                compare(expected, actual, at, apart), on_the_sky, strict=True
            )
        ],
    }


def show(matrix: dict) -> str:
    """Return the matrix as text: answers that differ / p99 ulp / worst on the sky."""
    names = [" ".join(output) for output in OUTPUTS]
    lines = [
        f"{'differing / p99 ulp / worst arcsec on the sky':52}"
        + "".join(f"{name:>26}" for name in names)
    ]
    for one in matrix["rows"]:
        cells = [
            f"{o['differing']:,} / {ulp(o['p99_ulp'])} / {o['max_sky_arcsec']:g}"
            for o in one["outputs"]
        ]
        lines.append(f"{one['build']:52}" + "".join(f"{cell:>26}" for cell in cells))
    return "\n".join(lines)


def main() -> None:
    """Build and compare them all, print the table and store it."""
    oracle = find_oracle()
    if oracle is None:
        sys.exit("the compiled routines are not installed: pip install ./legacy_fortran")
    at = points.joined([points.table(), edges(), points.random(RANDOM_POINTS, seed=10)])
    at = at.part(promise.promised(at))
    expected = of_oracle(oracle, at)
    rows = [row(build, at, expected) for build in track(builds(), "Building")]
    matrix = {
        "schema": "pyport.parity-matrix/1",
        "points": len(at),
        "provenance": stored.describe(oracle),
        "rows": rows,
    }
    print(show(matrix))  # noqa: T201
    with write_whole(stored.FOLDER / "matrix.json") as file:
        file.write(golden.one_row_a_line(matrix))


if __name__ == "__main__":
    main()
