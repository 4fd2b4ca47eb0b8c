"""A survey of antennas: read, or refused with file and line."""

import pytest

from pyport.errors import BadInput
from pyport.recordings.files import read_survey


def written(tmp_path, text):
    """Return a file with some text."""
    path = tmp_path / "antennas.csv"
    path.write_text(text)
    return path


def test_names_and_metres_are_read(tmp_path):
    """Columns may stand in any order, others are ignored."""
    survey = read_survey(written(tmp_path, "north_m,name,east_m\n1,A1,10.5\n2,A2,-3\n"))

    assert survey.names == ("A1", "A2")
    assert survey.east_m.tolist() == [10.5, -3.0]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("name,north_m\nA1,1\n", ":1: no column 'east_m'"),
        ("antenna,east_m\nA1,1\n", ":1: no column 'name'"),
        ("name,east_m\nA1,1\nA1,2\n", ":3: this antenna stands there twice"),
        ("name,east_m\nA1,1\nA2,\n", ":3: east_m is blank"),
        ("name,east_m\nA1,1\n,2\n", ":3: name is blank"),
        ("name,east_m\nA1,far\n", ":2: east_m is 'far'"),
        ("name,east_m\nA1\n", ":2: 1 cell"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path, text, told):
    """Bad input is one line with file and line."""
    path = written(tmp_path, text)
    with pytest.raises(BadInput) as caught:
        read_survey(path)

    assert f"{path}{told}" in str(caught.value)


def test_a_missing_file_is_told(tmp_path):
    """The error names the file."""
    with pytest.raises(BadInput, match="no such file"):
        read_survey(tmp_path / "nothing.csv")
