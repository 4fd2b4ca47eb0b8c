"""The binary table: lossless, checked to the last byte, read by Fortran alike."""

from __future__ import annotations

import shutil
import subprocess
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pyport.errors import BadInput
from pyport.steering import (
    Grid,
    Table,
    map_binary,
    offsets_at,
    read_binary,
    read_table,
    tabulate,
    write_ascii,
    write_binary,
)
from pyport.steering.ascii import rows
from pyport.steering.binary import HEADER

FORTRAN = Path(__file__).parents[2] / "legacy_fortran" / "table"


@pytest.fixture(scope="module")
def table():
    """Return the 3model table on its whole grid."""
    return tabulate()


@pytest.fixture
def written(table, tmp_path, monkeypatch):
    """Return the path of the table's binary file."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1088640000")
    path = tmp_path / "table.bin"
    write_binary(table, path)
    return path


@pytest.fixture(scope="session")
def table_tool(tmp_path_factory):
    """Return the compiled Fortran reader."""
    compiler = shutil.which("gfortran")
    if compiler is None:
        pytest.skip("no gfortran here")
    folder = tmp_path_factory.mktemp("fortran")
    sources = [
        FORTRAN / f"{name}.f90" for name in ("steering_table", "steering_offsets", "table_tool")
    ]
    options = ["-std=f2018", "-Wall", "-Wextra", "-Werror", "-fcheck=all", f"-J{folder}"]
    program = folder / "table_tool"
    subprocess.run([compiler, *options, "-o", program, *sources], check=True)
    return program


def test_file_holds_the_digits_of_the_ascii_table(table, written):
    """Read back, the table prints the same rows, and names its origin."""
    again = read_binary(written)

    assert list(rows(again)) == list(rows(table))
    assert (again.model, again.refraction) == ("rt32-3model", "rt32-table")
    assert again.reading == "as-written"


def test_file_is_small_and_the_same_every_time(table, written, tmp_path):
    """At most 0.45 MB; with the clock fixed the same table gives the same bytes."""
    write_binary(table, tmp_path / "again.bin")

    assert written.stat().st_size <= 450_000
    assert (tmp_path / "again.bin").read_bytes() == written.read_bytes()


def test_a_long_name_ends_in_dots(table, tmp_path):
    """The header has 64 characters for a model's name, and says where that is not all of it."""
    long = replace(table, model="of the sub-reflector " * 4)
    write_binary(long, tmp_path / "long.bin")

    assert read_binary(tmp_path / "long.bin").model == long.model[:61] + "..."


def test_offsets_are_mapped_not_copied(written):
    """The offsets stay in the file: a memory map of 4-byte integers."""
    mapped = map_binary(written)

    assert isinstance(mapped.units, np.memmap)
    assert mapped.units.shape == (2, 541, 95)
    assert mapped.unit_deg == 1e-7


def damaged(data: bytes, offset: int) -> bytes:
    """Return data with one bit of a byte turned."""
    return data[:offset] + bytes([data[offset] ^ 4]) + data[offset + 1 :]


def of_version_2(data: bytes) -> bytes:
    """Return the table as if a later layout had written it, its checksum in order."""
    body = data[:8] + b"\x02" + data[9:-4]
    return body + zlib.crc32(body).to_bytes(4, "little")


WRONG = [
    (lambda data: damaged(data, 3), "does not begin", "no binary steering table"),
    (lambda data: damaged(data, 100), "damaged", "damaged"),
    (lambda data: damaged(data, 300_000), "damaged", "damaged"),
    (lambda data: damaged(data, len(data) - 1), "damaged", "damaged"),
    (lambda data: damaged(data, 17), "promises", "promises"),
    (lambda data: data[:-1], "promises", "promises"),
    (lambda data: data[:400], "does not begin", "no binary steering table"),
    (lambda data: data + b"\0", "promises", "promises"),
    (of_version_2, "version 2", "another layout version"),
    (lambda _: b"", "does not begin", "no binary steering table"),
]


@pytest.mark.parametrize(("spoil", "said", "_in_fortran"), WRONG)
def test_spoilt_file_is_refused(written, spoil, said, _in_fortran):
    """A turned bit, a missing byte, another version: one clear error, no numbers."""
    written.write_bytes(spoil(written.read_bytes()))
    with pytest.raises(BadInput, match=said) as raised:
        read_binary(written)

    assert str(written) in str(raised.value)


@pytest.mark.parametrize(("spoil", "_said", "in_fortran"), WRONG)
def test_fortran_refuses_the_same(written, table_tool, spoil, _said, in_fortran):
    """The Fortran reader stops at the same damages, with status 2 and nothing printed."""
    written.write_bytes(spoil(written.read_bytes()))
    done = subprocess.run([table_tool, written], capture_output=True, text=True, check=False)

    assert done.returncode == 2
    assert in_fortran in done.stderr
    assert done.stdout == ""


def test_fortran_prints_the_ascii_table(table, written, table_tool, tmp_path):
    """All 51395 rows that the Fortran reader prints are the ASCII table's, byte for byte."""
    write_ascii(table, tmp_path / "table.txt")
    done = subprocess.run([table_tool, written], capture_output=True, check=True)

    assert done.stdout == (tmp_path / "table.txt").read_bytes()


def test_fortran_interpolates_as_python_does(written, table_tool):
    """Both answer the same offsets between the nodes, to the printed digit."""
    rng = np.random.default_rng(4)
    az_deg, zd_deg = rng.uniform(-270, 270, 500), rng.uniform(-5, 89, 500)
    asked = "".join(f"{a!r} {z!r}\n" for a, z in zip(az_deg.tolist(), zd_deg.tolist(), strict=True))
    done = subprocess.run(
        [table_tool, written, "-"], input=asked, capture_output=True, text=True, check=True
    )
    theirs = np.array([line.split() for line in done.stdout.splitlines()], float)
    ours = np.stack(offsets_at(read_table(written), az_deg, zd_deg), axis=1)

    np.testing.assert_allclose(theirs, ours, rtol=0, atol=0.51e-7)


def test_reader_is_sixty_lines():
    """The reader that a steering program takes over is no longer than that."""
    assert len((FORTRAN / "steering_table.f90").read_text().splitlines()) <= 60


def test_uneven_grid_and_huge_offsets_are_refused(tmp_path):
    """What the layout cannot hold is said before anything is written."""
    uneven = Grid(np.array([0.0, 1, 3]), np.array([0.0, 1]))
    with pytest.raises(BadInput, match="equal steps"):
        write_binary(Table(uneven, np.zeros((3, 2)), np.zeros((3, 2))), tmp_path / "t.bin")
    even = Grid(np.array([0.0, 1]), np.array([0.0, 1]))
    with pytest.raises(BadInput, match="214 deg"):
        write_binary(Table(even, np.full((2, 2), 215.0), np.zeros((2, 2))), tmp_path / "t.bin")

    assert not list(tmp_path.iterdir())


def test_header_is_512_bytes():
    """The offsets begin where the documentation says."""
    assert HEADER.size == 512
