"""A full diagnosis: the whole catalogue, the draws of noise, held-out data, the report."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

from pyport.diagnosis.diagnose import diagnose
from pyport.examiner.sealed.record.files import write_recordings
from pyport.examiner.worlds.kinds import make_case
from pyport.formats.models import load
from pyport.recordings import read
from pyport.report.folder import write
from pyport.runs.stages import stage, timed

ROWS = {
    "test_one_cause": "diagnosis",
    "test_rt32": "diagnosis-four",
    "test_drawn_case": "diagnosis-1200",
}


@pytest.fixture(scope="module")
def folder():
    """Return where reports go."""
    with tempfile.TemporaryDirectory() as name:
        yield Path(name)


@stage("writing the report")
def run(path):
    """Diagnose a file from reading it to its report, pages and pictures apart."""
    found = diagnose(stage("reading")(read)(path), load("altaz"))
    write(found, path.parent / "out")


def made(folder, name, *kind, **more):
    """Write a case and return its file."""
    path = folder / f"{name}.csv"
    write_recordings(make_case(*kind, **more), path)
    return path


def one_cause():
    """Diagnose as many rows as the RT32's campaign has, one cause hidden in them."""
    with tempfile.TemporaryDirectory() as name:
        run(made(Path(name), "large", "one", 21, effect="refraction", rows=5600))


def rt32():
    """Diagnose recordings like the RT32's."""
    with tempfile.TemporaryDirectory() as name:
        run(made(Path(name), "rt32", "rt32", 91))


def drawn_case():
    """Diagnose a case like those of the trials."""
    with tempfile.TemporaryDirectory() as name:
        run(made(Path(name), "one", "one", 21, effect="refraction"))


def test_one_cause(benchmark, beside, folder):
    """As many rows as the RT32's campaign, one cause."""
    path = made(folder, "large", "one", 21, effect="refraction", rows=5600)
    beside(lambda: run(path), {}, rounds=3)
    benchmark.extra_info["stages"] = stages(path)


def test_rt32(benchmark, beside, folder):
    """As many rows as the RT32's campaign: four causes are hidden in them."""
    path = made(folder, "rt32", "rt32", 91)
    beside(lambda: run(path), {}, rounds=3)
    benchmark.extra_info["stages"] = stages(path)


def test_drawn_case(benchmark, beside, folder):
    """As many rows as a trial, one cause."""
    path = made(folder, "one", "one", 21, effect="refraction")
    beside(lambda: run(path), {}, rounds=3)
    benchmark.extra_info["stages"] = stages(path)


def stages(path):
    """Return how long each stage takes [s]."""
    with timed() as clock:
        run(path)
    return clock.seconds
