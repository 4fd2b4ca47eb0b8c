"""`pyport diagnose` of an array: a survey names the site, everything is in the report."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from diagnosis.arrays.made_array import array, names

from pyport.cli import pyport
from pyport.errors import BadInput
from pyport.recordings import write

EAST_M = np.array([0, 3000, 7000, -2500, -6500, 500.0])


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """Return a file of an array's recordings."""
    path = tmp_path_factory.mktemp("array") / "made.csv"
    write(array(EAST_M, sessions=2, seed=6)[0], path)
    return path


def diagnose(recordings, out, *more):
    """Run the command and return its result; errors are raised."""
    wanted = ["diagnose", str(recordings), "--model", "gmrt-paper", "--out", str(out), *more]
    return CliRunner().invoke(pyport, wanted, catch_exceptions=False, standalone_mode=False)


@pytest.mark.slow
def test_a_survey_names_the_site_in_the_report(recordings, tmp_path):
    """The finding, the numbers, the picture and the words are all there."""
    survey = tmp_path / "antennas.csv"
    rows = [f"{name},{east}" for name, east in zip(names(len(EAST_M)), EAST_M, strict=True)]
    survey.write_text("\n".join(["name,east_m", *rows]))
    result = diagnose(recordings, tmp_path, "--antennas", str(survey))
    told = json.loads((tmp_path / "made/report.json").read_text())

    site = next(one for one in told["findings"] if one["effect"] == "site_longitude")
    assert site["verdict"] == "named"
    assert site["class"] == ["site_longitude"]
    assert told["mismatch"] is True
    assert told["array"]["survey"]["site_longitude"] is True
    assert told["array"]["survey"]["slope"] == pytest.approx(1, abs=0.3)
    assert len(told["array"]["places"]["antennas"]) == len(EAST_M)
    assert (tmp_path / "made/array-places.png").stat().st_size > 10_000
    assert "site_longitude" in result.output
    assert "Beside the survey" in result.output


@pytest.mark.slow
def test_without_a_survey_displacements_are_stated_and_nothing_is_named(recordings, tmp_path):
    """Recordings alone cannot tell a displaced antenna from a leaning one."""
    result = diagnose(recordings, tmp_path)
    told = json.loads((tmp_path / "made/report.json").read_text())

    assert told["array"]["survey"] is None
    assert told["array"]["places"] is not None
    assert "site_longitude" not in [one["effect"] for one in told["findings"]]
    assert "metres toward east" in result.output


@pytest.mark.slow
def test_a_survey_of_others_is_refused(recordings, tmp_path):
    """The error names the survey's file, and nothing is written."""
    survey = tmp_path / "antennas.csv"
    survey.write_text("name,east_m\nX,1\n")
    with pytest.raises(BadInput, match=r"antennas\.csv:1: none of the recorded antennas"):
        diagnose(recordings, tmp_path / "out", "--antennas", str(survey))

    assert not (tmp_path / "out").exists()
