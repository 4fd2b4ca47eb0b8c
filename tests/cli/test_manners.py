"""Manners that all commands share: --quiet, --json, an example, completion, statuses."""

import dataclasses
import json
import math
import os
import pty
import subprocess
import sys

import click
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from pyport.cli import FORMER, pyport
from pyport.cli.manners import STATUSES, plain
from pyport.recordings import resolve


def leaves(group, words=()):
    """Return every command with the words that call it, commands of groups among them."""
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, click.Group):
            yield from leaves(command, (*words, name))
        else:
            yield (*words, name), command


LEAVES = dict(leaves(pyport))


def run(*words):
    """Run the command line in this process."""
    return CliRunner().invoke(pyport, [str(word) for word in words], catch_exceptions=False)


@pytest.mark.parametrize("words", LEAVES, ids=" ".join)
def test_every_command_has_quiet_json_and_an_example_that_it_understands(words):
    """The options are there; the example names the command and only options that it has."""
    command = LEAVES[words]
    options = {flag for one in command.params for flag in one.opts}
    example = command.epilog or ""
    ours = [part for part in example.split(";") if f"pyport {' '.join(words)}" in part]
    used = {word for part in ours for word in part.split() if word.startswith("--")}

    assert {"--quiet"} <= options
    assert words == ("completion",) or "--json" in options
    assert example.startswith("Example")
    assert ours
    assert used <= options | {"--help"}


@pytest.mark.parametrize(("former", "now"), FORMER.items())
def test_a_former_name_works_and_says_the_new_one(former, now):
    """The help of the command it stands for, and a line on standard error."""
    old, new = run(former, "--help"), run(*now.split(), "--help")

    assert old.exit_code == 0
    assert old.stderr == f"pyport: `pyport {former}` is `pyport {now}` now\n"
    assert old.stdout.split("Options:")[1] == new.stdout.split("Options:")[1]


def test_statuses_are_told_by_help():
    """`pyport --help` tells what 0, 2 and 130 mean, and one line says what is wrong."""
    assert " ".join(STATUSES.split()) in " ".join(run("--help").output.split())


def test_quiet_prints_nothing_and_does_the_work(tmp_path):
    """A command that knows nothing of --quiet keeps silent all the same."""
    path = tmp_path / "3.txt"
    done = run("table", "--az", "0:2:1", "--zd", "20:22:1", "-o", path, "--quiet")

    assert (done.exit_code, done.output) == (0, "")
    assert path.stat().st_size > 0


def test_errors_are_told_even_when_quiet(tmp_path):
    """--quiet leaves the one line about bad input."""
    done = subprocess.run(
        [sys.executable, "-m", "pyport", "dev", "effects", "nonsense", "--quiet"],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env=os.environ,
    )

    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("pyport: error: no effect is called 'nonsense'")


def test_effects_as_json_are_the_catalogue():
    """Every effect with its coefficients and what it looks like."""
    found = {one["id"]: one for one in json.loads(run("dev", "effects", "--json").output)}

    assert found["refraction"]["coefficients"][0]["unit"] == "arcsec"
    assert "sag_sine" in {one["effect"] for one in found["refraction"]["looks_like"]}
    assert len(json.loads(run("dev", "effects", "refraction", "tilt", "--json").output)) == 2


def test_a_table_as_json_says_what_was_written_and_checked(tmp_path):
    """Files, rows and the count of printed cells that agree."""
    path = tmp_path / "3.txt"
    grid = ["--az", "0:2:1", "--zd", "20:22:1"]
    told = json.loads(run("table", *grid, "-o", path, "--check", "--json").output)
    other = json.loads(run("table", *grid, "--against", path, "--json").output)

    assert told["table"] == {
        "file": str(path),
        "rows": 9,
        "model": "rt32-3model",
        "refraction": told["table"]["refraction"],
    }
    assert all(one["agree"] == one["total"] for one in told["check"])
    assert other["against"]["azimuth_deg"]["largest"] < 1e-7


def test_answers_of_a_table_as_lines_of_json(tmp_path):
    """The same four angles as the text, one line an answer."""
    path = tmp_path / "3.bin"
    run("table", "--az", "0:4:1", "--zd", "20:24:1", "--format", "binary", "-o", path)
    words = ["lookup", path, "--az", "1.5", "--zd", "22"]
    text = [float(word) for word in run(*words).output.split()]
    told = json.loads(run(*words, "--json").output)

    assert list(told.values()) == text
    assert list(told) == ["az_deg", "zd_deg", "d_az_deg", "d_zd_deg"]


def test_a_conversion_as_json(tmp_path):
    """The file, how many rows, the format."""
    path = tmp_path / "day.ecsv"
    told = json.loads(run("convert", resolve("gmrt-2003-06-02"), path, "--json").output)

    assert told["file"] == str(path)
    assert told["number"] > 1000


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_is_printed_for_each_shell(shell):
    """The script asks pyport itself."""
    assert "_PYPORT_COMPLETE" in run("completion", shell).output


@pytest.mark.parametrize(
    ("typed", "at", "expected"),
    [
        ("pyport dia", 1, "diagnose"),
        ("pyport fit gmrt-2003-06-0", 2, "gmrt-2003-06-01"),
        ("pyport diagnose x.csv --model rt3", 4, "rt32-exact"),
        ("pyport dev effects refr", 3, "refraction_curvature"),
        ("pyport look x.csv --so", 3, "--sources"),
    ],
)
def test_names_are_completed(typed, at, expected):
    """Commands, options, models, recordings and effects, as a shell would ask for them."""
    done = subprocess.run(
        [sys.executable, "-c", "from pyport.cli import main; main()"],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ
        | {"_PYPORT_COMPLETE": "bash_complete", "COMP_WORDS": typed, "COMP_CWORD": str(at)},
    )

    assert f"plain,{expected}" in done.stdout.splitlines()


@pytest.mark.slow
@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
        lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
        max_leaves=12,
    )
)
def test_whatever_is_plain_is_json(value):
    """What comes out can be spelled without NaN, and finite values come out as they were."""
    text = json.dumps(plain(value), allow_nan=False)

    assert plain(json.loads(text)) == json.loads(text)


def test_plain_takes_arrays_and_dataclasses_apart():
    """Numpy's numbers, arrays and dataclasses lose their type and keep their values."""

    @dataclasses.dataclass
    class Two:
        one: np.ndarray
        other: float

    assert plain(Two(np.arange(3), math.inf)) == {"one": [0, 1, 2], "other": None}
    assert plain((np.float64(1.5), np.bool_(True))) == [1.5, True]  # noqa: FBT003 - numpy's


@pytest.mark.slow
def test_what_is_being_done_is_told_on_a_terminal_only():
    """On a terminal standard error says what goes on; into a file it says nothing."""
    words = [sys.executable, "-m", "pyport", "look", "gmrt-2003-06-02", "--model", "gmrt-paper"]
    ours, theirs = pty.openpty()
    shown = subprocess.run(words, stdout=subprocess.PIPE, stderr=theirs, check=True, text=True)
    os.close(theirs)
    told = os.read(ours, 100_000).decode()
    os.close(ours)
    into_a_file = subprocess.run(words, capture_output=True, check=True, text=True)

    assert "looking" in told
    assert into_a_file.stderr == ""
    assert shown.stdout == into_a_file.stdout
