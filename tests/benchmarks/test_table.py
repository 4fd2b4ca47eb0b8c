"""Making and reading steering tables, beside Fortran programs that do the same."""

from __future__ import annotations

import re
import subprocess
import sys

import numpy as np
import pytest
from benchmarks import limits

from pyport import steering

LOOK_UPS = 1_000_000

ROWS = {"test_table": "table", "test_look_ups": "look-ups"}


def table():
    """Compute the table and its text."""
    from pyport.steering import ascii as layout

    return layout.text(steering.tabulate())


def looked_up():
    """Look a million places up."""
    return steering.offsets_at(steering.tabulate(reading="float64"), *places())


def test_table(beside, compiled, tmp_path):
    """`pyport table` as a whole process, Python's start included; a Fortran program for it.

    That one writes as many rows; its refraction is not rounded as the published one's.
    """
    ours = [sys.executable, "-m", "pyport", "table", "-o", "table.txt"]
    theirs = [str(compiled("table")), "theirs.txt"]
    beside(
        lambda: subprocess.run(ours, cwd=tmp_path, check=True),
        {"gfortran -O3": lambda: subprocess.run(theirs, cwd=tmp_path, check=True)},
        rounds=15,
        limit=limits.of_process("pass", "Python's start"),
        both=True,
    )

    one, other = (steering.read_ascii(tmp_path / name) for name in ("table.txt", "theirs.txt"))
    off = np.abs(one.d_az_deg - other.d_az_deg)[:, one.grid.zd_deg != 0]
    assert np.median(off) < 1e-4


@pytest.fixture(scope="module")
def binary(tmp_path_factory):
    """Return the published model's table as a binary file."""
    path = tmp_path_factory.mktemp("table") / "table.bin"
    steering.write_binary(steering.tabulate(), path)
    return path


def places():
    """Return where to look up."""
    rng = np.random.default_rng(2)
    return rng.uniform(-270, 270, LOOK_UPS), rng.uniform(-5, 89, LOOK_UPS)


def look_up(path, where):
    """Load a table and interpolate in it."""
    return steering.offsets_at(steering.read_binary(path), *where)


def test_look_ups(beside, compiled, binary, tmp_path):
    """Load the binary table and look up a million places.

    Beside it a program that reads the ASCII table; it takes the time of its own reading and
    interpolating, not that of the places and answers, which are files for it.
    """
    where = places()
    steering.write_ascii(steering.read_binary(binary), tmp_path / "table.txt")
    with (tmp_path / "places").open("wb") as file:
        file.write(np.int32(LOOK_UPS).tobytes() + np.stack(where, axis=1).tobytes())
    command = [str(compiled("lookup")), "table.txt", "places", "answers"]

    def program():
        done = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True)
        return float(re.search(r"[\d.E+-]+", done.stdout)[0])

    limit = limits.of_points(LOOK_UPS, angles=True, functions=())
    ours = beside(
        lambda: look_up(binary, where),
        {"gfortran -O3": program},
        rounds=12,
        limit=limit,
        both=True,
    )

    answers = np.fromfile(tmp_path / "answers").reshape(-1, 2)
    np.testing.assert_allclose(answers.T, ours, atol=1e-12)
