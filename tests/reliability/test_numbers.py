"""No NaN and no infinity reaches anything that is written; a fit says when it is not sound."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pyport.angles import ARCSEC
from pyport.diagnosis.diagnose import diagnose
from pyport.effects import Circumstances, Site
from pyport.errors import BadInput
from pyport.fitting import soundness, table
from pyport.fitting.fit import fit
from pyport.fitting.fit import write_rows as write_residuals
from pyport.fitting.soundness import doubts, positive
from pyport.formats.models import load
from pyport.page import of_diagnosis
from pyport.page.document import html
from pyport.recordings.schema import Recordings
from pyport.report.folder import text as in_words
from pyport.report.folder import write_rows
from pyport.report.made import report_of
from pyport.report.typed import as_json as told
from pyport.studies.rt32 import METHODS, fit_rt32
from pyport.studies.rt32 import document as rt32_table

#: As programs write what is no number, standing alone.
NO_NUMBER = re.compile(r"(?<![A-Za-z_])[-+]?(nan|inf|infinity)(?![A-Za-z_])", re.IGNORECASE)
#: Where in the sky: all over it, along one elevation, in one place, at the zenith and horizon.
SKIES = ("all", "ring", "place", "edges")


@st.composite
def odd_nights(draw):
    """Draw recordings as nobody wants them."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    n = draw(st.sampled_from([13, 20, 60]))
    az, el = rng.uniform(0, 2 * np.pi, n), rng.uniform(0.1, 1.5, n)
    sky = draw(st.sampled_from(SKIES))
    if sky == "ring":
        el[:] = 0.8
    elif sky == "place":
        az[:], el[:] = 1.0, 0.8
    elif sky == "edges":
        el[: n // 2], el[n // 2 :] = np.pi / 2, 0.0
    size = draw(st.sampled_from([0.0, 1e-6, 10.0, 1e5]))
    x, y = size * ARCSEC * rng.standard_normal((2, n))
    x[rng.random(n) < draw(st.sampled_from([0, 0.5, 1]))] = np.nan
    y[rng.random(n) < draw(st.sampled_from([0, 0.3]))] = np.nan
    y[np.isnan(x) & np.isnan(y)] = 0.0
    time = 1.2e9 + draw(st.sampled_from([0.0, 1.0, 1e5])) * np.arange(n)
    columns = {
        "time": time,
        "session": np.array(["a", "b"])[(np.arange(n) > draw(st.sampled_from([0, 5, n]))) * 1],
        "temperature_c": np.where(rng.random(n) < 0.2, np.nan, rng.normal(0, 9, n)),
        "humidity_pct": np.full(n, draw(st.sampled_from([50.0, np.nan]))),
        "odd": rng.choice([0.0, 1e300, 1e-300], n),
    }
    kept = draw(st.sets(st.sampled_from(sorted(columns))))
    known = {name: columns[name] for name in kept}
    at = Circumstances(az, el, Site(0.9, 0.3), known)
    nothing = np.full(n, np.nan)
    return Recordings(at, x, y, nothing, nothing, np.arange(n) + 2, Path("odd.csv"))


def written(what):
    """Return what a program finds in JSON, and fail where JSON has no word for it."""
    return json.dumps(what, allow_nan=False)


@pytest.mark.filterwarnings("error::RuntimeWarning")
@settings(max_examples=12, suppress_health_check=list(HealthCheck))
@given(odd_nights())
def test_no_nan_in_a_diagnosis(night):
    """Refused, or told in numbers: on the terminal, in the report, in rows.csv and on the page."""
    try:
        done = diagnose(night, load("altaz"))
    except BadInput:
        return
    rows = io.StringIO()
    write_rows(done, rows)
    page = re.sub(r"<(script|style).*?</\1>", "", html(*of_diagnosis(done)), flags=re.DOTALL)
    report = told(report_of(done))
    for text in (in_words(report_of(done)), rows.getvalue(), written(report), page):
        assert not NO_NUMBER.search(text), NO_NUMBER.search(text)
    for finding in report["findings"]:
        for one in finding["parameters"]:
            assert None not in (one["value"], one["sigma"])
        assert finding["visible_rms_arcsec"] is not None


@pytest.mark.filterwarnings("error::RuntimeWarning")
@settings(max_examples=60, suppress_health_check=list(HealthCheck))
@given(odd_nights(), st.sampled_from(["altaz", "rt32-approximate"]))
def test_no_nan_in_a_fit(night, model):
    """Refused, or every number that is told is one, and what is not determined is said."""
    try:
        done = fit(night, load(model))
    except BadInput:
        return
    rows = io.StringIO()
    write_residuals(done, rows)
    for text in (table.text(done), rows.getvalue(), written(table.as_json(done))):
        assert not NO_NUMBER.search(text), text
    open_ones = [one for one in done.coefficients if not np.isfinite(one.value).all()]
    said = [one for one in soundness.warnings(done) if one.startswith("not determined")]
    assert bool(said) == bool(open_ones)


@pytest.mark.filterwarnings("error::RuntimeWarning")
@settings(max_examples=25, suppress_health_check=list(HealthCheck))
@given(odd_nights(), st.sampled_from(sorted(METHODS)))
def test_no_nan_in_the_rt32_fit(night, method):
    """The same of the RT32's own fit by any of its methods."""
    try:
        done = fit_rt32(night, method=method)
    except BadInput:
        return
    none = np.full(len(done.values), np.nan)
    for text in (
        rt32_table.text(done, none),
        rt32_table.correlations(done),
        written(rt32_table.as_json(done, none)),
    ):
        assert not NO_NUMBER.search(text), text


def made(directions, seed=0, noise_arcsec=5.0):
    """Return recordings of a few directions, altaz with noise."""
    rng = np.random.default_rng(seed)
    az, el = directions
    at = Circumstances(np.asarray(az, float), np.asarray(el, float))
    x, y = noise_arcsec * ARCSEC * rng.standard_normal((2, len(at))) + 30 * ARCSEC * np.cos(at.el)
    nothing = np.full(len(at), np.nan)
    return Recordings(at, x, y, nothing, nothing, np.arange(len(at)) + 2, Path("made.csv"))


def spread(n):
    """Return n directions over the sky."""
    rng = np.random.default_rng(1)
    return rng.uniform(0, 6.28, n), rng.uniform(0.05, 1.52, n)


def says(night, model="altaz"):
    """Return what a fit says of itself, the same in words and in JSON."""
    done = fit(night, load(model))
    report = table.as_json(done)["warnings"]
    assert all(f"warning: {one}" in table.text(done) for one in report)
    return " / ".join(report)


def test_a_fit_says_what_is_wrong_with_it():
    """Ill-conditioned, undetermined, no number to spare; a sound one says none of it."""
    doubtful = ("condition number", "not determined", "to spare", "goes through", "converge")
    assert not any(word in says(made(spread(200))) for word in doubtful)
    narrow = spread(200)[0], np.random.default_rng(2).uniform(0.7, 0.75, 200)
    assert "the condition number" in says(made(narrow))
    assert "not determined" in says(made((spread(200)[0], np.full(200, 0.7))))
    seven = [one[:4] for one in spread(200)]
    night = made(seven)
    night.x[0] = np.nan
    assert "the curve goes through all of them" in says(night)
    with pytest.raises(BadInput, match="6 measured offsets cannot determine 7 coefficients"):
        fit(made([one[:3] for one in seven]), load("altaz"))


def test_the_rt32_fit_and_a_diagnosis_say_it_too():
    """The RT32's table and JSON, the report and the terminal."""
    rng = np.random.default_rng(2)
    narrow = made((spread(200)[0], rng.uniform(0.7, 0.75, 200)))
    rt32 = fit_rt32(narrow)
    none = np.full(len(rt32.values), np.nan)
    done = diagnose(narrow, load("altaz"))
    report = told(report_of(done))["warnings"]

    assert any("condition number" in one for one in rt32_table.as_json(rt32, none)["warnings"])
    assert "warning: the condition number" in rt32_table.text(rt32, none)
    assert "fit of the model: the condition number" in report[0]
    assert "Warning: fit of the model: the condition number" in in_words(report_of(done))
    assert told(report_of(diagnose(made(spread(200)), load("altaz"))))["warnings"] == []


@given(st.integers(1, 6), st.integers(0, 2**32))
def test_a_covariance_is_positive_and_what_is_none_is_not(size, seed):
    """Any C C' is, whatever its scale; with a negative direction, or a NaN, it is not."""
    rng = np.random.default_rng(seed)
    scale = 10.0 ** rng.uniform(-12, 3, size)
    root = rng.normal(size=(size, size + 2)) * scale[:, None]
    good = root @ root.T
    assert positive(good)
    values, vectors = np.linalg.eigh(good / np.outer(scale, scale))
    bad = (vectors * np.where(np.arange(size) == 0, -values[-1] / 2, values)) @ vectors.T
    assert not positive(bad * np.outer(scale, scale))
    assert not positive(np.where(np.eye(size, dtype=bool), np.nan, good))
    told = list(doubts(condition=2, covariance=bad, numbers=9, rank=size))
    assert told == ["the covariance is not positive: some errors and correlations mean nothing"]
