"""Masks: kept beside the file, told with their reason, undone step by step."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from pyport.cli import pyport
from pyport.cli.files import mask
from pyport.errors import BadInput
from pyport.recordings import masks, read
from pyport.recordings.formats import registry as tables

TEXT = "az_deg,el_deg,d_el_deg,set_aside\n" + "".join(
    f"{n},{10 * n},{0.1 if n < 8 else 3},{'rain' if n == 3 else ''}\n" for n in range(1, 9)
)


@pytest.fixture
def file(tmp_path):
    """Return a file of eight recordings on lines 2 to 9."""
    path = tmp_path / "a.csv"
    path.write_text(TEXT)
    return path


def run(*arguments):
    """Run `pyport mask` and return what it prints."""
    done = CliRunner().invoke(mask, [str(one) for one in arguments], catch_exceptions=False)
    assert done.exit_code == 0
    return done.output


def aside(file):
    """Return what is excluded on reading, line by line."""
    return {one.line: one.reason for one in read(file).set_aside}


def test_a_masked_line_is_set_aside_with_its_reason(file):
    """What the file itself excluded keeps its own reason; the file is not touched."""
    run(file, "--lines", "2,4-5", "--reason", "wind")

    assert aside(file) == {2: "masked: wind", 4: "rain", 5: "masked: wind"}
    assert file.read_text() == TEXT


def test_masks_are_undone_step_by_step(file):
    """Back to a folder without a mask."""
    run(file, "--lines", "2")
    run(file, "--lines", "5-6", "--reason", "Sun")
    run(file, "--lines", "6", "--unmask")
    assert aside(file) == {2: "masked", 4: "rain", 5: "masked: Sun"}

    run(file, "--undo")
    assert aside(file) == {2: "masked", 4: "rain", 5: "masked: Sun", 6: "masked: Sun"}
    run(file, "--undo")
    run(file, "--undo")

    assert aside(file) == {4: "rain"}
    assert not masks.path_of(file).exists()
    with pytest.raises(BadInput, match="no step of a mask to undo"):
        masks.undo(file)


def test_masking_by_an_expression_tells_it(file):
    """The expression is the reason unless another is given."""
    told = run(file, "--where", "el_deg >= 70")

    assert "masked 8-9 (2 lines)" in told
    assert aside(file)[8] == "masked: el_deg >= 70"


def test_outliers_of_a_fit_are_masked(tmp_path):
    """What the fit gave no weight to."""
    path = tmp_path / "b.csv"
    rows = "".join(f"{n},{n},{0.1 + 0.001 * (n % 3)}\n" for n in range(10, 40))
    path.write_text("az_deg,el_deg,d_el_deg\n" + rows + "40,40,2\n")
    model = tmp_path / "m.toml"
    model.write_text('[[term]]\neffect = "elevation_zero"\n')

    run(path, "--outliers", model, "--reason", "far out")

    assert aside(path) == {32: "masked: far out"}


def test_a_line_that_is_no_recording_cannot_be_masked(file):
    """The header's, or one below the end."""
    raw = tables.read(file)
    for line in (1, 99):
        with pytest.raises(BadInput, match=f"line {line} is no recording"):
            masks.add(raw, [line], "")


def test_a_mask_of_lines_that_changed_is_refused(file):
    """Another row in the same place is not masked by accident."""
    run(file, "--lines", "5")
    file.write_text(TEXT.replace("4,40,", "4,41,"))

    with pytest.raises(BadInput, match=r"step 1 masks lines of a\.csv that have changed"):
        read(file)


@pytest.mark.parametrize("line", ["+ 5", "* 5 #00000000 | x", "+ 5-3 #00000000 | x", "+ #0 | x"])
def test_a_bad_mask_names_its_line(file, line):
    """One line that says what was expected."""
    masks.path_of(file).write_text(f"{line}\n")

    with pytest.raises(BadInput, match=r"a\.csv\.mask:1: "):
        read(file)


@given(st.sets(st.integers(1, 200), min_size=1))
def test_lines_come_back_from_their_spelling(lines):
    """Runs are told by their ends."""
    assert masks.parse_lines(masks.spelled(lines)) == tuple(sorted(lines))


@pytest.fixture
def masked(tmp_path):
    """Write sixty pointings, one without elevation, and mask the first two."""
    rng = np.random.default_rng(1)
    places = rng.uniform((0, 20), (360, 80), (60, 2))
    cells = np.column_stack([places, rng.normal(0, 3, (60, 2))])
    rows = [",".join(f"{one:.3f}" for one in row) for row in cells]
    path = tmp_path / "night.csv"
    head = "# latitude_deg: 53\n# longitude_deg: 18.6\naz_deg,el_deg,d_xel_arcsec,d_el_arcsec"
    path.write_text("\n".join([head, *rows, "9,,1,1", ""]))
    run(path, "--lines", "4-5", "--reason", "clouds")
    CliRunner().invoke(pyport, ["fit", str(path), "--model", "altaz", "--save", f"{path}.toml"])
    return path


@pytest.mark.parametrize(
    "command",
    [
        "fit night.csv --model altaz",
        "fit night.csv --model rt32-exact --method huber",
        "predict night.csv",
        "compare night.csv.toml night.csv.toml --recordings night.csv",
        "look night.csv",
    ],
)
def test_every_command_counts_and_lists_what_is_excluded(masked, monkeypatch, command):
    """One first line for all; in JSON each line with its reason, as in a diagnosis."""
    monkeypatch.chdir(masked.parent)
    shown = CliRunner().invoke(pyport, command.split()).stdout
    told = json.loads(CliRunner().invoke(pyport, [*command.split(), "--json"]).stdout)["input"]

    assert shown.startswith("night.csv: 58 recordings, 3 excluded")
    assert (told["file"], told["rows"], told["used"]) == ("night.csv", 61, 58)
    assert {one["line"]: one["reason"][:14] for one in told["set_aside"]} == {
        4: "masked: clouds",
        5: "masked: clouds",
        64: "no azimuth or ",
    }


def test_a_diagnosis_says_which_lines_are_excluded_and_why(masked):
    """Lines of one reason together; of many the first eight."""
    few = CliRunner().invoke(pyport, ["diagnose", str(masked)]).stdout
    run(masked, "--lines", "10-20", "--reason", "rain")
    many = " ".join(CliRunner().invoke(pyport, ["diagnose", str(masked)]).stdout.split())

    assert "Excluded, lines 4, 5: masked: clouds" in few
    assert "Excluded, line 64: no azimuth or no elevation." in few
    assert "Excluded, lines 10, 11, 12, 13, 14, 15, 16, 17 and 3 more: masked: rain" in many


def test_targets_count_what_is_excluded_beside_the_list(masked):
    """The list stays what other programs read; the count goes to standard error."""
    asked = ["targets", str(masked), "--start", "2026-03-01T18:00:00Z", "--hours", "3"]
    done = CliRunner().invoke(pyport, [*asked, "--json"])

    assert isinstance(json.loads(done.stdout), list)
    assert done.stderr == "night.csv: 58 recordings, 3 excluded, model altaz\n"


def test_what_is_not_masked_is_not_unmasked(file):
    """No step that does nothing, and no file of its own for one."""
    said = run(file, "--lines", "5", "--unmask")

    assert "none of these is masked: nothing was changed" in said
    assert not masks.path_of(file).exists()
