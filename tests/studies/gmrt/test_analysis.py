"""The GMRT paper's analysis: on days made here with known coefficients, and on the tables."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from click.testing import CliRunner
from samples import sample

from pyport.angles import ARCMIN, DEG, HOUR
from pyport.cli.study import gmrt
from pyport.recordings import read, sky
from pyport.studies.gmrt import summary
from pyport.studies.gmrt.curves import Track, curve, curves, tracks
from pyport.studies.gmrt.refits import printed_sigma_factors
from pyport.studies.gmrt.repetition import NAMED, jumps_at_transit, mirrors, repeatability

LATITUDE, DEC = 19.1 * DEG, 40.74 * DEG

#: Of -6 cos HA + 2 sin HA [arcmin].
B_AND_D = (-(40**0.5) * ARCMIN, np.arctan2(2, 6))


@pytest.fixture(scope="module")
def june():
    """Return the antennas' days of June."""
    return tracks(read("gmrt-cyg-a"))


def made_track(rng, antenna="C02", session="day 1", noise=0.3, **terms):
    """Return a track made of known terms [arcmin]: level, cosine, sine, half, step."""
    hour_angle = np.sort(rng.uniform(-4, 3, 40)) * HOUR
    direction = np.where(np.arange(40) % 2, -1.0, 1.0)
    _, el = sky.horizon(hour_angle, np.full(40, DEC), LATITUDE)
    offset = (
        terms.get("level", 0)
        + terms.get("cosine", 0) * np.cos(hour_angle)
        + terms.get("sine", 0) * np.sin(hour_angle)
        + terms.get("half", 0) * direction
        + terms.get("step", 0) * (hour_angle > 0)
        + rng.normal(0, noise, 40)
    )
    return Track(antenna, session, hour_angle, el, offset * ARCMIN, direction)


def test_known_curve():
    """a, b and d come back within four sigmas, forward minus reverse taken out."""
    rng = np.random.default_rng(1)

    fitted = curve(made_track(rng, level=12, cosine=-6, sine=2, half=3))

    found = (*fitted.cosine.polar(), fitted.half_difference)
    for (value, sigma), truth in zip(found, (12 * ARCMIN, *B_AND_D, 3 * ARCMIN), strict=True):
        assert abs(value - truth) < 4 * sigma
    assert fitted.rms == pytest.approx(0.3 * ARCMIN, rel=0.3)


def test_sigmas_are_true():
    """Over many made days the coefficients scatter as their sigmas say."""
    rng = np.random.default_rng(2)
    fitted = [curve(made_track(rng, level=12, cosine=-6, sine=2, half=3)) for _ in range(150)]

    for k, truth in enumerate((12 * ARCMIN, *B_AND_D)):
        found = [one.cosine.polar()[k] for one in fitted]
        assert np.std([(value - truth) / sigma for value, sigma in found]) == pytest.approx(
            1, abs=0.2
        )


@pytest.mark.parametrize(("north", "on"), [(3, 5), (-3, 5), (3, -5), (-1, -8)])
def test_place_and_curve_by_spherical_trigonometry(north, on):
    """Cosine E times what a displaced antenna sees is its place's wave, not as printed."""
    hour_angle = np.linspace(-4, 4, 41) * HOUR
    _, computed = sky.horizon(hour_angle, np.full(41, DEC), LATITUDE)
    shifted = hour_angle + on * ARCMIN, np.full(41, DEC), LATITUDE + north * ARCMIN
    seen = np.cos(computed) * (sky.horizon(*shifted)[1] - computed)

    true = summary.wave_of_place(north * ARCMIN, on * ARCMIN, DEC, LATITUDE)(hour_angle)
    printed = summary.wave_as_printed(north * ARCMIN, on * ARCMIN, DEC, LATITUDE)(hour_angle)

    assert np.abs(seen - true).max() < 0.03 * ARCMIN
    assert np.abs(seen - printed).max() > 1 * ARCMIN


def test_place_from_the_curve():
    """The odd part gives the displacement in hour angle."""
    wave = summary.wave_of_place(2 * ARCMIN, 5 * ARCMIN, DEC, LATITUDE)
    sine = -wave.b * np.sin(wave.d)

    on, _ = summary.further_on((sine, 0.0), DEC, LATITUDE)

    assert on / ARCMIN == pytest.approx(5)


def test_a_cut_day_bends_the_coefficients():
    """The a of a displaced antenna depends on the hours fitted: by arcminutes at the arms' ends."""
    cut, whole = (
        summary.wave_fitted_to_place(0, 7 * ARCMIN, DEC, LATITUDE, hours)
        for hours in ((-3.75, 1.72), (-3.75, 3.75))
    )

    assert whole.a / ARCMIN == pytest.approx(0, abs=0.2)
    assert abs(cut.a) > 5 * ARCMIN


def test_repeatability_of_made_days():
    """An antenna that moved by 4 arcmin is told from one that did not."""
    rng = np.random.default_rng(3)
    days = [
        made_track(rng, antenna, f"day {day}", level=10 + 4 * day * moves, cosine=-5, half=day)
        for antenna, moves in (("C02", 0), ("C13", 1))
        for day in (0, 1)
    ]

    still, moved = sorted(repeatability(days), key=lambda test: test.antenna)

    assert still.repeats
    assert not moved.repeats
    level, sigma = moved.level["day 1"]
    assert level == pytest.approx(4 * ARCMIN, abs=4 * sigma)


def test_the_papers_list_of_antennas_that_do_not_repeat(june):
    """All five that the paper names move by more than 2 arcmin, and so do others."""
    moved = {test.antenna for test in repeatability(june) if not test.repeats}

    assert set(NAMED) <= moved
    assert {"C11", "S01"} <= moved
    assert {"C08", "C10", "W06"}.isdisjoint(moved)


def test_arms_are_mirror_images(june):
    """East and west arms bend opposite ways about the meridian on every day of June."""
    days = mirrors(curves(june, times_cos_el=True))

    assert len(days) == 3
    assert all(day.opposite[0] == day.opposite[1] for day in days)
    assert min(day.chance for day in days) < 0.01


def test_jump_of_made_days():
    """A step of 1 arcmin at transit is found, and none where there is none."""
    rng = np.random.default_rng(4)
    days = [
        made_track(rng, f"C{n:02d}", f"day {day}", level=5, cosine=-4, half=2, step=day)
        for day in (0, 1)
        for n in range(20)
    ]

    none, one = jumps_at_transit(days)

    assert abs(none.mean) < 4 * none.sigma
    assert none.p_value > 1e-3
    assert one.mean == pytest.approx(1 * ARCMIN, abs=4 * one.sigma)
    assert one.p_value < 1e-3


def test_no_jump_at_transit_in_june(june):
    """The paper's transit problem is gone: the mean step is below half an arcminute."""
    days = jumps_at_transit(june)

    assert [day.session for day in days] == ["2003-06-01", "2003-06-02", "2003-06-05"]
    assert max(abs(day.mean) for day in days) < 0.5 * ARCMIN
    assert min(day.p_value for day in days) > 1e-3


def test_printed_sigmas_are_too_small():
    """Table 18's own days differ by twice their printed sigmas or more."""
    assert min(printed_sigma_factors("2003-06-01", "2003-06-02").values()) > 1.5


def test_displacements_against_the_survey(june):
    """The displacements in hour angle that curves give follow the surveyed longitudes."""
    with sample("gmrt/antennas_enu.csv").open(newline="") as file:
        longitude = {row["name"]: float(row["dlon_deg"]) for row in csv.DictReader(file)}
    found = [one for one in curves(june, times_cos_el=True) if one.track.session == "2003-06-02"]

    on = [summary.further_on(one.odd, DEC, LATITUDE)[0] for one in found]
    surveyed = [longitude[one.track.antenna] * DEG for one in found]

    assert np.corrcoef(on, surveyed)[0, 1] > 0.9


@pytest.mark.slow
def test_command(tmp_path):
    """`pyport study gmrt` prints every part and draws the paper's four figures."""
    done = CliRunner().invoke(gmrt, ["--out", str(tmp_path)])

    assert done.exit_code == 0
    for part in ("Recovery", "Curves", "Places", "Repeatability", "Mirror images", "Transit"):
        assert f"\n{part}" in f"\n{done.output}"
    assert [path.name for path in sorted(tmp_path.iterdir())] == [
        f"figure-{n}.png" for n in (1, 2, 3, 4)
    ]
    assert all(path.stat().st_size > 50_000 for path in tmp_path.iterdir())
