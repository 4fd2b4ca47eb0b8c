"""The diagnosis as a whole: silent where nothing is missing, right where something is."""

import json

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.diagnosis.diagnose import diagnose
from pyport.formats.models import load
from pyport.report.folder import text as in_words
from pyport.report.folder import write
from pyport.report.made import report_of
from pyport.report.typed import as_json as told
from pyport.thresholds import FEWEST


def run(given, model="altaz", **options):
    """Diagnose with a built-in model."""
    return diagnose(given, load(model), **options)


@pytest.mark.slow
def test_nothing_is_claimed_where_nothing_is_hidden():
    """Of eight null sets with white noise at most one claims a finding."""
    claims = [run(recordings(300, seed)).mismatch for seed in range(8)]

    assert sum(claims) <= 1


@pytest.mark.slow
def test_refraction_that_was_left_out_is_found_with_its_constant():
    """58 arcsec of cot E behind the classical seven terms comes back as refraction."""
    found = run(recordings(600, 1, y=lambda at: 58 / np.tan(at.el)))
    first = found.findings[0]

    assert "refraction" in first.members
    assert first.where.axes == ("el",)
    assert first.heldout.after < 0.8 * first.heldout.before
    assert first.visible_rms < 0.6 * first.true_rms


@pytest.mark.slow
def test_what_is_strong_in_one_axis_hides_nothing_in_the_other():
    """A wave of the azimuth encoder of 200 arcsec, and 30 of cot E along elevation."""
    wave = lambda at: 200 * np.sin(3 * at.az) * np.cos(at.el)  # noqa: E731 - an offset
    found = run(recordings(300, 2, x=wave, y=lambda at: 30 / np.tan(at.el))).findings

    assert [one.where.axes for one in found] == [("xel",), ("el",)]
    assert found[0].effect == "azimuth_harmonics"
    assert "refraction" in found[1].members


@pytest.mark.slow
def test_a_nodding_telescope_is_named_with_its_harmonic():
    """A third harmonic of azimuth in elevation comes back with k = 3 and its size."""
    found = run(recordings(600, 2, y=lambda at: 6 * np.sin(3 * at.az)))
    first = found.findings[0]
    sine = next(p for p in first.parameters if p.name.endswith("sine"))

    assert (first.effect, first.verdict, first.variant) == ("elevation_harmonics", "named", "k = 3")
    assert abs(sine.value - 6) < 3 * sine.sigma
    assert len(found.findings) == 1


@pytest.mark.slow
def test_an_offset_that_follows_an_unknown_column_is_unknown_and_says_which():
    """Physics outside the catalogue is not given a name; the column that it follows is."""
    found = run(
        recordings(600, 3, x=lambda at: 8 * np.sign(at.column("weight_of_the_cat_kg") - 4.5))
    )
    first = found.findings[0]

    assert (first.effect, first.verdict) == ("unknown", "unknown")
    assert "weight_of_the_cat_kg" in first.looks_like
    assert first.where.axes == ("xel",)


@pytest.mark.slow
def test_what_the_model_already_fits_is_not_found_again():
    """A tilt beside a model that fits a tilt is no finding; held fixed, it is one."""
    given = recordings(500, 4)

    assert not run(given).mismatch
    held = run(given, refit=("azimuth_zero", "collimation", "skew", "elevation_zero", "sag_cosine"))
    assert "tilt" in held.findings[0].members


@pytest.mark.slow
def test_the_same_input_gives_the_same_report():
    """Same recordings and seed, same report, whatever the order of the rows."""
    given = recordings(300, 5, y=lambda at: 4 * np.sin(2 * at.az))
    shuffled = given.take(np.random.default_rng(0).permutation(len(given)))

    first, again, other = (told(report_of(run(one))) for one in (given, given, shuffled))

    assert first == again
    assert [f["effect"] for f in other["findings"]] == [f["effect"] for f in first["findings"]]
    np.testing.assert_allclose(
        other["findings"][0]["parameters"][0]["value"],
        first["findings"][0]["parameters"][0]["value"],
        rtol=1e-4,
    )


@pytest.mark.parametrize("rows", [1, 3, 4, 8, 13])
def test_too_few_recordings_are_said_so(rows):
    """No finding, no refusal: how many would be needed, and what would have been seen if any."""
    done = run(recordings(40, 6).take(np.arange(rows)))
    said = told(report_of(done))["verdict"]

    assert not done.mismatch
    assert f"nothing can be said from {rows} pointing" in said
    assert "27 numbers are needed" in said or "fitted coefficients" in said
    assert ("would have been seen" in said) == (2 * rows >= 7 + FEWEST)
    assert bool(done.detection_limits) == (2 * rows >= 7 + FEWEST)


def test_enough_recordings_are_searched():
    """Fourteen pointings leave twenty-one numbers beyond seven terms: one is enough to look."""
    assert run(recordings(40, 6).take(np.arange(14))).too_few is None


def test_the_report_has_every_field_of_the_contract(tmp_path):
    """Names and types of report.json are the ones that others build on; NaN never gets in."""
    found = run(recordings(400, 7, y=lambda at: 6 * np.sin(3 * at.az)))
    write(found, tmp_path)
    report = json.loads((tmp_path / "report.json").read_text())

    assert report["schema"] == "pyport.diagnosis/1"
    assert set(report) >= {
        *("input", "model", "noise", "mismatch", "p_value", "detection_limit_arcsec"),
        *("findings", "fit", "correlation", "condition_number"),
    }
    assert set(report["input"]) >= {"file", "sha256", "rows", "used", "set_aside"}
    assert set(report["noise"]) >= {"xel_arcsec", "el_arcsec", "correlation_time_s", "how"}
    assert report["noise"]["how"] in {"replicates", "neighbours", "reml"}
    finding = report["findings"][0]
    assert set(finding) >= {
        *("effect", "class", "verdict", "sentence", "where", "parameters", "evidence"),
        *("visible_rms_arcsec", "true_rms_arcsec", "heldout", "looks_like", "decide_by"),
    }
    assert set(finding["where"]) >= {"axes", "subset", "region", "curve", "since"}
    assert set(finding["parameters"][0]) == {"name", "value", "sigma", "unit", "expected"}
    assert set(finding["evidence"]) == {
        *("p_value", "delta_bic", "runner_up", "runner_up_delta_bic"),
    }
    assert set(finding["heldout"]) >= {
        *("scheme", "rms_before_arcsec", "rms_after_arcsec", "noise_floor_arcsec"),
    }
    names, matrix = report["correlation"]["names"], report["correlation"]["matrix"]
    np.testing.assert_allclose(np.diag(matrix), 1)
    assert len(names) == len(matrix)
    rows = (tmp_path / "rows.csv").read_text().splitlines()
    assert len(rows) == 1 + 2 * 400


def test_the_summary_says_what_would_have_been_seen():
    """A clean bill names the size of the effects that would have shown."""
    text = in_words(report_of(run(recordings(300, 0))))

    assert "Nothing is missing" in text
    assert "Would have been seen" in text
