"""What comes back along an angle in any form: its period, its form and its name, which is none."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.angles import ARCSEC, DEG
from pyport.diagnosis.diagnose import diagnose
from pyport.diagnosis.preparing import prepare
from pyport.diagnosis.searching.contenders import waves_of
from pyport.diagnosis.shapes import cycles, drive_waves
from pyport.diagnosis.shapes.fields import Ground
from pyport.diagnosis.weighing import weigh
from pyport.formats.models import load
from pyport.mounts import KINDS


def sawtooth(angle, period_deg, size=8.0):
    """Return what rises steadily and falls back at once, in every period."""
    return size * (2 * ((angle / DEG / period_deg) % 1) - 1)


def pulse(angle, period_deg, size=14.0):
    """Return what is off in a tenth of every period."""
    return size * ((angle / DEG / period_deg) % 1 < 0.1)


def ground(made, model="altaz"):
    """Return recordings as fields meet them."""
    problem = prepare(made, load(model).on(made.at.mount))
    return Ground(problem, weigh(problem), ())


def worths(over):
    """Return what every cycle is worth, the best first."""
    found = map(over.worth_of, cycles.cycles(over))
    return sorted(found, key=lambda one: -one.evidence)


@pytest.mark.slow
def test_a_sawtooth_of_azimuth_has_no_name_and_a_sine_of_the_same_period_has_one():
    """A wave of its period explains most of a sawtooth; its harmonics say that it is none."""
    toothed = diagnose(recordings(600, 3, x=lambda at: sawtooth(at.az, 36)), load("altaz"))
    waving = diagnose(
        recordings(600, 3, x=lambda at: 8 * np.sin(10 * at.az) * np.cos(at.el)), load("altaz")
    )
    (one,) = toothed.findings

    assert (one.verdict, one.variant) == ("unknown", "xel: every 36 deg of az_deg")
    assert "a worm" in one.decide_by
    assert toothed.heldout.after < toothed.heldout.before - 3 * toothed.heldout.fall_sigma
    assert [each.members for each in waving.findings] == [("azimuth_harmonics",)]


@pytest.mark.slow
def test_teeth_of_an_azimuth_drive_move_the_beam_by_the_cosine_of_elevation():
    """Whatever their form: it is the angle that is off, not the beam."""
    made = recordings(600, 4, x=lambda at: sawtooth(at.az, 36, 12) * np.cos(at.el))

    assert [one.variant for one in diagnose(made, load("altaz")).findings] == [
        "xel: every 36 deg of az_deg, as the cosine of el_deg"
    ]


def test_a_period_that_is_no_part_of_a_turn_is_met_in_both_axes():
    """Neither divides the circle; one is of elevation."""
    around = ground(
        recordings(600, 5, x=lambda at: sawtooth(at.az, 43.4), y=lambda at: sawtooth(at.az, 43.4))
    )
    upward = ground(recordings(600, 5, y=lambda at: sawtooth(at.el, 9.1)))
    first, second = (worths(one)[0].field for one in (around, upward))

    assert first.variant.startswith("both axes")
    assert first.bumps["period_rad"] / DEG == pytest.approx(43.4, abs=0.1)
    assert second.variant.startswith("el")
    assert second.bumps["period_rad"] / DEG == pytest.approx(9.1, abs=0.05)


def test_what_the_cable_winds_is_counted_beyond_a_turn():
    """A roller turns on where the circle of azimuth begins again."""
    made = recordings(600, 6)
    az = np.random.default_rng(6).uniform(-1.4 * np.pi, 1.4 * np.pi, 600)
    rolled = replace(made, at=replace(made.at, az=az), x=made.x + ARCSEC * sawtooth(az + 10, 43.4))
    best = worths(ground(rolled))[0].field

    assert best.variant.endswith("deg of unwrapped_az_deg")
    assert best.bumps["period_rad"] / DEG == pytest.approx(43.4, abs=0.1)


def test_a_worm_of_a_fork_turns_with_the_hour_angle():
    """Its error is the first axis', wherever the telescope looks in azimuth."""
    made = recordings(600, 7)
    at = replace(made.at, mount=KINDS["fork"])
    turned = sawtooth(at.axes.az, 7.5) * np.cos(at.axes.el)
    x, y = 3 * ARCSEC * np.random.default_rng(7).normal(size=(2, 600))
    best = worths(ground(replace(made, at=at, x=x + ARCSEC * turned, y=y)))[0].field

    assert best.variant == "xel: every 7.5 deg of hour_angle_deg, as the cosine of dec_deg"


def test_noise_alone_is_worth_no_cycle():
    """The price of all periods that were tried is paid."""
    assert max(worths(ground(recordings(600, seed)))[0].evidence for seed in range(4)) < 0


def test_eight_harmonics_hold_a_narrow_pulse(monkeypatch):
    """Half as many are worth less by what convinces, twice as many no more."""
    over = ground(recordings(1200, 8, y=lambda at: pulse(at.az, 40)))
    now = cycles.HARMONICS

    def worth(count):
        monkeypatch.setattr(cycles, "HARMONICS", count)
        return worths(over)[0].evidence

    assert worth(now // 2) + 6 < worth(now) > worth(2 * now) - 6


@pytest.mark.parametrize(("period_deg", "there"), [(5.0, True), (3.0, False)])
def test_cycles_of_less_than_four_degrees_are_not_looked_for(period_deg, there):
    """Their harmonics would be finer than what readings of a night tell apart."""
    made = recordings(1200, 9, y=lambda at: sawtooth(at.az, period_deg))
    best = worths(ground(made))[0].field

    assert (best.bumps["period_rad"] / DEG == pytest.approx(period_deg, abs=0.01)) == there


def test_a_period_is_tried_often_enough(monkeypatch):
    """Half as often it is missed by more than a price; twice as often only costs one."""
    over = [
        ground(recordings(600, seed, y=lambda at, p=period: sawtooth(at.az, p)))
        for seed, period in enumerate((17.3, 23.9, 31.4, 37.7, 44.4, 52.3))
    ]
    now = cycles.BINS

    def worth(count):
        monkeypatch.setattr(cycles, "BINS", count)
        return sum(worths(one)[0].evidence for one in over)

    assert worth(now // 2) + 6 < worth(now) > worth(2 * now)


@pytest.mark.slow
def test_a_wave_of_a_drive_gains_what_it_takes_off_the_squares():
    """As other names do: what has paid for its period must not lend it to a field's rivals."""
    over = ground(recordings(600, 4, x=lambda at: 6 * np.sin(20 * at.az) * np.cos(at.el)))
    problem, noise = over.problem, over.weighed.covariance
    (wave,) = waves_of(problem, (), drive_waves.proposed(problem, noise, ()))
    taken = over.gain(wave.problem.expanded([wave.chosen]))

    assert wave.trial.gain == pytest.approx(taken, rel=1e-6)
    assert wave.trial.evidence == wave.sure != pytest.approx(taken, rel=0.01)
