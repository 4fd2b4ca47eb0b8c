"""Names that the recordings cannot carry are not spoken; those that do not come back are marked."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.made import recordings
from hypothesis import given
from hypothesis import strategies as st

from pyport.diagnosis import joint
from pyport.diagnosis.diagnose import diagnose
from pyport.diagnosis.naming import scene as scenes
from pyport.diagnosis.naming.finding import Stability
from pyport.diagnosis.naming.guards import carriers
from pyport.diagnosis.naming.noise_remarks import noise_remarks
from pyport.diagnosis.naming.remarks import warnings
from pyport.diagnosis.naming.verdict import DRAWS, judged, stability
from pyport.diagnosis.searching.search import search
from pyport.formats.models import load
from pyport.page import of_diagnosis
from pyport.report.finding import finding_of
from pyport.report.folder import text as in_words
from pyport.report.made import report_of
from pyport.report.typed import as_json
from pyport.thresholds import CARRIERS

NIGHT_S = 1.2e9 + np.sort(np.random.default_rng(1).uniform(0, 8 * 3600, 300))
WEEK_S = NIGHT_S + 86400 * (np.arange(300) % 6)


def celsius(time_s):
    """Return a temperature that falls through each night, each from another height."""
    return 9 - 5 * ((time_s - 1.2e9) % 86400 / 28800 - 0.5) + 3 * ((time_s - 1.2e9) // 86400)


def told(time_s, x=None, y=None, session=None, temperature=None, **more):
    """Diagnose 300 pointings of a night or a week."""
    session = np.full(300, "one") if session is None else session
    warm = celsius(time_s) if temperature is None else temperature
    made = recordings(300, 2, x=x, y=y, time=time_s, session=session, temperature_c=warm, **more)
    return diagnose(made, load("altaz"))


def follows_temperature(at):
    """Return 6 arcsec a degree."""
    return 6 * (at.column("temperature_c") - 9)


def drifts(at):
    """Return 15 arcsec from one end of the recordings to the other, in elevation."""
    time = at.column("time")
    return 15 * (time - time.mean()) / np.ptp(time)


def jumps(at):
    """Return 90 arcsec from half way on."""
    return 90 * (at.column("time") > np.median(at.column("time")))


@pytest.mark.parametrize(
    ("hidden", "names", "reason"),
    [
        (follows_temperature, {"temperature", "driven_term", "drift"}, ""),
        (drifts, {"temperature", "driven_term", "drift"}, ""),
        (jumps, {"epoch_offset"}, "when something moved and by how much, but not what"),
    ],
)
def test_one_night_carries_no_name_that_needs_more(hidden, names, reason):
    """What goes with the hour, or changes once, is not named after one night; after more it is."""
    alone = told(NIGHT_S, y=hidden).findings
    several = told(WEEK_S, y=hidden).findings

    assert not names & {name for one in alone for name in one.members}
    # A slow curve is no more than a drift can do; a jump is, and is refused its name.
    assert bool(alone) == (hidden is jumps)
    assert all(reason in one.sentence and one.verdict == "unknown" for one in alone)
    assert all("second" in one.decide_by for one in alone)
    assert names & {name for one in several for name in one.members}


def test_gusts_are_told_from_the_hour_within_one_night():
    """What does not go with the hour may be named after one night."""
    rng = np.random.default_rng(8)
    found = told(NIGHT_S, y=follows_temperature, temperature=rng.normal(9, 3, 300)).findings

    assert found[0].effect == "temperature"
    assert found[0].stability.stable


def test_too_few_numbers_carry_no_name():
    """A strong effect in fourteen pointings is not named, in twelve it is not looked for."""
    refraction = lambda at: 300 / np.tan(at.el)  # noqa: E731 - as short as it says
    none = diagnose(recordings(12, 3, y=refraction, noise_arcsec=1), load("altaz"))
    few = diagnose(recordings(14, 3, y=refraction, noise_arcsec=1), load("altaz")).findings
    more = diagnose(recordings(60, 3, y=refraction, noise_arcsec=1), load("altaz")).findings

    assert not none.mismatch
    assert "24 measured numbers" in in_words(report_of(none))
    assert {one.verdict for one in few} <= {"unknown"}
    assert "refraction" in more[0].members


@given(st.integers(1, 40), st.integers(1, 3), st.floats(1e-9, 1e9))
def test_equal_shares_are_counted(pointings, readings, size):
    """So many pointings of one size carry a curve as there are, however often they are told."""
    place = np.repeat(np.arange(pointings + 3), readings)
    seen = np.where(place < pointings, size, 0.0)
    scene = SimpleNamespace(
        weighed=SimpleNamespace(used=np.ones(len(place), bool)),
        floor=np.ones(len(place)),
        problem=SimpleNamespace(pointing=place),
    )

    assert carriers(scene, seen) == pytest.approx(pointings)
    seen[place == 0] *= 1e6
    assert carriers(scene, seen) < CARRIERS


def test_a_name_in_noise_does_not_come_back():
    """Chosen though nothing is hidden, it is the best in few draws and is called unstable."""
    problem = diagnose(recordings(300, 5), load("altaz")).problem
    nothing = search(problem)
    rich = search(
        diagnose(recordings(300, 5, y=lambda at: 30 / np.tan(at.el)), load("altaz")).problem
    )
    kept = {}
    for name, outcome, effect in (("noise", nothing, "sag_sine"), ("there", rich, "refraction")):
        if outcome.steps:
            step, chosen = outcome.steps[0], outcome.chosen
        else:
            beside = outcome.weighed.evidence.beside([problem.part(one) for one in problem.base])
            winner = next(one for one in outcome.last if one.candidate.effect.id == effect)
            chosen = (scenes.Chosen(winner.candidate, winner.scope),)
            step = scenes.Step(winner, chosen[0], outcome.last, beside, 1.0)
        fit = joint.fit(outcome.problem, outcome.weighed, chosen)
        scene = scenes.scene(outcome.problem, outcome, fit)
        kept[name] = stability(scene, len(outcome.problem.base), step, (effect,))

    assert kept["there"].stable
    assert not kept["noise"].stable
    assert kept["noise"].draws == DRAWS


def test_what_does_not_come_back_is_said():
    """The terminal and the report tell it of an unstable name, and of no other."""
    done = told(WEEK_S, y=follows_temperature)
    shaky = Stability("blocks of time", 40, 17, {"drift": 23})
    words = "resampling blocks of time, the name came back in 17 of 40 draws, drift in 23"
    other = replace(done, findings=(judged(done.findings[0], shaky),))

    assert words not in " ".join(in_words(report_of(done)).split())
    assert words in " ".join(in_words(report_of(other)).split())
    report = as_json(finding_of(other.findings[0]))["stability"]
    assert report == {
        "resampled": "blocks of time",
        "draws": 40,
        "kept": 17,
        "names": {"drift": 23},
        "weak": 0,
        "instead": "drift",
        "nameless": 0,
        "stable": False,
    }


def test_one_elevation_hides_nothing():
    """Zero and sag are one at one elevation; what goes with azimuth shows all the same."""
    made = recordings(200, 1, x=lambda at: 30 * np.cos(3 * at.az))
    level = replace(made, at=replace(made.at, el=np.full(200, 0.8)))
    done = diagnose(level, load("altaz"))

    assert "azimuth_harmonics" in done.findings[0].members
    assert np.isfinite(done.unseen.after).all()
    assert any("not determined" in one for one in warnings(done, noise_remarks(done)))
    assert report_of(done).determines_nothing is None


def test_one_direction_shows_no_model_and_the_report_begins_with_that():
    """It shows the zero of either axis; of few readings it is said that they are few."""
    made = recordings(200, 1)
    one = replace(made, at=replace(made.at, az=np.full(200, 1.7), el=np.full(200, 0.8)))
    altaz = load("altaz")
    two = [t for t in altaz.terms if t.effect.id in ("collimation", "elevation_zero")]
    done = diagnose(one, altaz)
    report = report_of(done)

    assert report.determines_nothing.startswith(
        "None of the 7 coefficients of altaz is determined: "
    )
    assert in_words(report).splitlines()[1] in report.determines_nothing
    assert report.determines_nothing in of_diagnosis(done, report)[1].warnings
    assert report_of(diagnose(one, replace(altaz, terms=tuple(two)))).determines_nothing is None
    assert report_of(diagnose(one.take(np.arange(4)), altaz)).determines_nothing is None
    assert report_of(diagnose(one, altaz, refit=())).determines_nothing is None


def test_silence_is_no_all_clear_where_noise_does_not_look_like_that():
    """No finding, and no noise either: said as it is."""
    quiet = diagnose(recordings(100, 5), load("altaz"))

    assert "Nothing is missing" in in_words(report_of(quiet))
    assert "does not look like the noise" in in_words(report_of(replace(quiet, p_value=1e-9)))
