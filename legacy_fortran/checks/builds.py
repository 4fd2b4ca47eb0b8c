"""Compile the published routines in any way and ask what they answer, through ctypes.

The oracle that pyport is held to is the f2py distribution; these builds are for looking around it:
other flags, another compiler, mutated sources, coverage counters.
"""

from __future__ import annotations

import ctypes
import runpy
import shutil
import subprocess
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pyport.parity.answers import OUTPUTS
from pyport.parity.points import Points

FORTRAN = Path(__file__).resolve().parents[1]
patched = runpy.run_path(str(FORTRAN / "apply_patches.py"))["patched"]

ROUTINES = ("model.f", "modela.f", "hjump.f")

#: What gfortran needs to take the text; the reference adds these two.
LANGUAGE = ("-std=legacy", "-Wline-truncation", "-Werror=line-truncation")
REFERENCE = ("-O0", "-ffp-contract=off")


@dataclass(frozen=True)
class Build:
    """One way to compile: a compiler, its flags, and whether REAL*4 is promoted to REAL*8."""

    name: str
    flags: tuple[str, ...]
    compiler: str = "gfortran"
    promoted: bool = False

    @property
    def real(self) -> type[np.floating]:
        """The type of the build's REAL*4 arguments."""
        return np.float64 if self.promoted else np.float32


def sources(*, promoted: bool = False) -> dict[str, str]:
    """Return the patched text of each routine; a promoted build needs Hjump's lines only."""
    patches = sorted((FORTRAN / "patches").glob("*.patch"))
    wanted = patches[:1] if promoted else patches
    return {name: patched(FORTRAN / "published" / name, wanted) for name in ROUTINES}


def compile_library(build: Build, text: dict[str, str], folder: Path) -> Path:
    """Compile the routines and the loops over them into a shared library in `folder`.

    Objects are linked apart, without the flags: linking with -ffast-math would switch the whole
    process to flushing subnormals.

    Raises
    ------
    subprocess.CalledProcessError
        When the compiler refuses; its messages are in ``stderr``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, routine in text.items():
        (folder / name).write_text(routine, encoding="ascii")
    shutil.copy(FORTRAN / "each.f90", folder)
    language = LANGUAGE if build.compiler == "gfortran" else ()
    objects = []
    for name in (*text, "each.f90"):
        objects.append(f"{Path(name).stem}.o")
        arguments = [*language, *build.flags, "-fPIC", "-c", name, "-o", objects[-1]]
        _call(build.compiler, arguments, folder)
    coverage = ["--coverage"] if "--coverage" in build.flags else []
    _call(build.compiler, [*coverage, "-shared", *objects, "-o", "routines.so"], folder)
    return folder / "routines.so"


def answers(library: Path, build: Build, at: Points) -> np.ndarray:
    """Return what a library answers, shape (n, 5) of the build's REAL, from a process of its own.

    A build may change how the processor rounds, or crash; neither may touch the caller.
    """
    with ProcessPoolExecutor(1) as pool:
        return pool.submit(_answers, library, build, at).result()


def _answers(library: Path, build: Build, at: Points) -> np.ndarray:
    routines = ctypes.CDLL(str(library))
    n = ctypes.c_int(len(at))
    az, alt, p = (np.ascontiguousarray(a, dtype=build.real) for a in (at.az, at.alt, at.p))
    out = np.empty((len(OUTPUTS), len(at)), dtype=build.real)
    pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in (az, alt, p)]
    results = [row.ctypes.data_as(ctypes.c_void_p) for row in out]
    routines.models_(ctypes.byref(n), *pointers, *results[:2])
    routines.modelas_(ctypes.byref(n), *pointers, *results[2:4])
    routines.hjumps_(ctypes.byref(n), *pointers[:2], results[4])
    return out.T


def _call(compiler: str, arguments: list[str], folder: Path) -> None:
    subprocess.run(  # noqa: S603 - the arguments are ours
        [compiler, *arguments], cwd=folder, check=True, capture_output=True, text=True
    )
