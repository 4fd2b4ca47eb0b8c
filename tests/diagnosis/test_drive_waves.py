"""Short waves of drives: found with their period, chosen anew, stated as surely as they are."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.angles import ARCSEC, DEG
from pyport.diagnosis.diagnose import diagnose
from pyport.diagnosis.naming import waves
from pyport.diagnosis.preparing import prepare
from pyport.diagnosis.shapes import drive_waves
from pyport.diagnosis.weighing import weigh
from pyport.effects.telescope.encoders import (
    azimuth_harmonics,
    elevation_encoder_harmonics,
    elevation_harmonics,
)
from pyport.formats.models import load

#: Amplitude of what is hidden beside a scatter of 5 arcsec. [arcsec]
SIZE = 6.0


def hidden(effect=None, seed=5, rows=400, grid_deg=0.0, where=lambda _: 1.0, sigma_arcsec=5.0):
    """Return recordings with the sine of an effect, as large as `where` says of azimuths."""
    made = recordings(rows, seed, sigma_arcsec)
    at = made.at
    if grid_deg:
        at = replace(at, az=np.round(at.az / DEG / grid_deg) * grid_deg * DEG)
    if effect is None:
        return replace(made, at=at)
    x, y = (SIZE * ARCSEC * where(at.az) * one[:, 0] for one in effect.columns(at))
    return replace(made, at=at, x=made.x + x, y=made.y + y)


def case(*args, **options):
    """Return the case of such recordings."""
    return prepare(hidden(*args, **options), load("altaz"), seed=1)


def proposed(problem):
    """Return the wave that is proposed beside the noise of a case, if any."""
    return drive_waves.proposed(problem, weigh(problem).covariance, ())


def reported(*args, **options):
    """Return the findings about such recordings."""
    return diagnose(hidden(*args, **options), load("altaz"), seed=1).findings


@pytest.mark.parametrize(
    ("member", "k"),
    [
        (azimuth_harmonics, 10),
        (azimuth_harmonics, 180),
        (azimuth_harmonics, 51.4),
        (elevation_harmonics, 36),
        (elevation_encoder_harmonics, 18),
        (elevation_encoder_harmonics, 120),
    ],
)
def test_a_short_wave_is_proposed_with_its_number(member, k):
    """Whole numbers come out whole, others within a few parts of what a turn distinguishes."""
    found = proposed(case(member(k)))
    effect = found.candidate.effect

    assert effect.id == member(k).id
    assert effect.member["k"] == pytest.approx(k, abs=0 if k == round(k) else 0.15)
    assert found.candidate.choices > 100


@pytest.mark.parametrize(
    "effect", [None, azimuth_harmonics(2), azimuth_harmonics(8), elevation_encoder_harmonics(4)]
)
def test_what_has_a_number_of_its_own_is_not_proposed(effect):
    """Nor is anything in noise: longer periods take part and win."""
    assert proposed(case(effect)) is None


@pytest.mark.parametrize("seed", range(12))
def test_noise_shows_no_wave(seed):
    """The best of hundreds of periods is paid for."""
    assert proposed(case(seed=seed, rows=200)) is None


@pytest.mark.parametrize(
    ("grid_deg", "step"), [(0.0, 0.0), (5.0, 5.0), (10.0, 10.0), (20.0, 20.0), (0.02, 0.0)]
)
def test_the_step_of_a_grid_is_seen(grid_deg, step):
    """As waves whose frequencies differ by one over it are alike; a fine one is none."""
    angle = hidden(grid_deg=grid_deg).at.az / DEG

    assert drive_waves.step_of(angle, np.ones(len(angle))) == pytest.approx(step, rel=0.01)


@pytest.mark.parametrize(("grid_deg", "shortest"), [(0.0, 1.0), (1.0, 2.0), (5.0, 10.0)])
def test_no_period_below_two_steps_is_looked_for(grid_deg, shortest):
    """None of less than a degree anywhere, and none from 40 deg on has a number of its own."""
    scan = next(drive_waves.ways_of(case(grid_deg=grid_deg))).scan

    assert scan.shortest == pytest.approx(shortest, rel=0.01)
    assert scan.longest == pytest.approx(360 / 8.5)


@pytest.mark.parametrize(
    ("change", "families"),
    [
        ({}, 3),
        ({"el": lambda at: 0.5 + 0.05 * at.el}, 2),
        ({"az": lambda at: 0.01 * at.az, "el": lambda at: 0.5 + 0.01 * at.el}, 0),
    ],
)
def test_an_angle_holds_two_periods(change, families):
    """Over a few degrees of an angle nothing that follows it comes back."""
    made = hidden()
    at = replace(made.at, **{name: of(made.at) for name, of in change.items()})
    problem = prepare(replace(made, at=at), load("altaz"), seed=1)

    assert len(list(drive_waves.ways_of(problem))) == families


def test_arrays_have_none():
    """The antennas of an array do not share a drive."""
    made = hidden()
    antenna = np.where(np.arange(len(made.at)) % 2, "a", "b")
    at = replace(made.at, columns={**made.at.columns, "antenna": antenna})

    assert not list(drive_waves.ways_of(prepare(replace(made, at=at), load("altaz"), seed=1)))


def test_readings_left_out_choose_no_period():
    """Readings of no weight may say what they like."""
    problem = case(azimuth_harmonics(24))
    one = proposed(problem)
    covariance = weigh(problem).covariance
    problem, _ = problem.with_member(one, one.candidate.effect)
    without = np.arange(len(problem.residual)) % 10 != 3
    blind = replace(covariance, weights=covariance.weights * without)
    data = problem.data.copy()
    wild = 60 * ARCSEC * np.sin(57 * np.resize(problem.recordings.at.az, len(data)))
    data[:, -1] += np.where(without, 0.0, wild)
    other = replace(problem, data=data)

    assert drive_waves.again(other, blind, (), one.candidate.effect).member["k"] == 24
    assert drive_waves.again(other, covariance, (), one.candidate.effect).member["k"] != 24


@pytest.mark.parametrize(
    ("k", "slope", "chosen"), [(40.2, 1.0, 40), (40.2, 300.0, 40.2), (40.0, 300.0, 40)]
)
def test_a_whole_number_stands_unless_another_is_better_by_far(monkeypatch, k, slope, chosen):
    """What sits on the axis comes a whole number of times."""
    fit = SimpleNamespace(fit=lambda turns: (50 - slope * (turns - k) ** 2, 0.0))
    way = SimpleNamespace(
        scan=SimpleNamespace(length=np.array([360.0])), member=lambda turns: round(turns, 6)
    )
    monkeypatch.setattr(drive_waves, "_beside", lambda *_: fit)
    peak = drive_waves.Peak(360 / 40.1, 0.0, 1.0)
    found, sigma = drive_waves._refined(None, None, (), way, peak)

    assert (found, sigma) == pytest.approx((chosen, slope**-0.5))


def test_a_wave_is_named_with_its_period_amplitude_and_phase():
    """A worm of 10 deg, and the true values within four of their errors."""
    (found,) = reported(azimuth_harmonics(36))
    told = {one.name: one for one in found.parameters}

    assert (found.effect, found.verdict) == ("azimuth_harmonics", "named")
    assert found.sentence.startswith("a wave of 10 deg, 36 per turn of azimuth, in azimuth alone")
    truth = {
        "period": 10.0,
        "amplitude": SIZE,
        "phase": 0.0,
        "azimuth_harmonic_sine": SIZE,
        "azimuth_harmonic_cosine": 0.0,
    }
    for name, value in truth.items():
        assert abs(told[name].value - value) < 4 * told[name].sigma
    assert told["period"].sigma < 0.05


def test_a_number_that_is_not_whole_leaves_the_phase_open():
    """Its error turns the phase at azimuth zero, by half a turn of it on average."""
    (found,) = reported(azimuth_harmonics(51.45))
    told = {one.name: one for one in found.parameters}
    number = 360 * told["period"].sigma / told["period"].value ** 2

    assert told["phase"].sigma > 150 * number
    assert told["azimuth_harmonic_sine"].sigma > 1.5 * told["amplitude"].sigma


def test_a_wave_of_one_part_of_the_turn_has_no_name():
    """Drives err all along: what is there in a third of the turn is something else."""
    found = reported(
        azimuth_harmonics(36), rows=1200, sigma_arcsec=2.0, where=lambda az: 1.0 * (az < 2)
    )

    assert all(one.verdict == "unknown" for one in found)
    assert any("the same all along, evidence" in word for one in found for word in one.checks)


def petals(at):
    """Return seven petals in a turn of azimuth that point out low down and in high up."""
    leaf = np.abs(np.cos(3.5 * at.az)) ** 12
    return 8 * np.where(at.el < np.median(at.el), leaf, -leaf)


def test_a_wave_that_turns_over_with_elevation_has_no_name():
    """A track that rocks does so at every elevation, as its law says; petals turn over.

    Beside the outliers and tails of another number of waves, which are heavier, those would be
    likelier.
    """
    found = diagnose(recordings(600, 5, x=petals, y=petals), load("altaz"), seed=1).findings

    assert [(one.verdict, one.variant) for one in found] == [("unknown", "k = 7")]
    assert "not the same at every elevation, evidence" in found[0].looks_like


def test_a_wave_of_elevation_that_turns_over_with_azimuth_has_no_name():
    """An encoder of elevation does not know where the azimuth is."""
    found = diagnose(
        recordings(600, 5, y=lambda at: 12 * np.sin(6 * at.el) * np.sign(np.sin(at.az))),
        load("altaz"),
        seed=1,
    ).findings

    assert all(one.effect != "elevation_encoder_harmonics" for one in found)


@pytest.mark.parametrize(
    ("member", "other"),
    [
        (azimuth_harmonics, "elevation"),
        (elevation_harmonics, "elevation"),
        (elevation_encoder_harmonics, "azimuth"),
    ],
)
def test_a_wave_that_follows_its_law_keeps_its_name(member, other):
    """Across, one of azimuth falls with the cosine of the elevation: that is no change of it."""
    (found,) = reported(member(5), rows=600)

    assert (found.effect, found.variant) == (member(5).id, "k = 5")
    assert f"the wave is the same at every {other}" in found.checks


def test_sectors_by_turns_are_a_wave_and_its_overtone():
    """Of six degrees each, too far and too near by the scatter: thirty times per turn, and ninety.

    The third overtone of a square wave has a third of its amplitude.
    """
    by_turns = recordings(600, 5, y=lambda at: 5 * np.sign(np.sin(30 * at.az)))
    found = diagnose(by_turns, load("altaz"), seed=1).findings

    assert [(one.effect, one.variant) for one in found] == [
        ("elevation_harmonics", "k = 30"),
        ("elevation_harmonics", "k = 90"),
    ]


@pytest.mark.parametrize(("k", "grid_deg", "like"), [(24, 10, 12), (12, 10, 24), (30, 5, 42)])
def test_on_a_grid_a_wave_has_its_like(k, grid_deg, like):
    """The longer one is told, and which other looks the same."""
    (found,) = reported(azimuth_harmonics(k), grid_deg=grid_deg, sigma_arcsec=3.0)

    assert (found.effect, found.verdict) == ("azimuth_harmonics", "ambiguous")
    assert f"{max(k, like):.5g} per turn, looks the same" in found.decide_by


@pytest.mark.parametrize(("grid_deg", "open_"), [(0.0, False), (10.0, True), (0.5, False)])
def test_a_like_that_is_too_short_is_none(grid_deg, open_):
    """Drives have no waves that nobody looks for."""
    assert (waves.alias(azimuth_harmonics(12), way(grid_deg)) is not None) == open_


def way(grid_deg=0.0, angles=()):
    """Return what is known of a drive's angles: their grid, and where they are."""
    angles = np.asarray(angles if len(angles) else 137.508 * np.arange(400))
    scan = SimpleNamespace(time=angles, sign=np.ones(len(angles)))
    return SimpleNamespace(step=grid_deg, scan=scan)


@pytest.mark.parametrize(("jitter_deg", "open_"), [(1.0, True), (2.6, True), (3.6, False)])
def test_rings_as_far_apart_as_the_crests_of_a_wave_leave_it_open(jitter_deg, open_):
    """What is the same at each of them draws it, though none lies at its place exactly.

    Plays of a drive in elevation were named teeth of it, of the distance of the run's rings.
    """
    rings = np.repeat(20 + 15.0 * np.arange(5), 400)
    angles = rings + jitter_deg * np.random.default_rng(1).standard_normal(len(rings))
    like = waves.alias(azimuth_harmonics(24), way(0.0, angles))

    assert (like is not None) == open_
    assert like is None or "about 15 deg apart" in like
    assert waves.alias(azimuth_harmonics(36), way(0.0, angles)) is None


@pytest.mark.parametrize(("from_deg", "size", "seed"), [(50, 20, 4), (55, 25, 5), (60, 40, 7)])
def test_a_term_that_begins_at_some_elevation_is_no_harmonic(from_deg, size, seed):
    """Beside zero, sag and tilt a low harmonic draws nearly that; it was `named`, with k 2 to 4."""

    def bent(at):
        return size * np.maximum(at.el - from_deg * DEG, 0) / ((79 - from_deg) * DEG)

    first = diagnose(recordings(500, seed, y=bent), load("altaz")).findings[0]

    assert first.verdict != "named"
    assert "bend" in f"{first.looks_like} {first.decide_by}"


@pytest.mark.parametrize("k", [6, 8])
def test_a_harmonic_that_comes_again_keeps_its_name(k):
    """No bend draws what was seen to rise and fall and rise."""
    wave = recordings(400, 9, y=lambda at: 9 * np.sin(k * at.el + 1))
    first = diagnose(wave, load("altaz")).findings[0]

    assert (first.effect, first.verdict) == ("elevation_encoder_harmonics", "named")
    assert first.variant == f"k = {k}"
