"""Noise of every kind has the size and the shape that the truth tells."""

import numpy as np
import pytest

from pyport.angles import ARCSEC
from pyport.examiner.worlds.campaign import (
    NOISES,
    SKIES,
    Noise,
    campaign,
    draw,
    gappy_campaign,
    rounded,
    usual_noise,
)
from pyport.examiner.worlds.earth import wander

ROWS = 8000


def drawn(noise):
    """Return noise of both axes in units of sigma."""
    plan = campaign(np.random.default_rng(5), ROWS)
    x, y = draw(np.random.default_rng(6), noise, plan)
    return x / noise.sigma_x, y / noise.sigma_y


@pytest.mark.parametrize("kind", ["white", "drift", "axes-correlated"])
def test_the_rms_is_sigma(kind):
    """Whatever the kind, the rms is sigma within a tenth on 8,000 rows, each axis its own."""
    x, y = drawn(usual_noise(np.random.default_rng(1), kind))

    np.testing.assert_allclose([x.std(), y.std()], 1, atol=0.1)
    assert (abs(np.corrcoef(x, y)[0, 1]) < 0.1) == (kind != "axes-correlated")


def test_white_noise_has_no_memory_and_drift_has():
    """Neighbours are independent in white noise; in drift they share its share of the variance."""
    white, _ = drawn(Noise(ARCSEC, ARCSEC))
    slow, _ = drawn(Noise(ARCSEC, ARCSEC, drift_share=0.4, memory_s=3600.0))

    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.05
    assert np.corrcoef(slow[1:], slow[:-1])[0, 1] == pytest.approx(0.39, abs=0.08)


@pytest.mark.parametrize(("kind", "beyond"), [("white", 0.0003), ("student-3", 0.05)])
def test_heavy_tails_reach_further(kind, beyond):
    """Student's t of three degrees has a twentieth of its rows beyond 3.2 scales."""
    rng = np.random.default_rng(1)
    heavy, _ = drawn(usual_noise(rng, kind))

    assert np.mean(np.abs(heavy) > 3.5) == pytest.approx(beyond, abs=0.015)


@pytest.mark.parametrize(("number", "kind"), [*enumerate(NOISES)])
def test_every_noise_is_drawn_in_a_sky(number, kind):
    """As many numbers as rows, none of them missing, the same again from the same seed."""
    plan = campaign(np.random.default_rng(5), 120, sky=SKIES[number % len(SKIES)])
    noise = usual_noise(np.random.default_rng(1), kind)
    first, again = (draw(np.random.default_rng(6), noise, plan) for _ in range(2))

    assert np.isfinite(first).all()
    assert np.shape(first) == (2, 120)
    np.testing.assert_array_equal(first, again)


def test_outliers_are_as_many_as_told():
    """Four in a hundred rows lie beyond seven sigma, and the rest do not."""
    x, _ = drawn(Noise(ARCSEC, ARCSEC, outlier_share=0.04))

    assert np.mean(np.abs(x) > 6) == pytest.approx(0.04, abs=0.008)


def test_a_gappy_campaign_keeps_its_rows_and_loses_stretches():
    """As many rows as asked for, with holes that the same campaign without gaps has not."""
    plan = gappy_campaign(np.random.default_rng(2), 600)
    whole = campaign(np.random.default_rng(2), 900)

    assert len(plan) == 600
    assert set(plan.time_s) < set(whole.time_s)


def test_rounding_is_to_whole_steps_or_none():
    """Readings are multiples of the encoder's step; a step of zero changes nothing."""
    value = np.array([0.24, 0.26, -1.1])

    np.testing.assert_allclose(rounded(value, 0.5), [0, 0.5, -1])
    np.testing.assert_array_equal(rounded(value, 0.0), value)


def test_wandering_forgets_by_e_in_its_memory():
    """The correlation at one memory's lag is 1/e."""
    time_s = np.arange(200_000.0)
    value = wander(np.random.default_rng(3), time_s, 50.0)

    assert value.std() == pytest.approx(1, abs=0.05)
    assert np.mean(value[50:] * value[:-50]) == pytest.approx(np.exp(-1), abs=0.05)
