"""What is said: combinations where no coefficient is known alone, sizes, and nothing too large."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.made import recordings
from diagnosis.test_verdict import finding

from pyport.angles import ARCSEC
from pyport.diagnosis.diagnose import diagnose
from pyport.diagnosis.naming import findings, words
from pyport.diagnosis.naming.finding import Parameter, Where, beyond
from pyport.diagnosis.naming.scene import centred
from pyport.effects import CATALOGUE
from pyport.effects.empirical.oscillations import OSCILLATION
from pyport.formats.models import load
from pyport.mounts import KINDS
from pyport.report.finding import finding_of
from pyport.report.folder import text as in_words
from pyport.report.made import report_of
from pyport.report.typed import as_json as told


@pytest.mark.parametrize(
    ("visible", "true", "said"),
    [
        (
            1.99,
            330,
            'adds 1.99" rms to the residuals (330" before the fitted terms absorb the rest)',
        ),
        (12.8, 12.9, 'adds 12.8" rms to the residuals'),
        # Larger than the largest offset of the data: no such number is stated.
        (1.99, 1960, 'adds 1.99" rms to the residuals'),
    ],
)
def test_sizes_are_what_is_added_to_the_residuals(visible, true, said):
    """First what is left, then what was there before the model absorbed its share."""
    one = replace(
        finding(), visible_rms=visible * ARCSEC, true_rms=true * ARCSEC, largest=962 * ARCSEC
    )

    assert one.size == said
    told = finding_of(one).true_rms_arcsec
    assert told is None if true > 962 else told == pytest.approx(true)


def test_a_wave_is_said_to_be_along_the_axes_of_its_mount():
    """The sentence says declination where the coefficient is called `amplitude_el`."""
    swing = [Parameter("amplitude_el", 8.0, 0.5, "arcsec")]
    where, names = Where(("el",)), KINDS["equatorial"].names

    said = words.sentence(CATALOGUE[OSCILLATION], swing, where, names=names)

    assert "(seen in declination), amplitude in declination 8.00 +- 0.50 arcsec:" in said


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("wind_tilt", 19.7, "downwind that grows as the square of the wind (seen in elevation)"),
        ("wind_tilt", -19.7, "square of the wind, with the opposite sign (seen in elevation)"),
        ("wind_tilt", -0.7, "downwind that grows as the square of the wind (seen in elevation)"),
        ("wind_tilt", -19.7, "its direction may be where it blows to, not where it is from"),
        ("thermal_tilt", -9.0, "an offset, or the Sun's direction, may have the wrong sign"),
        ("servo_lag_azimuth", -9.0, "the azimuth drive runs ahead of the moving sky"),
        ("servo_lag_azimuth", 9.0, "the azimuth drive lags behind the moving sky"),
        ("refraction", -25.0, "more refraction was taken off than there is"),
        ("skew", -25.0, "the elevation axis is not perpendicular to the azimuth axis"),
    ],
)
def test_a_size_of_the_wrong_sign_is_said_to_be_so(name, value, said):
    """Beyond two sigmas; where either sign is possible nothing is said."""
    size = [Parameter(name, value, 0.4, "arcsec")]

    assert said in words.sentence(CATALOGUE[name], size, Where(("el",)))


def test_a_finding_of_too_many_names_lists_them():
    """No effect explains it where none fits, not where more than six do."""
    many = SimpleNamespace(members=("skew", "tilt", "refraction"))

    assert words.nameless(CATALOGUE["skew"], many, few=False) == (
        "something is left that 3 effects draw alike: skew, tilt, refraction"
    )
    assert "no effect of the catalogue" in words.nameless(CATALOGUE["skew"], many, few=True)
    shape = replace(CATALOGUE["skew"], physical=False)
    assert "no effect of the catalogue" in words.nameless(shape, many, few=False)


def test_a_parameter_beyond_the_data_is_known():
    """Angles and their errors are compared with the largest offset, other units are not."""
    assert beyond(Parameter("a", 50.0, 1.0, "arcsec"), 40 * ARCSEC)
    assert beyond(Parameter("a", 5.0, 100.0, "arcsec"), 40 * ARCSEC)
    assert not beyond(Parameter("a", 30.0, 1.0, "arcsec"), 40 * ARCSEC)
    assert not beyond(Parameter("a", 50.0, 1.0, "s"), 40 * ARCSEC)


def test_a_finding_of_an_array_without_a_significant_part_is_reported_as_it_was_fitted(monkeypatch):
    """No finding of the search is lost on the way to the reader."""
    chosen = SimpleNamespace(scope="antenna")
    outcome = SimpleNamespace(chosen=(chosen,), step_of=lambda _: None)
    scene = SimpleNamespace(problem=SimpleNamespace(base=()), outcome=outcome)
    monkeypatch.setattr(findings, "taken_apart", lambda *_: SimpleNamespace())
    monkeypatch.setattr(findings, "of_array", lambda *_: [])
    monkeypatch.setattr(findings, "_single", lambda *_: finding())
    monkeypatch.setattr(findings, "honest", lambda *found: found[-1])

    assert [one.effect for one in findings.collect(scene)] == [finding().effect]


def test_the_model_has_its_own_combinations():
    """In a band of elevation zero, collimation and skew are one thing: terminal and report."""
    made = recordings(600, 4)
    done = diagnose(made.take((made.at.el > 0.7) & (made.at.el < 0.8)), load("altaz"))
    together = told(report_of(done))["combinations"]
    said = " ".join(in_words(report_of(done)).split())

    assert ["azimuth_zero", "collimation", "skew"] in [one["coefficients"] for one in together]
    assert "azimuth zero, collimation and skew are known in combination only" in said


@pytest.mark.slow
def test_a_mean_is_no_size():
    """A curve's size is that about its mean in each axis: a zero takes the mean."""
    done = diagnose(recordings(60, 4), load("none"))
    scene = type("Scene", (), {"problem": done.problem, "share": done.share})
    curve = 7.0 + 3.0 * done.problem.stack.is_y + np.sin(np.arange(len(done.share)))

    for is_y in (False, True):
        rows = done.problem.stack.is_y == is_y
        left = centred(scene, curve)[rows]
        assert np.average(left, weights=done.share[rows]) == pytest.approx(0, abs=1e-12)
        assert np.std(left) == pytest.approx(np.std(curve[rows]))
