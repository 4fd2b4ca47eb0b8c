"""Whole commands: Python's start, the imports, the work, the page and its pictures."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import pytest
from same import checked_out

from pyport.errors import BadInput
from pyport.examiner.sealed.record.files import write_recordings
from pyport.examiner.worlds.kinds import make_case

ROWS = {
    "test_one_cause": "command",
    "test_four_causes": "command-four",
    "test_drawn_case": "command-1200",
    "test_many_rows": "command-50000",
    "test_plot": "plot",
    "test_one_cause_before": "command-before",
    "test_four_causes_before": "command-four-before",
    "test_drawn_case_before": "command-1200-before",
}
ROOT = Path(__file__).parents[2]
#: The last commit before there was a kernel.
BEFORE = "6aa51f1"
ONE = {"effect": "refraction"}


#: What no command with pictures can do without: Python, the libraries, an empty picture.
EMPTY = """
import click, numpy, pyarrow.csv, scipy.linalg, scipy.special
from matplotlib.figure import Figure
figure = Figure(figsize=(10, 6.4), layout="constrained")
for place in (1, 2, 3):
    figure.add_subplot(2, 2, place)
figure.savefig("empty.png", dpi=110)
"""
COUNTED = "Python, its libraries, and an empty picture of that kind"

#: The same work of either program without start and page, each held to one core: threads of one
#: program that wait for each other's memory would count twice.
ALONE = """
import os, pathlib, sys, time
from pyport.diagnosis.diagnose import diagnose
from pyport.formats.models import load
from pyport.recordings import read
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
begin = time.process_time()
diagnose(read(pathlib.Path(sys.argv[1])), load("altaz"))
print(time.process_time() - begin)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return where recordings and results are."""
    return tmp_path_factory.mktemp("commands")


@pytest.fixture(scope="module")
def old(folder):
    """Return the program of that commit, as this repository remembers it."""
    try:
        tree = checked_out(BEFORE, folder / "old")
    except BadInput as error:
        pytest.skip(error.message)
    # Both programs: where Python writes no bytecode the present one would be compiled each time.
    both = str(tree / "pyport"), str(ROOT / "pyport")
    subprocess.run([sys.executable, "-m", "compileall", "-q", *both], check=False)
    return tree


def made(folder, *kind, **more):
    """Write a case and return its file."""
    path = folder / f"{kind[0]}-{more.get('rows', 0)}.csv"
    if not path.exists():
        write_recordings(make_case(*kind, **more), path)
    return path


def command(folder, *words, program=ROOT):
    """Return what runs a command of a program and returns the processor's time that it took [s]."""
    out = "--out", str(folder / "out"), "--quiet"
    return process(folder, "-m", "pyport", *words, *out, program=program)


def process(folder, *words, program=ROOT):
    """Return what runs Python and returns the processor's time that it took [s]."""

    def run():
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        python(folder, *words, program=program)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    return run


def python(folder, *words, program=ROOT, **more):
    """Run Python with a program in its path and return what it printed."""
    environment = {**os.environ, "PYTHONPATH": str(program), **more}
    command_line = [sys.executable, *words]
    return subprocess.run(
        command_line, env=environment, cwd=folder, check=True, stdout=subprocess.PIPE, text=True
    ).stdout


def in_seconds(benchmark, request, folder, *words):
    """Measure a command once, and what it cannot do without."""
    benchmark.group = ROWS[request.function.__name__]
    begin = time.perf_counter()
    process(folder, "-c", EMPTY)()
    taken = time.perf_counter() - begin
    benchmark.extra_info.update(peers={}, limit=COUNTED, limit_s=taken)
    benchmark.pedantic(command(folder, *words), rounds=1)


def beside_the_old(benchmark, request, folder, path, old, rounds, work):
    """Measure the least processor's time of the old program and the present one, in turn."""
    benchmark.group = ROWS[request.function.__name__].replace("command", work)
    before, now = (WORK[work](folder, path, program) for program in (old, ROOT))
    theirs, ours = [], []
    benchmark.pedantic(
        lambda: ours.append(now()), setup=lambda: theirs.append(before()), rounds=rounds
    )
    benchmark.extra_info.update(
        seconds=min(ours),
        peers={f"processor's time of {BEFORE}": min(theirs)},
    )
    if work == "command":
        benchmark.extra_info.update(limit=COUNTED, limit_s=process(folder, "-c", EMPTY)())


def whole(folder, path, program):
    """Return what diagnoses a file by a program's command and returns the time that it took."""
    return command(folder, "diagnose", str(path), program=program)


def alone(folder, path, program):
    """Return what does so without start and page, and returns the time that it took."""
    words = "-c", ALONE, str(path)
    return lambda: float(python(folder, *words, program=program, OPENBLAS_NUM_THREADS="1"))


#: What is measured beside the old program.
WORK = {"command": whole, "diagnosis": alone}


def test_one_cause(benchmark, request, folder):
    """As many rows as the RT32's campaign, one cause."""
    path = made(folder, "one", 21, rows=5600, **ONE)
    in_seconds(benchmark, request, folder, "diagnose", str(path))


def test_four_causes(benchmark, request, folder):
    """Recordings like the RT32's."""
    in_seconds(benchmark, request, folder, "diagnose", str(made(folder, "rt32", 91)))


def test_drawn_case(benchmark, request, folder):
    """As many rows as a trial."""
    path = made(folder, "one", 21, **ONE)
    in_seconds(benchmark, request, folder, "diagnose", str(path))


def test_many_rows(benchmark, request, folder):
    """Fifty thousand rows."""
    path = made(folder, "one", 21, rows=50000, **ONE)
    in_seconds(benchmark, request, folder, "diagnose", str(path))


def test_plot(benchmark, request, folder):
    """Every panel of a night's recordings, as PDF."""
    path = made(folder, "one", 21, rows=54, **ONE)
    in_seconds(benchmark, request, folder, "plot", str(path))


@pytest.mark.parametrize("work", WORK)
def test_one_cause_before(benchmark, request, folder, old, work):
    """As many rows as the RT32's campaign, one cause."""
    path = made(folder, "one", 21, rows=5600, **ONE)
    beside_the_old(benchmark, request, folder, path, old, 2, work)


@pytest.mark.parametrize("work", WORK)
def test_four_causes_before(benchmark, request, folder, old, work):
    """Recordings like the RT32's."""
    beside_the_old(benchmark, request, folder, made(folder, "rt32", 91), old, 1, work)


@pytest.mark.parametrize("work", WORK)
def test_drawn_case_before(benchmark, request, folder, old, work):
    """As many rows as a trial."""
    beside_the_old(benchmark, request, folder, made(folder, "one", 21, **ONE), old, 5, work)
