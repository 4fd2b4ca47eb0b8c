"""One model and one file give one number: in Python, in JSON, on the page, in the diagnosis."""

import re

import numpy as np
import pytest
from samples import sample

import pyport
from pyport.page import of_diagnosis, of_fit

FILES = (
    "auxtel/AT_point_data_20210609_tw003_corr.dat",
    "auxtel/AT_point_data_20220406_tw004_corr.dat",
    "auxtel/AT_point_file_20200315T022713.dat",
    "jcmt/harp20070702.dat",
    "mmt/2021-08-21.csv",
    "mmt/2023-07-02.csv",
    "mmt/2023-09-24.csv",
    "mmt/2025-03-26.csv",
    "mmt/k_and_e.dat",
    "meerkat/m049.csv",
)


@pytest.mark.parametrize("name", [*FILES, "rts2/sutherland-2016.csv"])
def test_a_fit_says_one_number_everywhere(name, tmp_path):
    """Coefficients in Python, of fit.json, of the page, of the saved model and of the text."""
    done = pyport.fit(sample(name))
    told = {key: one.value for key, one in done.coefficients.items() if one.determined}
    report = {one["name"]: one["value"] for one in done.report["parameters"]}
    rows = {one.name: one.value for one in of_fit(done.result)[1].rows}
    done.save(tmp_path / "x.toml")
    kept = {one.name: one.value for one in pyport.load_model(tmp_path / "x.toml").values}
    table = done.summary().partition("\n\n")[0]
    in_text = dict(re.findall(r"^(\w+) +(-?[\d.]+) \+-", table, re.MULTILINE))

    for key, value in told.items():
        assert report[key] == rows[key] == kept[key] == value
        if f"{key} larger than the data" not in " ".join(table.split()):
            assert float(in_text[key]) == pytest.approx(value, abs=0.005)


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_a_diagnosis_refits_what_a_fit_fits(name, tmp_path):
    """Before anything is found both have the same coefficients; after, all answers agree.

    Python, report.json, the page, the saved model and the terminal.
    """
    fitted = pyport.fit(sample(name))
    found = pyport.diagnose(sample(name))
    values = np.concatenate([one.value for one in fitted.result.coefficients])
    told = [(one.name, one.value) for one in found.model.values]
    in_report = [
        (row["name"], row["value"])
        for term in found.report["completed_model"]["term"]
        for row in term["coefficients"]
    ]
    named = {one.name: one for one in found.model.values if one.effect != "unknown"}
    back = {one.finding for one in found.model.model.terms if one.effect.came_back}
    lasting = {key: one for key, one in named.items() if one.finding not in back - {None}}
    rows = {one.name: one.value for one in of_diagnosis(found.result)[1].rows}
    found.model.save(tmp_path / "x.toml")
    kept = [(one.name, one.value) for one in pyport.load_model(tmp_path / "x.toml").values]
    table = found.summary().partition("enter this into the control system")[2].splitlines()[1:]
    in_text = dict(re.findall(r"^(\S.*?) {2,}(\S+)", "\n".join(table), re.MULTILINE))

    known = np.isfinite(values)
    np.testing.assert_allclose(
        found.result.before.solution.values[known], values[known], rtol=0, atol=1e-12
    )
    assert told == in_report == kept
    for key, one in named.items():
        assert rows[key] == (one.value if one.determined else None)
    for key, one in lasting.items():
        assert float(in_text[key]) == pytest.approx(one.value, abs=0.06 * (one.sigma or 1))
