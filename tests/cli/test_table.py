"""`pyport table` and `pyport lookup` as a user calls them."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from pyport.cli import pyport as program
from pyport.cli.files import lookup
from pyport.cli.table import command as table
from pyport.errors import BadInput
from pyport.pointing import kernel
from pyport.recordings.files import read
from pyport.steering import read_table

SMALL = ["--az", "-10:10:5", "--zd", "20:30:5"]


def run(command, *words, **options):
    """Run a command and return what it printed, its errors raised."""
    return CliRunner().invoke(
        command, words, catch_exceptions=False, standalone_mode=False, **options
    )


def test_check_counts_every_printed_cell():
    """The six blocks agree whole: 143, 143, 143, 143, 6, 6."""
    counts = [line.split()[-3:] for line in run(table, "--check").output.splitlines()]

    assert [(one[0], one[2]) for one in counts] == [("143", "143")] * 4 + [("6", "6")] * 2


def test_check_of_another_reading_lists_what_differs():
    """A cell that differs is shown with its value and the printed one."""
    output = run(table, "--check", "--reading", "routine").output

    assert "azimuth 270, zenith distance 89" in output
    assert "printed -669250" in output


@pytest.mark.parametrize("layout", ["ascii", "binary"])
def test_table_is_written_and_read_back(tmp_path, layout):
    """Either layout, on a grid of the user's choice."""
    path = tmp_path / "table"
    run(table, *SMALL, "--format", layout, "-o", str(path))
    read_back = read_table(path)

    assert list(read_back.grid.az_deg) == [-10, -5, 0, 5, 10]
    assert list(read_back.grid.zd_deg) == [20, 25, 30]


@pytest.mark.slow
def test_against_a_file_and_a_model(tmp_path):
    """A table is compared with an old file, and with another model; a picture is drawn."""
    old, png = tmp_path / "old.txt", tmp_path / "d.png"
    run(table, *SMALL, "-o", str(old))
    same = run(table, *SMALL, "--against", str(old)).output
    other = run(table, *SMALL, "--against", "rt32-approximate", "--picture", str(png)).output

    assert same.count("equal everywhere") == 3
    assert "differ" in other
    assert png.read_bytes().startswith(b"\x89PNG")


def test_refractions_are_listed_best_first():
    """Every formula with its residual and the cells that it gives."""
    lines = run(table, "--refractions").output.splitlines()

    assert lines[1].startswith("rt32-table")
    assert lines[1].endswith("149 of 149")


def test_published_extracts_become_recordings(tmp_path):
    """273 cells as measured offsets, readable by the program."""
    path = tmp_path / "published.csv"
    run(table, "--recordings", str(path))

    assert len(read(path)) == 273


def test_lookup_answers_one_and_many(tmp_path):
    """One target by options, many by a file or standard input."""
    path = tmp_path / "table.bin"
    run(table, *SMALL, "--format", "binary", "-o", str(path))
    one = run(lookup, str(path), "--az", "-7.5", "--zd", "22").output
    many = run(lookup, str(path), "--batch", "-", input="-7.5 22\n0 20\n").output

    assert many.splitlines()[0] + "\n" == one
    assert len(many.splitlines()) == 2


def test_lookup_reads_what_editors_write(tmp_path):
    """A byte-order mark and CRLF are no part of a number; what is no UTF-8 is bad input."""
    path, asked = tmp_path / "table.bin", tmp_path / "asked.txt"
    run(table, *SMALL, "--format", "binary", "-o", str(path))
    asked.write_bytes(b"\xef\xbb\xbf-7.5 22\r\n0 20\r\n")
    many = run(lookup, str(path), "--batch", str(asked)).output
    asked.write_bytes(b"-7.5 22\n0 20 \xfcber\n")

    assert many == run(lookup, str(path), "--batch", "-", input="-7.5 22\n0 20\n").output
    with pytest.raises(BadInput, match=rf"{asked}:2: expected azimuth"):
        run(lookup, str(path), "--batch", str(asked))


def test_lookup_warns_beside_the_zenith(tmp_path):
    """Once, on standard error: azimuth offsets turn over there. Not on the table's own rows."""
    path = tmp_path / "table.bin"
    run(table, "--az", "-20:20:1", "--zd", "-3:10:1", "--format", "binary", "-o", str(path))
    near = run(lookup, str(path), "--batch", "-", input="3 5.5\n3 0.5\n3 -0.25\n3 0.75\n")
    far = run(lookup, str(path), "--batch", "-", input="3 1\n3 0\n3 -1\n3 1.5\n3 10\n3 -3\n")
    quiet = run(program, "lookup", str(path), "--az", "3", "--zd", "0.5", "--quiet")

    assert len(near.stdout.splitlines()) == 4
    assert near.stderr.count("cannot be interpolated, as at zenith distance 0.5000000 deg") == 1
    assert (far.stderr, quiet.stderr) == ("", "")


def test_errors_of_interpolation_are_stated(tmp_path):
    """Nine bands of zenith distance, for a table that says what it was made from."""
    path = tmp_path / "table.bin"
    run(table, "--az", "-20:20:1", "--format", "binary", "-o", str(path))
    output = run(lookup, str(path), "--errors").output

    assert len(output.splitlines()) == 11


def test_killed_while_writing_the_old_table_stays(tmp_path):
    """A kill while the new table is being written leaves the old file whole."""
    path = tmp_path / "table.txt"
    path.write_text("old\n")
    half_written = (
        "import sys, numpy as np\n"
        "from pyport.steering import Grid, ascii, tabulate, write_ascii\n"
        "table = tabulate(grid=Grid(np.array([0.0, 1.0]), np.array([10.0, 20.0])))\n"
        "def stuck(table):\n"
        "    print('writing', flush=True)\n"
        "    return sys.stdin.buffer.read()\n"
        "ascii.text = stuck\n"
        f"write_ascii(table, {str(path)!r})\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", half_written], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        said = process.stdout.readline()
        beside = sorted(one.name for one in tmp_path.iterdir())
        process.kill()

    assert said == b"writing\n"
    assert beside[0].startswith(".table.txt.")
    assert process.returncode == -signal.SIGKILL
    assert path.read_text() == "old\n"


@pytest.mark.skipif(kernel.KERNEL is None, reason="the kernel is not installed: make wheel")
def test_the_kernel_writes_the_table_before_anything_is_imported(tmp_path):
    """The bytes and the words are those of the command, without numpy or click."""
    shown = [
        subprocess.run(
            [sys.executable, "-X", "importtime", "-m", "pyport", "table", option, "table.txt"],
            cwd=tmp_path / how,
            capture_output=True,
            check=True,
        )
        for option, how in (("-o", "quick"), ("--output", "whole"))
        if not (tmp_path / how).mkdir()
    ]
    texts = [(tmp_path / how / "table.txt").read_bytes() for how in ("quick", "whole")]

    assert texts[0] == texts[1]
    assert shown[0].stdout == shown[1].stdout
    assert b"numpy" not in shown[0].stderr
    assert b"click" not in shown[0].stderr


def test_what_the_quick_table_cannot_do_is_left_to_the_command(tmp_path):
    """A folder in the file's place is refused in one line."""
    done = subprocess.run(
        [sys.executable, "-m", "pyport", "table", "-o", str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith("pyport: error: ")


@pytest.mark.parametrize(
    ("term", "more"),
    [("tilt", ["--azimuth-zero", "south"]), ("temperature", ["--set", "temperature_c=8"])],
)
def test_a_model_against_itself_does_not_differ(tmp_path, monkeypatch, term, more):
    """Whatever the azimuth starts at, and whatever the conditions are; nor does a look-up."""
    monkeypatch.chdir(tmp_path)
    model, path = Path("mine.toml"), Path("table.bin")
    model.write_text(f'name = "mine"\n[[term]]\neffect = "{term}"\nvalue_arcsec = [100, 0]\n')
    words = ["--model", str(model), *more, "--az", "0:40:1"]
    run(table, *words, "--format", "binary", "-o", str(path))
    same = run(table, *words, "--against", str(model)).output
    errors = run(lookup, str(path), "--errors", "--json", *more).output

    assert same.count("equal everywhere") == 3
    assert json.loads(errors.splitlines()[3])["zd_max_deg"] < 1e-5


def test_bands_without_a_cell_are_left_out(tmp_path):
    """A table from 5 to 85 deg has none at the horizon."""
    path = tmp_path / "table.bin"
    run(table, "--az", "0:20:5", "--zd", "5:85:5", "--format", "binary", "-o", str(path))

    assert "85 to  90" not in run(lookup, str(path), "--errors").output
