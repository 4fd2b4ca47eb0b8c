"""Each case is solved alone, blind, once, and as often interrupted as it likes."""

import subprocess
import sys

import pytest

from pyport.errors import BadInput
from pyport.examiner.sealed import seal, solve
from pyport.examiner.sealed.record.published import read_json

pytestmark = pytest.mark.usefixtures("solvers")


def reports(root):
    """Return all reports of a set."""
    return [read_json(path) for path in sorted(root.glob("reports/*/report.json"))]


def test_a_solver_sees_the_recordings_and_nothing_else(sealed):
    """Its folder holds one file, whose name is the same for every case."""
    solve.run(sealed, 2, ("fake_solver", "silent"))

    assert len(reports(sealed)) == 13
    assert all(one["two_axes"]["beside"] == ["recordings.csv"] for one in reports(sealed))


def test_a_held_model_is_asked_for_on_the_command_line(sealed):
    """The arguments that a case was sealed with reach the solver."""
    solve.run(sealed, 2, ("fake_solver", "silent"))
    held = [said for one in reports(sealed) if (said := one["two_axes"]["arguments"])]

    assert held == [["--model", "none", "--refit", "none"]]


def test_a_solver_that_reaches_for_the_vault_is_stopped(sealed):
    """From its cell a truth cannot be opened, however the path is spelled."""
    vault = seal.Folder(sealed).vault
    spelled = vault.parent / "a-set" / ".." / vault.name / "case-0001.truth.json"
    arguments = ("spy", "x.csv", "--out", "x", str(spelled))
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "pyport.examiner.sealed.cell",
            str(vault),
            "fake_solver",
            *arguments,
        ],
        capture_output=True,
        text=True,
        check=False,
    )

    assert spelled.exists()
    assert done.returncode != 0
    assert "the truth is sealed" in done.stderr


@pytest.mark.parametrize(
    ("how", "why"),
    [
        ("crash", "I have no idea"),
        ("mute", "left no report.json"),
        ("babble", "cannot be scored: 'effect' is"),
    ],
)
def test_a_solver_that_fails_is_recorded_as_failing(sealed, how, why):
    """No answer is an answer, with what the solver said when it died."""
    solve.run(sealed, 2, ("fake_solver", how))

    assert all(why in one["examined"]["failed"] for one in reports(sealed))


@pytest.mark.slow
@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "SIGKILL"])
def test_a_solver_that_is_stopped_from_outside_gave_no_answer(sealed, how):
    """A key, a shutdown or a machine out of memory is no failure of the solver: asked again."""
    with pytest.raises(KeyboardInterrupt):
        solve.run(sealed, 1, ("fake_solver", how))

    assert reports(sealed) == []
    assert solve.run(sealed, 2, ("fake_solver", "silent")) == 13


def test_a_solver_that_crashes_failed(sealed):
    """A segmentation fault is the solver's."""
    solve.run(sealed, 2, ("fake_solver", "SIGSEGV"))

    assert {one["examined"]["failed"] for one in reports(sealed)} == {"exit status -11"}


@pytest.mark.slow
def test_killed_and_called_again_it_goes_on(sealed):
    """What was answered stays answered, by whom it was; only the rest is solved."""
    solve.run(sealed, 2, ("fake_solver", "parrot"))
    folder = seal.Folder(sealed)
    for case in ("case-0002", "case-0007"):
        folder.report(case).unlink()

    assert solve.run(sealed, 1, ("fake_solver", "silent")) == 2
    assert [one["mismatch"] for one in reports(sealed)].count(False) == 2


def test_changed_recordings_are_not_solved(sealed):
    """A set that is not what was sealed is refused before anything runs."""
    path = seal.Folder(sealed).recordings("case-0001")
    path.write_text(path.read_text() + "\n")

    with pytest.raises(BadInput, match="not the ones that were sealed"):
        solve.run(sealed, 1, ("fake_solver", "silent"))


def test_an_opened_set_is_not_solved_again(answered):
    """One shot for each set."""
    seal.reveal(answered)

    with pytest.raises(BadInput, match="has been opened"):
        solve.run(answered)
