"""Benchmarks are collected when they are asked for: `make bench`, or `--benchmark-enable`."""

import ctypes
import runpy
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

LEGACY = Path(__file__).parents[2] / "legacy_fortran"
FORTRAN = Path(__file__).parent / "fortran"
FLAGS = ("-O3", "-march=native", "-std=legacy", "-fPIC")


def pytest_ignore_collect(config):
    """Leave the default suite alone."""
    return None if config.getoption("benchmark_enable") else True


@pytest.fixture(scope="session")
def compiled(tmp_path_factory):
    """Return what compiles a program or library of ours beside the published routines."""
    if shutil.which("gfortran") is None:
        pytest.skip("no gfortran: .ci/install gfortran")
    sources = runpy.run_path(str(LEGACY / "checks" / "builds.py"))["sources"]

    def build(name, *, promoted=False, library=False):
        folder = tmp_path_factory.mktemp(name)
        routines = sources(promoted=promoted)
        for file, text in routines.items():
            (folder / file).write_text(text, encoding="ascii")
        shutil.copy(FORTRAN / f"{name}.f90", folder)
        more = [*(["-shared"] if library else []), *(["-freal-4-real-8"] if promoted else [])]
        command = ["gfortran", *FLAGS, *more, *routines, f"{name}.f90", "-o", "built"]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        return folder / "built"

    return build


@pytest.fixture(scope="session", params=[False, True], ids=["real4", "real8"])
def routines(compiled, request):
    """Return the published routines in loops, and the type of their numbers."""
    library = ctypes.CDLL(str(compiled("loops", promoted=request.param, library=True)))
    real = np.float64 if request.param else np.float32

    def call(name, *arguments):
        given = [
            ctypes.byref(ctypes.c_int(one))
            if isinstance(one, int)
            else one.ctypes.data_as(ctypes.c_void_p)
            for one in arguments
        ]
        getattr(library, f"{name}_")(*given)

    return call, real


@pytest.fixture
def measured(benchmark, request):
    """Return what measures a call: who it is, how often, and what it works on."""

    def measure(who, call, *, rounds=5, group=None, **more):
        benchmark.group = group or request.module.ROWS[request.function.__name__]
        benchmark.extra_info.update(who=who, **more)
        return benchmark.pedantic(call, rounds=rounds, warmup_rounds=1)

    return measure
