"""What astrometry left in the offsets comes out again, each step by its name."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from pyport.angles import ARCSEC, DEG
from pyport.cli.dev.recorded import reduction as command
from pyport.effects import Circumstances
from pyport.errors import BadInput
from pyport.examiner.sealed.record.files import write_recordings
from pyport.examiner.worlds.kinds import make_case
from pyport.recordings import read
from pyport.studies.rt32.reduction import DOCUMENT, STEPS, left_out, reduced
from pyport.studies.rt32.reduction_sizes import (
    CAMPAIGNS,
    RT32,
    against_astropy,
    orientations,
    refraction_at_45,
    sizes,
    sky_over,
    text,
)

SKY = ("nutation", "annual_aberration", "diurnal_aberration", "ut1", "polar_motion")


@pytest.fixture(scope="module")
def spring():
    """Return directions and times of the campaign of 2003."""
    return sky_over(RT32, *CAMPAIGNS["2003"], count=500)


def simulated(path, steps):
    """Return recordings of a steering program that left steps out, and their hidden signature."""
    case = make_case("ablation", 5, effect="+".join(steps), rows=400, weeks=12)
    write_recordings(case, path)
    recordings = read(path)
    return recordings, np.where(np.isfinite(recordings.x), *case.signature)


def size(recordings):
    """Return the offset of each row, of whichever axis it measures."""
    return np.where(np.isfinite(recordings.x), recordings.x, recordings.y)


@pytest.mark.parametrize("step", SKY)
def test_each_step_removes_what_its_want_put_in(tmp_path, step):
    """What a simulation leaves out the reduction takes out, to 0.04 arcsec and two percent.

    The two percent are refraction's: it squeezes the lowest shifts that it is applied after.
    """
    recordings, hidden = simulated(tmp_path / "ablation.csv", (step,))
    removed = size(recordings) - size(reduced(recordings, (step,)))

    high = recordings.at.el > 20 * DEG
    np.testing.assert_allclose(removed, hidden, rtol=0.02, atol=0.04 * ARCSEC)
    np.testing.assert_allclose(removed[high], hidden[high], rtol=0.003, atol=0.04 * ARCSEC)
    assert np.sqrt(np.mean(hidden**2)) > 0.1 * ARCSEC


def test_steps_add_up(spring):
    """What several steps leave is the sum of what each leaves."""
    together = left_out(spring, SKY)
    apart = [left_out(spring, (step,)) for step in SKY]

    np.testing.assert_allclose(together, np.sum(apart, axis=0), rtol=0, atol=1e-15)


def test_no_step_leaves_everything_as_it_was(tmp_path):
    """Switched off altogether the reduction changes no offset."""
    recordings, _ = simulated(tmp_path / "ablation.csv", ("ut1",))

    np.testing.assert_array_equal(size(reduced(recordings, ())), size(recordings))


def test_all_steps_agree_with_astropy():
    """Precessed places and all steps are within 0.03 arcsec of AltAz, the Sun's bending apart."""
    agreement = against_astropy(count=150)

    assert agreement.median < 0.01
    assert agreement.away_from_sun < 0.03


def test_mean_refraction_is_sixty_arcseconds_at_45_degrees():
    """The document's formula, 60 arcsec / tan H, upward only."""
    at = Circumstances(np.zeros(3), np.array([15.0, 45.0, 80.0]) * DEG)
    x, y = STEPS["mean_refraction"](at)

    np.testing.assert_array_equal(x, 0)
    np.testing.assert_allclose(y, 60 * ARCSEC / np.tan(at.el))


def test_weather_refraction_follows_the_weather(spring):
    """Moist air bends radio waves more, thin air less; the horizon less than the cotangent says."""
    assert refraction_at_45(humidity_pct=0.0) < refraction_at_45() < 75
    assert refraction_at_45(pressure_hpa=500.0) < 0.6 * refraction_at_45()
    low, high = (
        STEPS["weather_refraction"](replace(spring, el=np.full(len(spring), el * DEG)))[1][0]
        for el in (5.0, 45.0)
    )
    assert 0.8 < low * np.tan(5 * DEG) / high < 0.99


def test_sizes_are_those_that_the_document_explains():
    """Aberration 20, nutation up to 17 with apparent time, UT1 below 7 arcsec; the pole 17 m."""
    largest = {(one.step, one.campaign): one.largest for one in sizes()}
    orientation = {one.campaign: one for one in orientations()}

    assert largest["annual_aberration", "2003"] == pytest.approx(20.5, abs=0.4)
    assert largest["nutation_apparent_time", "2003"] == pytest.approx(17, abs=1)
    assert largest["ut1", "2004"] == pytest.approx(6.9, abs=0.1)
    assert orientation["2003"].pole[1] * ARCSEC * 6.371e6 == pytest.approx(17, abs=0.5)
    assert orientation["2003"].ut1_utc_s[1] < 0


@pytest.mark.parametrize(
    ("change", "steps", "message"),
    [
        ({}, ("nutations",), "no step is called 'nutations'"),
        ({"meta": {"reduced": "ut1"}}, ("ut1", "nutation"), "ut1 was taken out .* before"),
        ({"at": Circumstances(np.zeros(400), np.ones(400), RT32)}, DOCUMENT, "needs time_utc"),
    ],
)
def test_what_cannot_be_reduced_is_said(tmp_path, change, steps, message):
    """An unknown step, a step taken twice, a missing column: one line each."""
    recordings, _ = simulated(tmp_path / "ablation.csv", ("ut1",))

    with pytest.raises(BadInput, match=message):
        reduced(replace(recordings, **change), steps)


def test_reduced_recordings_say_so(tmp_path):
    """The command writes what was taken out, and refuses to take it out again."""
    recordings, _ = simulated(tmp_path / "raw.csv", ("ut1",))
    out = tmp_path / "reduced.csv"
    run = CliRunner()
    first = run.invoke(command, ["apply", str(recordings.file), str(out), "--steps", "ut1"])
    second = run.invoke(command, ["apply", str(out), str(out), "--steps", "ut1"])

    assert first.exit_code == 0
    assert read(out).meta["reduced"] == "ut1"
    assert isinstance(second.exception, BadInput)


def test_the_text_names_every_step_and_figure():
    """The table lists each step beside the document's figure, and the reasons below."""
    shown = text()

    for name in (*STEPS, '17"', '20"', '13"', "17 m", '60"/tan H', "AltAz"):
        assert name in shown
