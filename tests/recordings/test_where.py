"""Filters: a language of comparisons that runs no code."""

import string

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyport.errors import BadInput
from pyport.recordings import read
from pyport.recordings.raw import FileOptions
from pyport.recordings.where import DEEPEST, parse, where

TEXT = """# latitude_deg: 53
# longitude_deg: 18.5
az_deg,el_deg,d_xel_arcsec,d_el_arcsec,sigma_el_arcsec,source,wind_speed_m_s,channel,time_utc
10,20,1,2,0.5,3C84,3,130,2026-06-21T00:00:00
20,40,-1,2,0.5,Vir A,7,130,2026-06-21T11:00:00
30,60,3,,0.5,3C273,,140,2026-06-21T12:00:00
40,80,4,5,,3C84,12,140,2026-12-21T23:00:00
"""


@pytest.fixture
def recordings(tmp_path):
    """Return four recordings; a wind, an offset and an error are not known."""
    path = tmp_path / "a.csv"
    path.write_text(TEXT)
    return read(path)


CASES = {
    "wind_speed_m_s < 5": [0],
    "wind_speed_m_s >= 7 or el_deg == 60": [1, 2, 3],
    "not wind_speed_m_s < 5": [1, 2, 3],
    "wind_speed_m_s != 3": [1, 3],
    "el_arcmin > 2400 and az_deg<40": [2],
    "el_deg > 10 and (az_deg < 15 or az_deg > 35)": [0, 3],
    'source == "3C84"': [0, 3],
    "source in ('3C84', 'Vir A')": [0, 1, 3],
    "source not in ('3C84', 'Vir A')": [2],
    "channel == 130": [0, 1],
    "channel in (140)": [2, 3],
    "d_xel_arcsec < -0.5": [1],
    "d_el_arcsec < 3": [0, 1],
    "sigma_el_arcsec <= 5e-1": [0, 1, 2],
    'time_utc > "2026-06-21T10:00" and time_utc < "2026-12-01"': [1, 2],
    "sun_el_deg < 0": [0, 3],
    "sun_el_deg > 50": [1, 2],
    "az_deg < 15 or az_deg > 35 and el_deg > 90": [0],
    "not (az_deg < 15 or az_deg > 35)": [1, 2],
}


@pytest.mark.parametrize("expression", CASES)
def test_what_holds_is_kept(recordings, expression):
    """`and` binds closer than `or`; comparisons with something unknown are not true."""
    assert np.flatnonzero(parse(expression)(recordings)).tolist() == CASES[expression]


def test_what_does_not_hold_is_set_aside_with_the_expression(recordings):
    """Each row with its line: nothing vanishes."""
    kept = where(recordings, "el_deg > 30")

    assert kept.line.tolist() == [5, 6, 7]
    assert [(one.line, one.reason) for one in kept.set_aside] == [(4, "not where el_deg > 30")]
    assert read(recordings.file, FileOptions(where="el_deg > 30")).line.tolist() == [5, 6, 7]


BAD = {
    "": "nothing, expected a comparison",
    "el_deg": "'el_deg' at character 1, expected a comparison",
    "el_deg >": "cannot read 'el_deg >': invalid syntax",
    "el_deg > 3 4": "cannot read 'el_deg > 3 4': invalid syntax",
    "(el_deg > 3": "'\\(' was never closed",
    "el_deg > az_deg": "'az_deg' at character 10, expected a number or text",
    "el_deg > True": "'True' at character 10, expected a number or text",
    "el_deg > -'3'": "at character 10, expected a number or text",
    "3 < el_deg": "'3' at character 1, expected the name of a column",
    "3 < el_deg < 5": "'3' at character 1, expected the name of a column",
    "el_deg > 3 > 2": "expected one comparison, and `and` before the next",
    "el_deg is 3": "expected `<`",
    "-el_deg": "'-el_deg' at character 1, expected a comparison",
    "el > 3": "have no 'el', they have az_deg",
    "time > 3": "have no 'time'",
    "and > 3": "cannot read 'and > 3': invalid syntax",
    "source in (3": "'\\(' was never closed",
    "source in [3]": "'\\[3\\]' at character 11, expected a number or text",
    "el_deg not > 3": "cannot read 'el_deg not > 3': invalid syntax",
    "el_deg > 'x'": "el_deg holds numbers",
    "time_utc > 'noon'": "no ISO 8601",
    "el_deg ** 2 > 3": "'el_deg \\*\\* 2' at character 1, expected the name of a column",
    "__import__('os') == 3": "at character 1, expected the name of a column",
    "(lambda: 0)() > 3": "'\\(lambda: 0\\)\\(\\)' at character 1, expected the name of a column",
    "not " * (DEEPEST + 2) + "el_deg > 3": f"at most {DEEPEST} levels",
    "not " * 450: "cannot read 'not not",
    "x" * 3000: "3000 characters, expected at most 2000",
}


@pytest.mark.parametrize("expression", BAD)
def test_anything_else_is_refused_with_its_place(recordings, expression):
    """One line that says what stands where."""
    with pytest.raises(BadInput, match=BAD[expression]):
        where(recordings, expression)


@given(st.text(string.printable, max_size=40))
def test_no_text_does_more_than_filter_or_be_refused(text):
    """Whatever is typed."""
    try:
        parse(text)
    except BadInput as refused:
        assert str(refused).startswith("where: ")  # noqa: PT017 - most texts are refused
