"""A tilt that is not the same in both axes: found, put in its place, and said."""

from types import SimpleNamespace

import numpy as np
from diagnosis.made import recordings

from pyport.diagnosis.diagnose import diagnose
from pyport.diagnosis.naming import words
from pyport.fitting import soundness
from pyport.fitting.fit import fit
from pyport.formats.models import load
from pyport.mounts import ALTAZ
from pyport.report.folder import text as in_words
from pyport.report.made import report_of
from pyport.report.typed import as_json as told


def _eccentric(at):
    """Return what an azimuth encoder off its centre adds across elevation [arcsec]."""
    return 12 * np.sin(at.az) * np.cos(at.el)


def test_named_by_the_search_the_cause_settles_it():
    """Once the search has named the eccentricity both axes have one tilt."""
    found = diagnose(recordings(160, 3, noise_arcsec=4.0, x=_eccentric), load("altaz"))

    assert "azimuth_eccentricity" in [one.effect for one in found.findings]
    assert found.two_axes == ()


def test_a_wave_in_one_axis_alone_is_reported_with_its_place_and_its_cause():
    """Beside the bare model the tilt differs, across elevation, and an eccentricity settles it."""
    from pyport.diagnosis.disagreements import disagreements
    from pyport.diagnosis.preparing import prepare
    from pyport.diagnosis.weighing import weigh

    problem = prepare(recordings(200, 4, noise_arcsec=2.0, x=_eccentric), load("altaz"))
    (one,) = disagreements(problem, weigh(problem), ())
    said = words.two_axes_sentence(one)

    assert one.chosen.candidate.effect.id == "tilt"
    assert one.found.sigmas > 5
    assert "It lies in cross-elevation" in said
    assert "azimuth_eccentricity" in [name for name, _ in one.causes]
    assert words.two_axes_json(one, ALTAZ.names)["parameters"][0]["name"] == "tilt_north"


def test_a_tilt_of_the_mount_is_passed_over():
    """Where both axes have the same tilt nothing is said, in the report and in the fit."""
    data = recordings(160, 5)
    found = diagnose(data, load("altaz"))

    assert told(report_of(found))["two_axes"] == []
    assert "differ by" not in in_words(report_of(found))
    assert not any("differ by" in one for one in soundness.warnings(fit(data, load("altaz"))))


def test_a_fit_warns_of_axes_that_disagree():
    """The fit says so too."""
    data = recordings(200, 4, noise_arcsec=2.0, x=_eccentric)

    assert any("no tilt does that" in one for one in soundness.warnings(fit(data, load("altaz"))))


def test_one_axis_alone_is_compared_with_nothing():
    """Recordings of elevation alone have no second axis."""
    from dataclasses import replace

    data = recordings(120, 6)
    found = diagnose(replace(data, x=np.full(len(data), np.nan)), load("altaz"))

    assert found.two_axes == ()


def test_a_coefficient_of_one_axis_is_compared_with_nothing(monkeypatch):
    """Readings whose axes are correlated show a step in one axis in no other."""
    from pyport.diagnosis import disagreements
    from pyport.diagnosis.case import Chosen
    from pyport.diagnosis.preparing import prepare
    from pyport.diagnosis.weighing import weigh

    monkeypatch.setattr(disagreements, "UNLIKELY", 1e9)
    both = 5 * np.random.default_rng(1).normal(size=200)
    moved = both + 40 * (np.arange(200) >= 100)
    time, night = 1.2e9 + 300.0 * np.arange(200), np.full(200, "night")
    data = recordings(200, 1, 1.5, lambda _: moved, lambda _: both, time=time, session=night)
    problem = prepare(data, load("altaz"))
    step = next(one for one in problem.candidates if one.effect.id == "epoch_offset")
    chosen = (Chosen(step, "all"),)
    weighed = weigh(problem, chosen)

    assert weighed.covariance.coupling[""] > 0.5
    told = disagreements.disagreements(problem, weighed, chosen)
    assert [one.chosen.candidate.effect.id for one in told] == ["tilt"]


def test_no_half_is_compared_with_nothing():
    """The halves that were compared are named, and where there is none that is said."""
    from pyport.diagnosis.disagreements import Half, Halves
    from pyport.diagnosis.naming.words import _place

    lower, upper = Half("below 45 deg", None), Half("above 45 deg", None)
    alike = SimpleNamespace(sigmas=0.4)

    assert "can be compared" in _place((Halves((lower, upper), None, None),), "tilt", ("x", "y"))
    told = _place((Halves((lower, upper), alike, None),), "tilt", ("x", "y"))
    assert told == "Each axis by itself says the same below 45 deg and above 45 deg."
