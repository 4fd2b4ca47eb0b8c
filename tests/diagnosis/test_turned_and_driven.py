"""Circles of a rotator and terms that a condition drives, from recordings to their names."""

from pathlib import Path

import numpy as np
import pytest

from pyport.angles import ARCSEC, DEG
from pyport.diagnosis.diagnose import diagnose
from pyport.effects import CATALOGUE, Circumstances, Site
from pyport.formats.models import load
from pyport.recordings.schema import Recordings


def drawn(rows, nights, seed, noise_arcsec, offsets):
    """Return pointings of some nights, each with a temperature and a course of it of its own.

    `offsets` gives what is added to the noise, across and along elevation [arcsec].
    """
    rng = np.random.default_rng(seed)
    night = np.sort(rng.integers(0, nights, rows))
    hour = np.sort(rng.uniform(-5, 5, rows) + 24 * night) - 24 * night
    az, el = rng.uniform(0, 2 * np.pi, rows), np.arcsin(rng.uniform(0.26, 0.99, rows))
    at_dusk, falls = rng.uniform(-5, 15, nights)[night], rng.uniform(2, 6, nights)[night]
    columns = {
        "time": 1.6e9 + night * 864000.0 + hour * 3600,
        "session": np.char.add("night ", night.astype(str)),
        "temperature_c": at_dusk - falls * (hour + 5) / 5 + rng.normal(0, 0.3, rows),
        "focus_mm": rng.normal(0, 1, rows),
        "rotator_deg": rng.uniform(-170, 170, rows),
    }
    at = Circumstances(az, el, Site(40 * DEG, 10 * DEG), columns)
    x, y = offsets(at, rng)
    noise = noise_arcsec * rng.normal(size=(2, rows))
    nothing = np.full(rows, np.nan)
    return Recordings(
        at,
        (x + noise[0] + 30 * np.cos(el) - 20) * ARCSEC,
        (y + noise[1] + 15 * np.cos(el) + 40) * ARCSEC,
        *(nothing, nothing, np.arange(rows) + 2, Path("drawn.csv")),
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_tilt_that_follows_the_temperature_is_never_a_change_between_sessions(seed):
    """An arcsecond of tilt for each kelvin comes back as that, with its size and direction."""
    toward = np.radians(90 * seed + 20)
    per_kelvin = np.array([np.cos(toward), np.sin(toward)])

    def leaning(at, _):
        x, y = CATALOGUE["tilt"].columns(at)
        above = at.column("temperature_c") - 5
        return above * (x @ per_kelvin), above * (y @ per_kelvin)

    first = diagnose(drawn(300, 6, seed, 3.0, leaning), load("altaz")).findings[0]

    assert first.effect == "driven_term"
    # An hour in a night is too little to be certain of whether it comes late.
    assert first.variant in {f"tilt follows temperature_c{late}" for late in ("", ", 1 h late")}
    assert "epoch_tilt" not in first.members
    for parameter, true in zip(first.parameters, per_kelvin, strict=True):
        assert parameter.unit == "arcsec/K"
        assert abs(parameter.value - true) < 4 * parameter.sigma < 0.4


@pytest.mark.slow
def test_refraction_that_the_temperature_changes_is_no_bent_structure():
    """Corrected for as if the air were always as dense: so much per kelvin, and nothing beside."""

    def bending(at, _):
        warm = at.column("temperature_c")
        return 0 * at.el, -0.4 * (warm - np.median(warm)) / np.tan(at.el)

    found = diagnose(drawn(500, 6, 2, 4.0, bending), load("altaz")).findings

    assert [(one.effect, one.verdict) for one in found] == [("driven_term", "named")]
    assert found[0].variant == "refraction follows temperature_c"
    assert abs(found[0].parameters[0].value + 0.4) < 4 * found[0].parameters[0].sigma < 0.2
    assert "the correction for refraction is off as temperature_c changes" in found[0].sentence


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_what_each_session_begins_with_and_loses_is_no_drift(seed):
    """Eight arcseconds of elevation that die away in an hour, in nights that differ."""

    def settling(at, rng):
        nights, number = np.unique(at.column("session"), return_inverse=True)
        began = [at.column("time")[number == n].min() for n in range(len(nights))]
        since_h = (at.column("time") - np.array(began)[number]) / 3600
        return 0 * at.el, 8 * np.exp(-since_h) + rng.normal(0, 2, len(nights))[number]

    given = drawn(360, 6, seed, 2.0, settling)
    del given.at.columns["temperature_c"]
    (found,) = diagnose(given, load("altaz")).findings

    assert (found.effect, found.members) == ("driven_term", ("driven_term",))
    assert "zero follows the beginning of the session, settling in" in found.variant
    assert "settles in" in found.sentence
    assert found.heldout.after < found.heldout.before


@pytest.mark.slow
def test_a_step_among_nights_that_the_temperature_moves():
    """Where either is seen beside nights that depart, both are, with their sizes."""

    def moved(at, _):
        warm, time = at.column("temperature_c"), at.column("time")
        since = time > np.median(time) + 600
        return 0 * at.el, 0.8 * (warm - np.median(warm)) + 10 * since

    warm, step = diagnose(drawn(700, 6, 16, 6.0, moved), load("altaz")).findings

    assert (warm.effect, step.effect) == ("temperature", "epoch_offset")
    for one, true in ((warm, 0.8), (step, 10)):
        assert abs(one.parameters[1].value - true) < 3 * one.parameters[1].sigma


@pytest.mark.slow
@pytest.mark.parametrize(("rows", "nights", "times"), [(18, 1, 1), (24, 2, -1), (18, 1, 2)])
def test_a_circle_of_the_rotator_is_found_in_eighteen_rows(rows, nights, times):
    """A camera 20 arcsec off the axis of its rotator, in noise of 1 arcsec, turns up as that."""

    def circling(at, _):
        angle = times * np.radians(at.column("rotator_deg"))
        return 20 * np.cos(angle + 1), 20 * np.sin(angle + 1)

    found = diagnose(drawn(rows, nights, 7, 1.0, circling), load("altaz")).findings

    sign, twice = "-" if times < 0 else "", "2 " if abs(times) == 2 else ""
    assert [(one.effect, one.verdict) for one in found] == [("rotator_circle", "named")]
    assert found[0].variant == f"phi = {sign}{twice}rotator_deg"


@pytest.mark.slow
def test_a_lean_that_the_model_lacks_has_one_name_in_one_night():
    """What leans by the hour draws the same there, but it is a change of what is missing."""

    def leaning(at, _):
        x, y = CATALOGUE["tilt"].columns(at)
        return 3 * x[:, 0] - 2 * x[:, 1], 3 * y[:, 0] - 2 * y[:, 1]

    usual = ("azimuth_zero", "collimation", "elevation_zero", "skew", "sag_cosine")
    given = drawn(200, 1, 5, 3.0, leaning)
    found = diagnose(given, load("altaz"), refit=usual).findings

    assert [(one.effect, one.members) for one in found] == [("tilt", ("tilt",))]


@pytest.mark.slow
def test_focus_that_moves_the_beam_is_named_with_its_size():
    """A beam that goes 8 arcsec across with each mm of focus: the collimation follows it."""
    given = drawn(200, 3, 1, 3.0, lambda at, _: (8 * at.column("focus_mm"), 0 * at.el))
    first = diagnose(given, load("altaz")).findings[0]

    assert (first.effect, first.variant) == ("driven_term", "collimation follows focus_mm")
    assert abs(first.parameters[0].value - 8) < 4 * first.parameters[0].sigma
    assert "as focus_mm changes" in first.sentence


def test_a_tilt_that_one_night_warms_is_not_named_after_its_temperature():
    """In one night whatever goes with the hour looks the same, so that no driver has a name."""

    def leaning(at, _):
        x, y = CATALOGUE["tilt"].columns(at)
        warm = at.column("temperature_c") - 5
        return 4 * warm * x[:, 0], 4 * warm * y[:, 0]

    found = diagnose(drawn(200, 1, 3, 3.0, leaning), load("altaz")).findings

    assert found
    assert all(one.verdict != "named" for one in found)


def on_platform(at, _):
    """Return what a receiver on the left platform adds, less the sag that is drawn beside it."""
    el = at.el
    return -12 * np.cos(el) + 20 * np.sin(el), 12 * np.sin(el) + 20 * np.cos(el) - 15 * np.cos(el)


def test_a_receiver_on_a_platform_is_named_where_skew_and_sag_are_not_fitted():
    """Both axes turn with elevation, the side of the platform decides which way."""
    given = drawn(300, 3, 2, 2.0, on_platform)
    usual = ("azimuth_zero", "collimation", "elevation_zero", "tilt")
    first = diagnose(given, load("altaz"), refit=usual).findings[0]

    assert (first.effect, first.variant) == ("nasmyth", "platform on the left")
    assert first.verdict == "named"


@pytest.mark.slow
def test_a_receiver_on_a_platform_is_no_second_name_for_sag():
    """Beside skew and sag it is the sine of elevation, which is said once."""
    found = diagnose(drawn(300, 3, 2, 1.0, on_platform), load("altaz")).findings

    assert "sag_sine" in found[0].members
    assert all("nasmyth" not in one.members for one in found)


@pytest.mark.slow
def test_two_conditions_that_go_together_are_both_said():
    """Where the yoke goes with the air the tilt may follow either: no one name."""

    def leaning(at, rng):
        x, y = CATALOGUE["tilt"].columns(at)
        warm = at.column("temperature_c") - 5
        at.columns["yoke_temp_c"] = warm + rng.normal(0, 0.05, len(warm))
        return warm * x[:, 0], warm * y[:, 0]

    first = diagnose(drawn(300, 6, 1, 5.0, leaning), load("altaz")).findings[0]

    assert (first.members, first.verdict) == (("driven_term",), "ambiguous")
    assert "temperature_c" in first.variant + first.decide_by
    assert "yoke_temp_c" in first.variant + first.decide_by
    assert "go apart" in first.decide_by
