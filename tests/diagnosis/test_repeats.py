"""What comes back in time in any form: its period, its form, and its name, which is none."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.test_oscillations import HOUR, SWINGS, TIME, case, made

from pyport.angles import ARCSEC
from pyport.diagnosis.diagnose import diagnose
from pyport.diagnosis.shapes import oscillations, periods, scans, wave_fits
from pyport.diagnosis.weighing import weigh
from pyport.effects.circumstances import Circumstances
from pyport.effects.empirical import fields
from pyport.formats.models import load

PERIOD_S = 3.3 * HOUR
SHARE = TIME / PERIOD_S % 1

#: Offsets in elevation [arcsec] beside a scatter of 5 arcsec.
FORMS = {
    "a heater that is on for a tenth of the time": lambda _: 14.0 * (SHARE < 0.1),
    "a tank that fills and is emptied": lambda _: 9.0 * SHARE,
}


def proposed(form):
    """Return what is proposed beside the model, and the case."""
    problem = case(form)
    return problem, oscillations.proposed(problem, weigh(problem).covariance, ())


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
def test_what_is_no_sine_is_proposed_with_its_period(form):
    """In place of a sine of its period, or of half or a third of it."""
    problem, one = proposed(form)
    effect = one.candidate.effect

    assert wave_fits.repeats(effect)
    assert wave_fits.period_of(effect) == pytest.approx(PERIOD_S, rel=1e-3)
    assert one.candidate.of_time
    assert set(effect.member["axes"]) == {1}
    assert len(one.candidate.columns) == 16
    assert problem.with_member(one, one.candidate.effect)[0].size == problem.size + 16


@pytest.mark.parametrize("kind", SWINGS)
def test_a_sine_stays_one(kind):
    """Harmonics that are not there cost more than they gain."""
    assert not wave_fits.repeats(proposed(SWINGS[kind])[1].candidate.effect)


@pytest.mark.slow
def test_pulses_in_time_are_found_and_taken_off():
    """Their advice is to look for what is switched; they are predicted where they were not seen."""
    recordings = made(FORMS["a heater that is on for a tenth of the time"])
    found = diagnose(recordings, load("altaz"))
    (one,) = found.findings

    assert (one.verdict, one.effect) == ("unknown", "unknown")
    assert one.variant == "el: every 198 min"
    assert "a heater" in one.decide_by
    assert found.heldout.after < found.heldout.before - 3 * found.heldout.fall_sigma


def test_the_likeliest_spread_of_the_heights_is_theirs():
    """A field's coefficients are drawn toward zero by it: as wide as what is there."""
    _, one = proposed(FORMS["a heater that is on for a tenth of the time"])
    (spread,) = set(one.candidate.effect.member["spread"])
    # Amplitudes of a pulse of a tenth, each times its order: sine and cosine share the square.
    order = np.arange(1, 9)
    heights = 14 * 2 / np.pi * np.sin(np.pi * order / 10)

    assert spread / ARCSEC == pytest.approx(np.sqrt(np.mean(heights**2) / 2), rel=0.35)


def spectrum(frequency_step, squares):
    """Return a spectrum of one axis in which everything is known equally well."""
    frequency = (np.arange(len(squares)) + 0.5) * frequency_step
    both = np.stack([squares, np.zeros(len(squares))], axis=1)
    return periods._Spectrum(frequency, both, np.tile([1.0, 0.0], (len(squares), 1)))


SCAN = scans.Scan(
    np.linspace(0, 8 * HOUR, 481),
    np.zeros(481, int),
    np.zeros(481, int),
    np.ones(481),
    np.zeros(1),
    np.array([8 * HOUR]),
    1200.0,
    4 * HOUR,
)


def test_squares_of_harmonics_are_added_as_they_are_expected():
    """A comb of lines whose squares fall as those of the orders is worth more than its parts."""
    step = 1 / (32 * HOUR)
    squares = np.full(192, 2.0)
    for order in range(1, 9):
        squares[round(order * 16.5 - 0.5)] = 400 / order**2
    (comb,) = periods._repeating(SCAN, spectrum(step, squares))
    alone = np.where(np.arange(192) == 16, squares, 2.0)
    (line,) = periods._repeating(SCAN, spectrum(step, alone))

    (noise,) = periods._repeating(SCAN, spectrum(step, np.full(192, 2.0)))

    assert noise.evidence < 0
    assert comb.period == pytest.approx(1 / (16.5 * step), rel=0.02)
    assert comb.evidence > line.evidence + 50
    assert comb.choices == pytest.approx(8 * SCAN.coherent)


@pytest.mark.parametrize(("longest_h", "there"), [(4, True), (0.3, False)])
def test_no_profile_is_longer_than_a_session_shows(longest_h, there):
    """One of days would take all of a drift."""
    scan = replace(SCAN, longest=longest_h * HOUR)
    squares = np.full(192, 2.0)
    squares[:4] = 1e4
    found = periods._repeating(scan, spectrum(1 / (32 * HOUR), squares))

    assert all(one.period <= scan.longest * 1.001 for one in found)
    assert bool(found) == there


def test_periods_of_a_profile_are_tried_closely_enough_for_its_shortest_waves():
    """A step of a sine off, the eighth harmonic is eight steps off."""
    step = 1 / (32 * HOUR)
    squares = np.full(192, 2.0)
    turns = 12.5
    for order in range(1, 9):
        # A line between two steps is seen in both.
        squares[int(order * turns - 0.5)] = squares[int(order * turns)] = 400 / order**2
    (found,) = periods._repeating(SCAN, spectrum(step, squares))

    assert 1 / (found.period * step) == pytest.approx(turns, abs=0.1)


@pytest.mark.parametrize(
    ("kind", "plain"), [((None, 1), True), ((0.0, 1), False), ((None, 8), False)]
)
def test_what_is_more_than_a_sine_must_be_convincingly_better(kind, plain):
    """A sine whose phase holds is the plain kind."""
    peak = scans.Peak(HOUR, 10.0, 1.0, *kind)

    assert peak.plain == plain
    assert peak.kind == (kind[0] is not None, kind[1])


def test_a_profile_has_a_value_at_any_time_and_its_place_in_the_period():
    """So that a file can hold it."""
    time = 1.2e9 + np.array([0.0, 600.0, HOUR, 2 * HOUR + 600])
    at = Circumstances(np.zeros(4), np.ones(4), columns={"time": time})
    bumps = {"kind": "repeat", "period_s": HOUR, "since_s": 1.2e9, "count": 3}
    found = fields.values(bumps, at)
    minutes, unit = fields.within_period(bumps, at)

    assert found.shape == (4, 6)
    assert np.allclose(found[[0, 1]], found[[2, 3]], atol=1e-6)
    assert found[0] == pytest.approx([1, 1 / 2, 1 / 3, 0, 0, 0], abs=1e-6)
    assert (minutes.tolist(), unit) == (pytest.approx([0, 10, 0, 10], abs=1e-4), "min")
    with pytest.raises(ValueError, match="more bumps than any recordings"):
        fields.field(
            bumps | {"period_s": 0.5}, [0] * 6, range(6), np.eye(6).tolist(), "repeats", "too fast"
        )
