"""Malformed files: one line that names the file, the line and what was expected."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from pyport.cli import pyport as program
from pyport.errors import BadInput
from pyport.recordings import read, write
from pyport.recordings.formats import csv

GOOD = "az_deg,el_deg,d_el_deg\n"

CASES = {
    "no_names": ("hello\n1\n", 1, "separated by commas"),
    "no_header": ("# latitude_deg: 1\n", 1, "no line of column names"),
    "no_rows": ("# latitude_deg: 1\n" + GOOD, 2, "no rows"),
    "no_offset": ("az_deg,el_deg\n1,2\n", 1, "no offset column"),
    "no_position": ("az_deg,d_el_deg\n1,2\n", 1, "no columns az_deg and el_deg"),
    "not_a_number": (GOOD + "1,2,3\n1,2,three\n", 3, "'three', expected a number"),
    "an_underscore": (GOOD + "1,2,3\n1,2,1_0\n", 3, "'1_0', expected a number"),
    "other_digits": (GOOD + "1,2,3\n1,2,\u0661\n", 3, "expected a number"),
    "infinite": (GOOD + "1,2,inf\n", 2, "infinite"),
    "azimuth": (GOOD + "1,2,3\n1e9,2,3\n", 3, "azimuth outside +-720"),
    "beyond_the_zenith": (
        "# highest_el_deg: 120\n" + GOOD + "1,125,3\n",
        3,
        "elevation above 120 deg, expected less, or a line '# highest_el_deg: 125'",
    ),
    "degrees_for_hours": (
        "# latitude_deg: 50\nhour_angle_h,dec_deg,d_el_arcsec\n2,30,5\n34,30,5\n",
        4,
        "hour angle outside +-24 h, expected hours in a column hour_angle_h",
    ),
    "other_hemisphere": (
        "# latitude_deg: -50\nhour_angle_h,dec_deg,d_el_arcsec\n2,30,5\n2,60,5\n",
        4,
        "hour angle and declination of a place below the horizon, expected a telescope's",
    ),
    "elevation": (GOOD + "1,-11,3\n", 2, "elevation outside [-10, 180]"),
    "offset": (GOOD + "1,2,181\n", 2, "above 180 deg"),
    "too_few": (GOOD + "1,2,3\n1,2\n", 3, "2 cells, expected 3"),
    "too_many": (GOOD + "1,2,3,4\n", 2, "4 cells, expected 3"),
    "twice": ("az_deg,el_deg,d_el_deg,d_el_deg\n1,2,3,4\n", 1, "two columns"),
    "nameless": ("az_deg,el_deg,,d_el_deg\n1,2,3,4\n", 1, "no name"),
    "two_units": ("az_deg,el_deg,d_el_deg,d_el_arcsec\n1,2,3,4\n", 1, "say the same"),
    "two_signs": ("az_deg,el_deg,d_el_deg,d_zd_deg\n1,2,3,4\n", 1, "say the same"),
    "two_axes": ("az_deg,el_deg,d_az_deg,d_xel_deg\n1,2,3,4\n", 1, "say the same"),
    "no_unit": ("az,el,d_el\n1,2,3\n", 1, "has no unit"),
    "time_without_zone": ("az_deg,el_deg,d_el_deg,time\n1,2,3,4\n", 1, "expected time_utc"),
    "bad_time": ("az_deg,el_deg,d_el_deg,time_utc\n1,2,3,noon\n", 2, "ISO 8601"),
    "zero_sigma": ("az_deg,el_deg,d_el_deg,sigma_el_deg\n1,2,3,0\n", 2, "not positive"),
    "direction": ("az_deg,el_deg,d_el_deg,scan_direction\n1,2,3,2\n", 2, "scan_direction"),
    "axis": ("az_deg,el_deg,d_el_deg,scan_axis\n1,2,3,ra\n", 2, "scan_axis"),
    "rate": ("az_deg,el_deg,d_el_deg,scan_rate_arcmin_per_min\n1,2,3,-1\n", 2, "negative"),
    "latitude": ("# latitude_deg: 190\n" + GOOD + "1,2,3\n", 1, "latitude_deg"),
    "zero": ("# azimuth_zero: east\n" + GOOD + "1,2,3\n", 1, "azimuth_zero"),
    "open_quote": (GOOD + '1,2,3\n1,2,"3\n1,2,3\n', 3, "a quote is not closed (unexpected end of"),
    "open_quote_in_the_last": (GOOD + '1,2,3\n1,2,"3', 3, "unexpected end of data, expected CSV"),
    "semicolons": ("sep=;\naz_deg;el_deg;d_el_deg\n1;2;3\n", 2, "separated by commas"),
    "quote_that_ends_early": (GOOD + '1,2,"3"4\n1,2,3\n', 2, "expected after"),
    "runaway": (GOOD[:-1] + ",source\n1,2,3," + "C" * 2000 + "\n", 2, "1000 characters"),
    "empty": ("", 1, "empty"),
    "blank": ("\n \n", 1, "empty"),
}


@pytest.mark.parametrize("reader", ["Python's", "Arrow's"])
@pytest.mark.parametrize("case", CASES)
def test_bad_file(tmp_path, monkeypatch, case, reader):
    """The error names file and line, and says what is wrong, on one line."""
    if reader == "Arrow's":
        monkeypatch.setattr(csv, "LEAST_BYTES", 1)
    text, line, words = CASES[case]
    path = tmp_path / f"{case}.csv"
    path.write_text(text)

    with pytest.raises(BadInput) as caught:
        read(path)

    message = str(caught.value)
    assert message.startswith(f"{path}:{line}: ")
    assert words in message
    assert "\n" not in message


@pytest.mark.parametrize("content", [b"\x00\x01\x02", b"az_deg\n\xff\xfe\n", b"\x89PNG\r\n\x1a\n"])
@pytest.mark.parametrize("suffix", [".csv", ".ecsv"])
def test_binary_file(tmp_path, content, suffix):
    """A file that is no text is refused as binary."""
    path = tmp_path / f"night{suffix}"
    path.write_bytes(content)

    with pytest.raises(BadInput, match="binary"):
        read(path)


@pytest.mark.parametrize("suffix", [".log", ".csv", ".txt", ".dat"])
@pytest.mark.parametrize("command", ["fit", "look"])
def test_a_log_of_the_field_system_is_read_by_xtrac(tmp_path, suffix, command):
    """The .xtr that it makes is what is read; a table whose times are written so is a table."""
    log = tmp_path / f"r1{suffix}"
    log.write_text(
        "2025.041.07:30:00.12:Log Opened: Mark IV Field System Version 10.1.0\n"
        "2025.041.07:30:00.12;location,SOMEWHERE,-20.5,41.25,310.0\n"
        "2025.041.07:34:10.55#fivpt#offset 121.3 41.0 0.0102 -0.0044 1 1 01d0 taua\n"
    )
    done = CliRunner().invoke(program, [command, str(log)])

    said = f"{log}:1: a log of the VLBI Field System, expected the .xtr file"
    assert str(done.exception).startswith(said)
    log.write_text(
        "t;az;el;del\n2025.041.07:30:00.12;121.3;41.0;0.25\n2025.041.07:34:00.12;12;31;0.5\n"
    )
    assert "Field System" not in str(CliRunner().invoke(program, [command, str(log)]).exception)


@pytest.mark.parametrize("suffix", [".ecsv", ".parquet"])
@pytest.mark.parametrize("content", [b"", b"az_deg,el_deg\n1,2\n"])
def test_wrong_content_for_the_suffix(tmp_path, suffix, content):
    """A table that is not what its suffix says is refused, with the file's name."""
    path = tmp_path / f"night{suffix}"
    path.write_bytes(content)

    with pytest.raises(BadInput) as caught:
        read(path)

    assert str(caught.value).startswith(f"{path}:1: ")


def test_unknown_suffix(tmp_path):
    """A suffix that names no format is refused, and the known ones are told."""
    path = tmp_path / "night.xlsx"
    path.write_text("az_deg")

    with pytest.raises(BadInput, match=r"\.csv, \.ecsv, \.parquet.*, \.err; --columns reads"):
        read(path)


def test_unknown_suffix_to_write(tmp_path):
    """The suffixes are those that are written, and nothing is said of reading."""
    night = read("gmrt-2003-06-01")

    with pytest.raises(BadInput, match=r"expected \.csv, \.ecsv, \.parquet, \.dat, \.xtr$"):
        write(night, tmp_path / "night.xlsx")


def test_missing_file(tmp_path):
    """A name that is neither a file nor shipped is refused, and the shipped names are told."""
    with pytest.raises(BadInput, match="gmrt-2003-06-01"):
        read(tmp_path / "nothing.csv")


def test_folder(tmp_path):
    """A folder is no file of recordings."""
    with pytest.raises(BadInput, match="folder"):
        read(tmp_path)


@pytest.mark.slow
@settings(max_examples=300, deadline=None)
@given(st.data())
def test_any_damage_is_one_clear_line(tmp_path_factory, data):
    """However a good file is damaged, it reads or it is refused in one line that names it."""
    good = (
        b"# latitude_deg: 53\n# azimuth_zero: south\n"
        b"az_deg,el_deg,d_xel_arcsec,d_el_arcsec,time_utc,source,scan_direction\n"
        b'-90,40,1.5,-2,2003-06-01T12:00:00Z,"Cyg A, core",1\n10,50,,3,,3C84,-1\n'
    )
    path = tmp_path_factory.mktemp("damaged") / "night.csv"
    content = bytearray(good)
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(content) - 1))
        junk = data.draw(st.binary(max_size=3) | st.sampled_from([b",", b'"', b"\n", b"1e400"]))
        content[place : place + data.draw(st.integers(0, 5))] = junk
        content = content or bytearray(b" ")
    path.write_bytes(content)

    night, refused = None, ""
    try:
        night = read(path)
    except BadInput as error:
        refused = str(error)

    if night is None:
        assert refused.startswith(f"{path}:")
        assert "\n" not in refused
    else:
        assert np.isfinite(night.at.el).all()
        assert (np.isfinite(night.x) | np.isfinite(night.y)).all()
