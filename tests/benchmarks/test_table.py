"""Making and reading steering tables, beside Fortran programs that do the same."""

from __future__ import annotations

import re
import subprocess
import sys

import numpy as np
import pytest

from pyport import steering

LOOK_UPS = 1_000_000

ROWS = {
    "test_table": "table",
    "test_table_in_fortran": "table",
    "test_look_ups": "look-ups",
    "test_look_ups_in_fortran": "look-ups",
}


def table():
    """Compute the table and its text."""
    from pyport.steering import ascii as layout

    return layout.text(steering.tabulate())


def looked_up():
    """Look a million places up."""
    return steering.offsets_at(steering.tabulate(reading="float64"), *places())


def test_table(measured, tmp_path):
    """`pyport table` as a whole process, Python's start included."""
    command = [sys.executable, "-m", "pyport", "table", "-o", "table.txt"]
    measured("pyport", lambda: subprocess.run(command, cwd=tmp_path, check=True), rounds=15)


def test_table_in_fortran(measured, compiled, tmp_path):
    """A program that writes as many rows; its refraction is not rounded as the published one's."""
    command = [str(compiled("table")), "table.txt"]
    measured("gfortran -O3", lambda: subprocess.run(command, cwd=tmp_path, check=True), rounds=15)

    theirs = steering.read_ascii(tmp_path / "table.txt")
    ours = steering.tabulate()
    zenith = ours.grid.zd_deg == 0
    off = np.abs(theirs.d_az_deg - ours.d_az_deg)[:, ~zenith]
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


def test_look_ups(measured, binary):
    """Load the binary table and look up a million places."""
    where = places()
    measured("pyport", lambda: look_up(binary, where), rounds=10)


def test_look_ups_in_fortran(benchmark, measured, compiled, binary, tmp_path):
    """A program that reads the ASCII table; it times its own reading and interpolating."""
    where = places()
    steering.write_ascii(steering.read_binary(binary), tmp_path / "table.txt")
    with (tmp_path / "places").open("wb") as file:
        file.write(np.int32(LOOK_UPS).tobytes() + np.stack(where, axis=1).tobytes())
    command = [str(compiled("lookup")), "table.txt", "places", "answers"]
    taken = []

    def run():
        done = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True)
        taken.append(float(re.search(r"[\d.E+-]+", done.stdout)[0]))

    measured("gfortran -O3", run, rounds=6)
    benchmark.extra_info["seconds"] = min(taken)

    answers = np.fromfile(tmp_path / "answers").reshape(-1, 2)
    np.testing.assert_allclose(answers.T, look_up(binary, where), atol=1e-12)
