"""Break the port, and the Fortran, in every small way, and see whether the comparison notices.

    python legacy_fortran/checks/mutants.py

A mutant of the port is killed when its answers leave the oracle's stored answers (what the default
tests look at) or, failing that, the compiled oracle's at the whole table and 100,000 random points.
A mutant of the Fortran is compiled as an oracle of its own; the unchanged port must leave it.
Survivors must be explained in ``survivors.toml``; the exit status is 1 when one is not.
"""

from __future__ import annotations

import math
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from builds import REFERENCE, Build, answers, compile_library, sources
from mutations import Mutant, mutants

from pyport import legacy
from pyport.files import write_whole
from pyport.legacy import intrinsics
from pyport.parity import golden, points, stored
from pyport.parity.answers import OUTPUTS, find_oracle, of_legacy, of_oracle
from pyport.parity.points import Points, Real4
from pyport.parity.ulp import ulps
from pyport.progress import track

MODULES = ("model", "modela", "hjump")
HERE = Path(__file__).parent

#: File, what stands there, what a slip makes of it.
FORTRAN_MUTANTS = [
    ("model.f", "xi=p(5)", "xi=p(6)"),
    ("model.f", "pi/3.141592653589793d0/", "pi/3.141592653589793/"),
    ("model.f", "dmax1(-1.d0,arg)", "dmax1(-2.d0,arg)"),
    ("model.f", "sh*se-ch*ce", "sh*se+ch*ce"),
    ("model.f", "if(ch.lt.0d0) then", "if(ch.gt.2d0) then"),
    ("model.f", "dmod((dAz+AT_Az)*180/pi,360d0)", "(dAz+AT_Az)*180/pi"),
    ("model.f", "*+p(7)*ch", "*+p(7)*sh"),
    ("model.f", "*+cos(hT)*sin(sigma)", "*-cos(hT)*sin(sigma)"),
    ("modela.f", "pi/3.141593/", "pi/3.141592/"),
    ("modela.f", "*-p(6)*cos(Az)*t", "*+p(6)*cos(Az)*t"),
    ("modela.f", "dAz=amod(dAz,360.)", "dAz=dAz"),
    ("modela.f", "if(Alt.gt.pi/2)", "if(Alt.ge.pi/2)"),
    ("hjump.f", "((A-95)/90)**2*15", "((A-95)/90)**2*16"),
    ("hjump.f", "if(A.le.0.)", "if(A.lt.0.)"),
    ("hjump.f", "Hj.le.H", "Hj.lt.H"),
]


def load(changed: str, source: str) -> Callable[[Points], Real4]:
    """Return the port with one module's source replaced, as a function like ``of_legacy``."""
    spaces = {}
    for module in MODULES[::-1]:  # hjump first: the others call it
        text = source if module == changed else unchanged(module)
        space = {"real4": np.float32, "dtan": math.tan, **vars(intrinsics)}
        exec(compile(text, module, "exec"), space)  # noqa: S102 - our own source
        spaces[module] = space
        space["hjump"] = spaces["hjump"]["hjump"]
    model, modela, hjump = (spaces[module][module] for module in MODULES)

    def port(at: Points) -> Real4:
        result = np.empty((len(at), len(OUTPUTS)), dtype=np.float32)
        for row, az, alt, p in zip(result, at.az, at.alt, at.p, strict=True):
            row[0:2], row[2:4], row[4] = model(az, alt, p), modela(az, alt, p), hjump(az, alt)
        return result

    return port


def unchanged(module: str) -> str:
    """Return the source of one of the port's modules."""
    return (Path(legacy.__file__).parent / f"{module}.py").read_text(encoding="utf-8")


def notices(port: Callable[[Points], Real4], at: Points, expected: Real4) -> bool:
    """Tell whether the port's answers differ from the expected ones, looking at a few first."""
    for part in (slice(0, 200), slice(200, None)):
        try:
            with np.errstate(all="ignore"):
                actual = port(at.part(part))
        except (ArithmeticError, LookupError, ValueError, TypeError):
            return True
        if ulps(expected[part], actual).any():
            return True
    return False


def references() -> Iterator[tuple[str, Points, Real4]]:
    """Yield what a mutant has to survive, the quick sets first."""
    for name in ("edges", "random", "table"):
        kept = stored.load(name)
        yield f"stored {name}", kept.at, kept.answers
    oracle = find_oracle()
    if oracle is not None:
        at = points.joined([points.random(100_000, seed=80), points.table()])
        yield "oracle", at, of_oracle(oracle, at)


def port_survivors(all_mutants: list[tuple[str, Mutant]]) -> tuple[list[str], dict[str, int]]:
    """Run the mutants of the port; return the survivors and how many each reference killed."""
    left = all_mutants
    killed = {}
    for name, at, expected in references():
        survivors = [
            (module, mutant)
            for module, mutant in track(left, f"Mutants against {name}")
            if not notices(load(module, mutant.source), at, expected)
        ]
        killed[name] = len(left) - len(survivors)
        left = survivors
    return [mutant.name for _, mutant in left], killed


def fortran_survivors() -> list[str]:
    """Compile each mutant of the Fortran; return those that the port's answers agree with."""
    at = points.joined([stored.load(name).at for name in stored.SETS])
    port = of_legacy(at)
    build = Build("mutant", REFERENCE)
    survivors = []
    for file, was, became in track(FORTRAN_MUTANTS, "Mutants of the Fortran"):
        text = sources()
        if text[file].count(was) != 1:
            sys.exit(f"{file}: {was!r} does not stand there exactly once")
        text[file] = text[file].replace(was, became)
        with tempfile.TemporaryDirectory() as folder:
            try:
                library = compile_library(build, text, Path(folder))
            except subprocess.CalledProcessError as error:
                sys.exit(f"{file}: {became!r} does not compile: {error.stderr}")
            if not ulps(answers(library, build, at), port).any():
                survivors.append(f"{file}: {was} -> {became}")
    return survivors


def main() -> None:
    """Make and run all mutants, print what became of them."""
    explained = tomllib.loads((HERE / "survivors.toml").read_text(encoding="utf-8"))["survivor"]
    reasons = {one["mutant"]: one["reason"] for one in explained}
    made = [(module, m) for module in MODULES for m in mutants(module, unchanged(module))]
    survivors, killed = port_survivors(made)
    print(f"{len(made)} mutants of the port:")  # noqa: T201
    for name, number in killed.items():
        print(f"  {number:4} killed by {name}")  # noqa: T201
    print(f"  {len(survivors):4} survived")  # noqa: T201
    for name in survivors:
        print(f"  {name}\n    {reasons.get(name, 'NOT EXPLAINED')}")  # noqa: T201
    fortran = fortran_survivors()
    print(f"{len(FORTRAN_MUTANTS)} mutants of the Fortran: {len(fortran)} survived")  # noqa: T201
    print("".join(f"  {name}\n" for name in fortran), end="")  # noqa: T201
    with write_whole(stored.FOLDER / "mutants.json") as file:
        file.write(
            golden.one_row_a_line(
                {
                    "schema": "pyport.parity-mutants/1",
                    "port": len(made),
                    "killed": killed,
                    "survivors": [{"mutant": n, "reason": reasons.get(n)} for n in survivors],
                    "fortran": [
                        f"{file}: {was} -> {became}" for file, was, became in FORTRAN_MUTANTS
                    ],
                    "fortran_survivors": fortran,
                }
            )
        )
    outdated = set(reasons) - set(survivors)
    for name in outdated:
        print(f"explained as a survivor, yet killed or gone: {name}")  # noqa: T201
    sys.exit(bool(fortran or outdated or set(survivors) - set(reasons)))


if __name__ == "__main__":
    main()
