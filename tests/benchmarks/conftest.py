"""Benchmarks are collected when they are asked for: `make bench`, or `--benchmark-enable`."""

from __future__ import annotations

import compileall
import ctypes
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
import rt32

import pyport
from pyport.parity.compiled.build import sources
from pyport.pointing import kernel

FORTRAN = Path(__file__).parent / "fortran"
FLAGS = ("-O3", "-march=native", "-std=legacy", "-fPIC")


def pytest_ignore_collect(config):
    """Leave the default suite alone."""
    return None if config.getoption("benchmark_enable") else True


@pytest.fixture(scope="session", autouse=True)
def bytecode():
    """Compile this program to bytecode, as an installer does and Python may be told not to."""
    compileall.compile_dir(Path(pyport.__file__).parent, quiet=2)


@pytest.fixture(scope="session")
def compiled(tmp_path_factory):
    """Return what compiles a program or library of ours beside the published routines."""
    if shutil.which("gfortran") is None:
        pytest.skip("no gfortran: .ci/install gfortran")

    def made(name, *, promoted=False, library=False):
        folder = tmp_path_factory.mktemp(name)
        build = rt32.DESCRIPTION.builds["promoted" if promoted else "reference"]
        routines = sources(rt32.DESCRIPTION, build)
        for file, text in routines.items():
            (folder / file).write_text(text, encoding="ascii")
        shutil.copy(FORTRAN / f"{name}.f90", folder)
        more = [*(["-shared"] if library else []), *(["-freal-4-real-8"] if promoted else [])]
        command = ["gfortran", *FLAGS, *more, *routines, f"{name}.f90", "-o", "built"]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        return folder / "built"

    return made


@pytest.fixture(scope="session")
def routines(compiled):
    """Return the published routines in loops, by the type of their numbers: REAL*4 and REAL*8."""

    def caller(library):
        def call(name, *arguments):
            given = [
                ctypes.byref(ctypes.c_int(one))
                if isinstance(one, int)
                else one.ctypes.data_as(ctypes.c_void_p)
                for one in arguments
            ]
            getattr(library, f"{name}_")(*given)

        return call

    return {
        real: caller(ctypes.CDLL(str(compiled("loops", promoted=promoted, library=True))))
        for real, promoted in ((np.float32, False), (np.float64, True))
    }


@pytest.fixture
def beside(benchmark, request):
    """Return what measures a call and its peers in turn, so that a busy minute hits all of them.

    Calls that are over at once are measured so many at a time. A peer that returns a float has
    taken its own time [s]. The limit is measured with them, and the same call by numpy alone
    where `both` paths can do it.
    """

    def measure(call, peers, *, rounds=5, at_a_time=1, limit=None, both=False):
        taken, more = {}, {"peers": {}, "at_a_time": at_a_time}
        beside_it = dict(peers)
        if limit is not None:
            beside_it["limit"] = limit.take
            more["limit"] = limit.counted
        if both and kernel.KERNEL is not None:
            beside_it["numpy"] = without_kernel(call)

        def seconds(one):
            begin = time.perf_counter()
            for _ in range(at_a_time):
                own = one()
            return own if isinstance(own, float) else (time.perf_counter() - begin) / at_a_time

        def every_peer():
            for who, peer in beside_it.items():
                taken.setdefault(who, []).append(seconds(peer))
            least = {who: min(times) for who, times in taken.items()}
            more["peers"] = {who: least[who] for who in peers}
            more.update({f"{who}_s": least[who] for who in ("limit", "numpy") if who in least})
            benchmark.extra_info.update(more)

        def ours():
            for _ in range(at_a_time):
                found = call()
            return found

        benchmark.group = request.module.ROWS[request.function.__name__]
        return benchmark.pedantic(ours, setup=every_peer, rounds=rounds, warmup_rounds=1)

    return measure


def without_kernel(call):
    """Return a call that numpy alone answers, here and in the processes that it starts."""

    def called():
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(kernel, "KERNEL", None)
            patch.setenv("PYPORT_KERNEL", "off")
            return call()

    return called
