"""One model and one file give one number: in Python, in JSON, on the page, in the diagnosis."""

import numpy as np
import pytest
from samples import sample

import pyport
from pyport.models import toml
from pyport.page import of_fit

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
    "rts2/sutherland-2016.csv",
)


@pytest.mark.parametrize("name", FILES)
def test_a_fit_says_one_number_everywhere(name, tmp_path):
    """Coefficients in Python, of fit.json, of the page, of the saved model and of the text."""
    done = pyport.fit(sample(name))
    told = {key: one.value for key, one in done.coefficients.items() if one.determined}
    report = {one["name"]: one["value"] for one in done.report["parameters"]}
    rows = {one.name: one.value for one in of_fit(done.result)[1].rows}
    done.save(tmp_path / "x.toml")
    kept = {one.name: one.value for one in pyport.load_model(tmp_path / "x.toml").values}
    in_text = {line.split()[0]: float(line.split()[1]) for line in done.summary().splitlines()[:7]}

    for key, value in told.items():
        assert report[key] == rows[key] == kept[key] == value
        assert in_text[key] == pytest.approx(value, abs=0.005)


@pytest.mark.parametrize("name", ["mmt/2023-07-02.csv", "mmt/2025-03-26.csv"])
def test_a_diagnosis_refits_what_a_fit_fits(name):
    """Before anything is found both have the same coefficients; after, page and JSON agree."""
    fitted = pyport.fit(sample(name))
    found = pyport.diagnose(sample(name))
    values = np.concatenate([one.value for one in fitted.result.coefficients])
    model = toml.tree(found.model.model)
    in_json = [row["value"] for term in model["term"] for row in term["coefficients"]]
    in_report = [
        row["value"]
        for term in found.report["completed_model"]["term"]
        for row in term["coefficients"]
    ]

    np.testing.assert_allclose(found.result.before.solution.values, values, rtol=0, atol=1e-12)
    assert in_json == in_report == [one.value for one in found.model.values]
