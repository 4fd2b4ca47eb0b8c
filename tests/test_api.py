"""pyport in Python: tables of every kind give the same answer, which draws itself; the tutorial."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow
import pytest
from astropy import units
from astropy.table import Table
from click.testing import CliRunner

import pyport
from pyport.angles import ARCSEC
from pyport.cli.explain import diagnose
from pyport.cli.fit import command as fit
from pyport.correction.use import model_of
from pyport.errors import BadInput
from pyport.pointing import kernel
from pyport.recordings import read
from pyport.recordings.from_table import from_table

DOCS = Path(__file__).parent.parent / "docs"
SITE = {"latitude_deg": 53.1}


@pytest.fixture(scope="module")
def night():
    """Return columns of a small night in which refraction was forgotten."""
    rng = np.random.default_rng(4)
    n = 120
    el = np.arcsin(rng.uniform(0.2, 0.98, n))
    return {
        "az_deg": rng.uniform(0, 360, n),
        "el_deg": np.degrees(el),
        "d_xel_arcsec": rng.normal(0, 5, n),
        "d_el_arcsec": rng.normal(0, 5, n) + 58 / np.tan(el),
        "time_utc": np.datetime64("2026-03-01T18:00") + np.arange(n) * np.timedelta64(200, "s"),
        "source": np.array([f"s{k % 5}" for k in range(n)]),
    }


@pytest.fixture(scope="module")
def found(night):
    """Return its diagnosis."""
    return pyport.diagnose(night, header=SITE)


@pytest.mark.parametrize("kind", [dict, pd.DataFrame, pyarrow.table, Table])
def test_every_kind_of_table_holds_the_same_recordings(night, kind):
    """A dictionary, a data frame, an Arrow and an astropy table are read alike."""
    one, other = from_table(night, SITE), from_table(kind(night), SITE)

    np.testing.assert_array_equal(one.at.az, other.at.az)
    np.testing.assert_array_equal(one.y, other.y)
    np.testing.assert_array_equal(one.at.column("time"), other.at.column("time"))
    np.testing.assert_array_equal(one.at.column("source"), other.at.column("source"))
    assert one.at.site == other.at.site


def test_units_beside_a_column_and_masked_cells_count(night):
    """Astropy's units name what the column's name leaves out; a masked offset is blank."""
    table = Table(night, masked=True)
    table.rename_column("d_el_arcsec", "d_el")
    table["d_el"].unit = units.arcsec
    table["d_el"].mask[3] = True
    read_back = from_table(table, SITE)

    assert np.flatnonzero(np.isnan(read_back.y)).tolist() == [3]
    np.testing.assert_array_equal(np.delete(read_back.y, 3), np.delete(from_table(night).y, 3))


def test_blank_text_and_times_with_a_zone(night):
    """None, NaN and NaT are blank; times that know their zone are taken to UTC."""
    frame = pd.DataFrame(night)
    frame["time_utc"] = frame["time_utc"].dt.tz_localize("Europe/Warsaw")
    frame.loc[0, "source"] = None
    frame.loc[1, "time_utc"] = pd.NaT
    read_back = from_table(frame)

    assert read_back.at.column("source")[0] == ""
    assert np.isnan(read_back.at.column("time")[1])
    assert from_table(night).at.column("time")[2] - read_back.at.column("time")[2] == 3600


def test_a_bad_table_is_told_with_its_row(night):
    """Rows count from 1, and the message says what was expected."""
    wrong = dict(night, el_deg=np.where(np.arange(120) == 6, 400.0, night["el_deg"]))

    with pytest.raises(BadInput, match=r"table:7: elevation outside"):
        pyport.diagnose(wrong)
    with pytest.raises(BadInput, match="has no effect 'nothing'"):
        pyport.diagnose(night, refit=["nothing"])


def test_a_diagnosis_says_itself_and_draws_itself(found):
    """At a prompt it is the text of the command, in a notebook the page in a frame."""
    shown = found._repr_html_()

    assert "refraction" in found.findings[0].members
    assert repr(found) == found.summary()
    assert found.report["mismatch"] is found.mismatch is True
    assert shown.startswith("<div><p><b>altaz leaves out")
    assert 'sandbox="allow-scripts allow-downloads"' in shown
    assert "<script>" not in shown.partition("srcdoc=")[0]


def test_a_diagnosis_is_saved_and_plotted(found, tmp_path):
    """The folder holds what the command writes; panels are figures."""
    names = {path.name for path in found.save(tmp_path / "here").iterdir()}

    assert names == {"report.html", "report.json", "rows.csv"}
    report = json.loads((tmp_path / "here" / "report.json").read_text())
    assert set(report.pop("files")) == names - {"report.json"}
    assert report.pop("computed_with") == kernel.path()
    assert report == found.report
    assert len(found.plot("sky").axes) == 2
    assert "against-source" in found.panels()


def test_a_file_gives_what_its_columns_give(night, tmp_path):
    """The answer does not depend on whether the table came from a file."""
    path = tmp_path / "night.csv"
    pd.DataFrame(night).to_csv(path, index=False, float_format="%.17g")
    one = pyport.fit(path, header=SITE).report["parameters"]
    other = pyport.fit(night, header=SITE).report["parameters"]
    values = [[row["value"] for row in rows] for rows in (one, other)]

    np.testing.assert_allclose(*values, rtol=1e-9, atol=1e-9)
    assert len(read(path)) == 120


def test_what_a_model_left_while_it_was_in_use_is_fitted_as_if_it_had_not_been(night, tmp_path):
    """From Python and from the command line: values to enter, not changes of them."""
    file = tmp_path / "in-use.mod"
    file.write_text("altaz in use\nT 0 1.0 0.0 0.0\nIA 300\nIE -200\nTF 40\nEND\n")
    model = pyport.load_model(file)
    raw = from_table(night, SITE)
    x, y = model_of(model).offsets(raw.at)
    left = dict(
        night,
        d_xel_arcsec=night["d_xel_arcsec"] - x / ARCSEC,
        d_el_arcsec=night["d_el_arcsec"] - y / ARCSEC,
    )
    wanted, found = (
        list(pyport.fit(table, model, in_use=used, header=SITE).coefficients.values())
        for table, used in ((night, False), (left, True))
    )
    pd.DataFrame(left).to_csv(tmp_path / "left.csv", index=False)
    arguments = [str(tmp_path / "left.csv"), "--model", str(file), "--in-use", "--json"]
    told = CliRunner().invoke(fit, arguments)
    diagnosed = pyport.diagnose(left, model, in_use=True, header=SITE)
    CliRunner().invoke(
        diagnose, [*arguments[:-1], "--out", str(tmp_path), "--set", "latitude_deg=53"]
    )
    again = json.loads((tmp_path / "left" / "report.json").read_text())

    values = [one.value for one in wanted]
    assert [one.value for one in found] == pytest.approx(values, abs=1e-3)
    assert [one["value"] for one in json.loads(told.output)["parameters"]] == pytest.approx(
        values, abs=1e-3
    )
    assert diagnosed.report["misread"] is None
    assert "refraction" in diagnosed.findings[0].members
    assert again["findings"][0]["class"] == list(diagnosed.findings[0].members)


def test_a_look_is_words_and_a_report(night):
    """What `pyport look` prints."""
    seen = pyport.look(night, header=SITE, count=2)

    assert "To observe next" in repr(seen)
    assert len(seen.report["next"]) == 2


@pytest.mark.parametrize(
    "elevations", [[3 * units.m, 4 * units.m], [10.0], "10", np.float64(3), [80.0, 10.0]]
)
def test_elevations_are_two_numbers_in_degrees(night, elevations):
    """The lower one first."""
    with pytest.raises(BadInput, match="elevations"):
        pyport.look(night, header=SITE, elevations=elevations)


@pytest.mark.parametrize("noise", [1e-300, 1e300])
def test_a_noise_that_no_instrument_has_is_refused(night, noise):
    """Before it is divided by."""
    with pytest.raises(BadInput, match=r"arcsec, expected between 1e-09 and 1e\+09"):
        pyport.look(night, header=SITE, noise_arcsec=noise)


def test_names_are_there_before_they_are_imported():
    """`dir` lists them, a wrong name is an AttributeError, nothing heavy is imported."""
    code = (
        "import sys, pyport; assert {'diagnose', 'fit', 'look'} <= set(dir(pyport));"
        "print('numpy' in sys.modules, hasattr(pyport, 'nothing'))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stdout.split() == ["False", "False"]


@pytest.mark.slow
def test_the_tutorial_runs():
    """Every cell of the notebook runs; what it promises in words comes out."""
    import nbformat
    from nbclient import NotebookClient

    book = nbformat.read(DOCS / "tutorial.ipynb", as_version=4)
    assert all(not cell.outputs for cell in book.cells if cell.cell_type == "code")
    NotebookClient(book, timeout=120, kernel_name="python3").execute()
    said = [
        out.get("text", "") + "".join(out.get("data", {}).get("text/plain", ""))
        for cell in book.cells
        if cell.cell_type == "code"
        for out in cell.outputs
    ]

    assert any("refraction" in text and "named" in text for text in said)
    assert any("Nothing is missing" in text for text in said)
    assert any("scan_direction, named" in text for text in said)
