"""TPOINT's observation files."""

import numpy as np
import pytest
from click.testing import CliRunner

from pyport.angles import DEG
from pyport.cli import pyport as program
from pyport.errors import BadInput
from pyport.formats.convert import convert
from pyport.recordings import read

HEAD = "Mine, 2026 Feb 1\n: ALTAZ\n: ROTNL\n-30 14 40.3\n"
STARS = """010.5802950 37.4249887 010.5461739 37.4892647 000.4402639 ; [0026] first
;015.1633975 47.4025372 015.1426321 47.4662831 000.2674897
! a remark, 4 words long
359.9990000 20.0000000 000.0010000 20.1000000 000.1
;197.7155763 21.6204140 00000000nan 0000000nan 290.9969464
END
whatever follows
"""


@pytest.fixture
def recordings(tmp_path):
    """Return four stars, two of them masked."""
    path = tmp_path / "mine.dat"
    path.write_text(HEAD + STARS)
    return read(path)


def test_offsets_are_what_was_read_minus_what_is_true(recordings):
    """Azimuth as a coordinate becomes cross-elevation, over north the short way."""
    cos_e = np.cos(recordings.at.el)

    np.testing.assert_allclose(recordings.x / DEG / cos_e, [-0.0341211, 0.002], atol=1e-12)
    np.testing.assert_allclose(recordings.y / DEG, [0.064276, 0.1], atol=1e-12)


def test_the_latitude_comes_from_the_file_and_the_rotator_is_kept(recordings):
    """Degrees, minutes and seconds carry one sign."""
    assert recordings.at.site.latitude / DEG == pytest.approx(-(30 + 14 / 60 + 40.3 / 3600))
    np.testing.assert_array_equal(recordings.at.column("rotator_deg"), [0.4402639, 0.1])
    assert recordings.at.column("note").tolist() == ["[0026] first", ""]


def test_masked_stars_are_set_aside_and_remarks_are_none(recordings):
    """What a comment sign hides is listed with its line, readable or not."""
    assert [(one.line, one.reason) for one in recordings.set_aside] == [
        (6, "masked in the file"),
        (9, "masked in the file"),
    ]


def test_a_star_without_a_direction_is_written_masked_and_listed_with_its_reason(tmp_path):
    """No program could fit it; whatever else it lacks, and whatever stands behind it."""
    table = tmp_path / "mine.csv"
    table.write_text(
        "# latitude_deg: 50\naz_deg,el_deg,d_az_deg,d_el_deg,auxiliary_1,auxiliary_2\n"
        "10,40,0.1,0.1,7,8\n20,,0.1,0.1,7,8\n,40,0.1,0.1,7,8\n,,,,7,8\n"
    )
    convert(table, tmp_path / "out.dat")
    found = read(tmp_path / "out.dat")

    lines = (tmp_path / "out.dat").read_text().splitlines()
    assert [line[0] for line in lines[4:7]] == [";"] * 3
    assert len(found) == 1
    assert [(one.line, one.reason) for one in found.set_aside] == [
        (5, "no offset on either axis"),  # the file has none beside an unknown elevation
        (6, "no azimuth or no elevation"),
        (7, "no offset on either axis"),
    ]


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("title\n-30 14 40\n1 2 3 4\nEND\n", 1, "ALTAZ"),
        ("title\n: ALTAZ\nEND\n", 1, "no line with the latitude"),
        ("title\n: ALTAZ\n-30 14\nEND\n", 3, "expected the latitude"),
        ("title\n: ALTAZ\n-30 74 40\nEND\n", 3, "latitude"),
        (HEAD + "END\n", 4, "no observations"),
        (HEAD + "1 2 3\nEND\n", 5, "3 numbers"),
        (HEAD + "1 2 3 four\nEND\n", 5, "'four', expected a number"),
        (HEAD + "1 2 3 1e999\nEND\n", 5, "expected a number"),
    ],
)
def test_a_bad_file_names_its_line(tmp_path, text, line, words):
    """One line that says what was expected."""
    path = tmp_path / "bad.dat"
    path.write_text(text)

    with pytest.raises(BadInput, match=words) as caught:
        read(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")


ONE_AXIS = "# latitude_deg: 50\naz_deg,el_deg,d_az_deg,d_el_deg\n"


def test_stars_measured_in_one_axis_are_counted(tmp_path):
    """They are written masked, which is said; a star that was masked before is not among them."""
    table, target = tmp_path / "mine.csv", tmp_path / "out.dat"
    table.write_text(f"{ONE_AXIS}10,40,0.1,0.1\n20,40,0.1,\n30,40,,0.1\n")

    done = CliRunner().invoke(program, ["convert", str(table), str(target)])

    assert done.exit_code == 0, done.output
    assert "out.dat: 3 recordings as tpoint-dat\n2 of them masked: an angle or an" in done.output
    assert convert(target, tmp_path / "again.dat").masked == 0


def test_stars_none_of_which_has_both_axes_are_refused(tmp_path):
    """TPOINT could fit none of them: no file is written."""
    table, target = tmp_path / "mine.csv", tmp_path / "out.dat"
    table.write_text(f"{ONE_AXIS}10,40,0.1,\n20,40,0.1,\n30,40,,0.1\n")

    with pytest.raises(BadInput, match="no row has both angles and both offsets, expected at lea"):
        convert(table, target)
    assert not target.exists()
