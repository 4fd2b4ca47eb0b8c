"""Answers of solvers, scores and Field System's files of another shape: one line, no traceback."""

from __future__ import annotations

import copy
import json
import subprocess
import sys

import pytest
import seeds

from pyport.errors import BadInput
from pyport.examiner.sealed.record.published import read_report
from pyport.formats.field_system import agreement
from pyport.formats.models import load
from pyport.recordings import read

REPORT = json.loads(seeds.REPORT)


def put(place, value):
    """Return the good report with something else at a place; `None` takes it away."""
    report = copy.deepcopy(REPORT)
    *way, last = place
    inner = report
    for step in way:
        inner = inner[step]
    if value is None:
        del inner[last]
    else:
        inner[last] = value
    return report


def said(path, call):
    """Return what is said of a file, which is one line that names it."""
    with pytest.raises(BadInput) as caught:
        call(path)
    assert str(caught.value).startswith(f"{path}:")
    assert len(str(caught.value).splitlines()) == 1
    return str(caught.value)


def test_a_good_report_is_read(tmp_path):
    """What is spoilt below was good."""
    path = tmp_path / "report.json"
    path.write_bytes(seeds.REPORT)

    assert read_report(path) == REPORT


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (("examined",), None, "examined is"),
        (("examined", "failed"), 3, "failed is '3', expected text"),
        (("p_value",), float("nan"), "p_value is"),
        (("findings",), {"a": 1}, "expected a list of JSON objects"),
        (("findings", 0, "effect"), ["refraction"], "expected text"),
        (("findings", 0, "class"), "refraction", "list of names"),
        (("findings", 0, "where"), None, "where is"),
        (("findings", 0, "where", "region", 0, "high"), None, "has no high"),
        (("findings", 0, "where", "region", 0, "low"), "5", "expected a number"),
        (("findings", 0, "where", "curve", 0), {"az_deg": 1}, "expected both"),
        (("findings", 0, "where", "since"), "yesterday", "ISO 8601"),
        (("findings", 0, "parameters", 0, "value"), True, "has no number"),
        (("findings", 0, "parameters", 0, "sigma"), 10**400, "expected a number"),
        (("findings", 0, "evidence", "runner_up"), 7, "expected text"),
    ],
)
def test_a_report_of_another_shape_is_refused(tmp_path, place, value, words):
    """Whatever scoring relies on is looked at first."""
    path = tmp_path / "report.json"
    path.write_text(json.dumps(put(place, value)))

    assert words in said(path, read_report)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"phi_deg,param\n90,P1\n", "the columns are not"),
        (seeds.GRID.replace(b",P7,", b",P99,"), "none of P1..P30"),
        (seeds.GRID.replace(b"60,50", b",50"), "a cell is blank"),
        (seeds.GRID.replace(b"60,50", b"x,50"), "az_deg is 'x'"),
        (b"\xff\xfe", "another encoding"),
    ],
)
def test_unit_responses_that_are_none(tmp_path, text, words):
    """A spoilt grid is refused by its own name."""
    path = tmp_path / agreement.GRID
    path.write_bytes(text)

    assert words in said(path, lambda file: list(agreement.text(file.parent)))


@pytest.mark.parametrize(
    ("section", "spoilt"), [(b"$correlation", b"1.000"), (b"$fit_data", b"0.0")]
)
def test_a_fit_that_lacks_numbers_is_refused(tmp_path, section, spoilt):
    """A number of the Field System's fit is gone, or is none."""
    whole = seeds.fit()
    start = whole.index(section)
    place = whole.index(spoilt, start)
    path = tmp_path / "night.err"
    path.with_suffix(".xtr").write_bytes(seeds.XTR)
    path.with_name(agreement.MODEL).write_bytes(seeds.CTL)

    path.write_bytes(whole)
    assert list(agreement.text(tmp_path))
    path.write_bytes(whole[:place] + b"nil" + whole[place + len(spoilt) :])
    assert "expected a number" in said(path, lambda file: list(agreement.text(file.parent)))


@pytest.mark.parametrize("call", [lambda name: load(str(name)), read])
def test_a_name_longer_than_any_file_has(call):
    """It is the name of no file, in one line."""
    with pytest.raises((BadInput, OSError)) as caught:
        call("0" * 5000)

    assert len(str(caught.value).splitlines()) == 1
    done = subprocess.run(
        [sys.executable, "-m", "pyport", "fit", "gmrt-2003-06-01", "--model", "0" * 5000],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.startswith("pyport: error: ")
    assert len(done.stderr.splitlines()) == 1
