"""Noise: whitening is generalised least squares, and the fit finds what was put in."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pyport.angles import ARCSEC
from pyport.effects import Circumstances
from pyport.noise.covariance import Covariance
from pyport.noise.estimation import departures, drift
from pyport.noise.estimation.estimate import estimate, reweighed
from pyport.noise.estimation.frame import frame
from pyport.noise.estimation.pooling import moderated
from pyport.noise.pointings import pointings
from pyport.noise.series import Departures, Noise, series
from pyport.recordings.schema import Recordings, stack


def recordings(n, readings, y, session=None):
    """Return n pointings in elevation with some readings each, a minute apart."""
    time = np.repeat(1e9 + 60.0 * np.arange(n), readings)
    az = np.repeat(np.linspace(0, 5, n), readings)
    columns = {
        "time": time,
        "session": np.full(n * readings, "a") if session is None else session,
        "channel": np.tile(np.arange(readings).astype(str), n),
    }
    nothing = np.full(n * readings, np.nan)
    return Recordings(
        Circumstances(az, np.full(n * readings, 0.7), None, columns),
        nothing,
        y,
        nothing,
        nothing,
        np.arange(n * readings),
        Path("made"),
    )


def plain(given, noise, departures=()):
    """Return a covariance without outliers."""
    parts = tuple(series(given, stack(given)))
    ones = np.ones(len(given))
    return Covariance(parts, (noise,), ones, ones, departures)


@pytest.mark.usefixtures("both_paths")
@pytest.mark.parametrize(
    "noise",
    [
        Noise(0.3, 0.5),
        Noise(0.3, 0.5, ((0.8, 300.0),)),
        Noise(0, 1.0),
        Noise(0, 1.0, ((0.8, 300.0),)),
    ],
)
def test_whitened_products_are_those_of_the_inverse_covariance(noise):
    """C'C of whitened columns equals C' V^-1 C with the dense covariance."""
    rng = np.random.default_rng(0)
    readings = 2 if noise.within else 1
    given = recordings(12, readings, rng.normal(size=12 * readings))
    columns = rng.normal(size=(12 * readings, 3))
    moved = rng.normal(size=(12 * readings, 2))
    found = plain(given, noise, (Departures("zero", "session", "", ("a", "b"), moved, 0.7),))

    white = found.whiten(columns)
    same = pointings(given)[:, None] == pointings(given)
    time = given.at.column("time")
    covariance = noise.within**2 * np.eye(len(time)) + noise.between**2 * same
    if noise.time_s:
        covariance += noise.drift**2 * np.exp(-np.abs(time[:, None] - time) / noise.time_s)
    covariance += 0.7**2 * moved @ moved.T

    expected = columns.T @ np.linalg.solve(covariance, columns)
    np.testing.assert_allclose(white.T @ white, expected, rtol=1e-9)
    np.testing.assert_allclose(found.products(columns), expected, rtol=1e-9)
    np.testing.assert_allclose(
        found.departed(columns[:, 0]),
        0.7**2 * moved @ moved.T @ np.linalg.solve(covariance, columns[:, 0]),
        rtol=1e-9,
    )


@pytest.mark.parametrize("centred", [False, True])
def test_a_few_repeats_are_whitened_as_their_products_say(centred):
    """Products made without whitened columns are theirs, and whitening has its transpose."""
    rng = np.random.default_rng(4)
    given = recordings(30, 1, rng.normal(size=30))
    given = given.take(np.sort(np.concatenate([np.arange(30), [4, 17, 17]])))
    columns, moved = rng.normal(size=(33, 3)), np.zeros((33, 2))
    moved[:16, 0], moved[16:, 1] = rng.normal(size=16), rng.normal(size=17)
    noise = Noise(0.3, 0.5, ((0.8, 300.0),), centred=centred)
    departing = (Departures("zero", "session", "", ("a", "b"), moved, 0.7),)
    found = plain(given, noise, departing)
    found.weights[[2, 18]] = 0.4, 1e-12

    white = found.whiten(columns)

    np.testing.assert_allclose(found.products(columns), white.T @ white, rtol=1e-9)
    back, unit = rng.normal(size=(len(white), 2)), np.eye(33)
    np.testing.assert_allclose(found.unwhiten(back), found.whiten(unit).T @ back, atol=1e-9)


def test_scatter_within_and_between_pointings_is_found():
    """Two readings of each pointing tell both parts of the noise."""
    rng = np.random.default_rng(1)
    y = np.repeat(rng.normal(scale=2e-4, size=400), 2) + rng.normal(scale=5e-5, size=800)
    given = recordings(400, 2, y)

    (noise,) = estimate(y, np.ones((800, 1)), frame(given, stack(given))).noises

    assert noise.within == pytest.approx(5e-5, rel=0.1)
    assert noise.between == pytest.approx(2e-4, rel=0.1)
    assert noise.how == "replicates"


def test_three_repeats_do_not_set_the_noise_of_all_pointings():
    """By chance they differ four times more than all others: no reading scatters so much."""
    rng = np.random.default_rng(1)
    y = rng.normal(scale=1e-5, size=400)
    given = recordings(400, 1, y)
    given = replace(given, at=given.at.take(np.repeat(np.arange(400), 1 + (np.arange(400) < 3))))
    y = np.concatenate([np.repeat(y[:3], 2) + np.tile([4e-5, -4e-5], 3), y[3:]])
    nothing = np.full(403, np.nan)
    given = replace(given, x=nothing, y=y, sigma_x=nothing, sigma_y=nothing, line=np.arange(403))

    (noise,) = estimate(y, np.ones((403, 1)), frame(given, stack(given))).noises

    assert np.hypot(noise.within, noise.between) == pytest.approx(1e-5, rel=0.15)


def test_repeats_and_pointings_that_are_all_the_same_have_a_scatter():
    """Or a reading of them would weigh infinitely much."""
    given = recordings(7, 2, np.zeros(14))

    (noise,) = estimate(np.zeros(14), np.ones((14, 1)), frame(given, stack(given))).noises

    assert noise.within >= 1e-12


@pytest.mark.parametrize("averaged", [True, False])
def test_what_is_improbable_is_weighed_where_an_average_is_asked_for(monkeypatch, averaged):
    """In the last turn: the first says no more than where the next one starts."""
    reached = []

    def drafted(*given):
        reached.append(given[-1])
        return drift.draft(*given)

    monkeypatch.setattr("pyport.noise.estimation.estimate.draft", drafted)
    y = 1e-4 * np.random.default_rng(3).normal(size=100)
    given = recordings(100, 1, y)
    here = frame(given, stack(given))
    estimate(y, np.ones((100, 1)), here, averaged=averaged)

    near = drift.within_reach(drift.grid_of(here.parts))
    assert reached == [near, drift.BEYOND if averaged else near]


def test_equally_strong_processes_draw_flicker_noise():
    """Their power times the frequency is one number to a hundredth, away from either end."""
    y = np.zeros(4000)
    given = recordings(4000, 1, y)
    grid = drift.grid_of(frame(given, stack(given)).parts)
    sizes, memories = np.array(grid.shapes[-1]).T
    frequency = 1 / np.geomspace(40 * memories.min(), memories.max() / 40, 200)[:, None]
    power = (sizes**2 * memories / (1 + (frequency * memories) ** 2)).sum(axis=1)
    level = power * frequency[:, 0]

    assert np.sum(sizes**2) == pytest.approx(1.0)
    assert level == pytest.approx(np.full(200, level.mean()), rel=0.03)


def test_a_drift_is_found_with_its_time():
    """An Ornstein-Uhlenbeck drift is told from white noise, white noise is left white."""
    rng = np.random.default_rng(2)
    n, step, time_s, drift = 1500, 60.0, 1200.0, 1e-4
    keep = np.exp(-step / time_s)
    slow = np.empty(n)
    slow[0] = drift * rng.normal()
    for k in range(1, n):
        slow[k] = keep * slow[k - 1] + drift * np.sqrt(1 - keep**2) * rng.normal()
    white = 1e-4 * rng.normal(size=n)
    base = np.ones((n, 1))
    given = recordings(n, 1, white)
    here = frame(given, stack(given))

    (found,) = estimate(white + slow, base, here).noises
    (still,) = estimate(white, base, here).noises

    assert still.drift < 0.25e-4
    assert found.drift == pytest.approx(drift, rel=0.35)
    assert found.time_s == pytest.approx(time_s, rel=0.6)
    assert found.between == pytest.approx(1e-4, rel=0.15)


def test_outliers_do_not_widen_the_noise():
    """A tenth of wild readings leaves the noise of the others as it is."""
    rng = np.random.default_rng(3)
    y = 1e-4 * rng.normal(size=500)
    y[::10] += 5e-3
    given = recordings(500, 1, y)

    found = estimate(y, np.ones((500, 1)), frame(given, stack(given)))

    assert found.noises[0].between == pytest.approx(1e-4, rel=0.25)
    assert not found.used[::10].any()


def test_readings_are_judged_anew_beside_another_model():
    """Weights of a known noise follow the model that they are judged beside."""
    rng = np.random.default_rng(4)
    y = 1e-4 * rng.normal(size=500) + 3e-3
    y[::10] += 5e-3
    given = recordings(500, 1, y)
    base = np.ones((500, 1))
    of = frame(given, stack(given))
    found = estimate(y, base, of)

    alone = reweighed(found, y, base, of)
    beside = reweighed(found, y, np.column_stack([base, np.arange(500) % 10 == 0]), of)

    assert not alone.used[::10].any()
    assert beside.used.all()


def test_a_variance_that_rounding_makes_impossible_is_no_candidate():
    """Products that rounding left a little below zero end no estimate; small variances stand."""
    kind = np.zeros(2, np.intp)
    given = departures._Projected(np.diag([1.0, -1e-6]), np.array([0.1, 0.0]), kind, 10.0, 20)

    small, large = np.array([1.0]), np.array([1e8])

    assert np.isfinite(given.lack(small, given.triangle(small)))
    assert given.triangle(large) is None
    assert given.lack(large, None) == np.inf


@pytest.mark.parametrize("copies", [0, 10, 17])
def test_repeats_that_are_copies_do_not_shrink_the_scatter(copies):
    """However many of twenty pairs are equal to the last digit: the scatter is their rms."""
    rng = np.random.default_rng(4)
    apart = np.where(np.arange(20) < copies, 1e-13, 30 * ARCSEC) * rng.normal(size=20)
    residual = (
        np.repeat(rng.normal(size=20) * 30 * ARCSEC, 2) + np.outer(apart, [0.5, -0.5]).ravel()
    )
    pointing = np.repeat(np.arange(20), 2)
    part = SimpleNamespace(pointing=pointing)

    within = drift._within(residual, np.ones(40), part, np.bincount(pointing), 0.0)

    assert within == pytest.approx(np.sqrt(np.mean(apart**2) / 2), rel=1e-3)


def test_an_antenna_of_copies_borrows_the_scatter_of_repeats():
    """Twenty pairs that are copies count beside six deviations of what is usual in the array."""
    axis = SimpleNamespace(is_y=True, rows=np.arange(40), readings=np.full(20, 2))
    noises = [Noise(within, 30 * ARCSEC, dof=100.0) for within in (1e-12, *[12 * ARCSEC] * 7)]

    found = moderated(noises, [axis] * 8)

    assert found[0].within == pytest.approx(12 * ARCSEC * np.sqrt(6 / 26), rel=0.05)
    assert found[1].within == pytest.approx(12 * ARCSEC)


def test_the_recorded_digits_are_a_floor_whatever_model_is_taken_off():
    """A model that meets every recorded digit leaves no scatter, and does not have none."""
    rng = np.random.default_rng(5)
    whole = 1e-4 * rng.integers(-3, 4, 400)
    given = recordings(400, 1, whole)
    of = frame(given, stack(given))
    found = estimate(1e-9 * rng.normal(size=400), np.ones((400, 1)), of)

    assert of.rounding[1] == pytest.approx(1e-4 / np.sqrt(12))
    assert found.noises[0].floor > 1e-6


@pytest.mark.usefixtures("both_paths")
def test_readings_are_counted_once_where_some_pointings_have_several():
    """A lone reading is its pointing's mean but for rounding: it deviates by nothing."""
    rng = np.random.default_rng(1)
    once = recordings(120, 1, rng.normal(size=120), np.repeat(list("abcd"), 30))
    given = once.take(np.sort(np.concatenate([np.arange(120), np.arange(0, 120, 2)])))
    given = replace(given, y=given.y + rng.normal(size=len(given)))
    data = stack(given)
    made = frame(given, data)
    found = estimate(data.value, np.ones((len(data), 1)), made)
    every = np.ones(len(made.possible.kind))

    assert found.means.start == len(data) == 180
    assert found.products_beside(made.possible, every, data.value[:, None])[1] == 180


@pytest.mark.parametrize("readings", [1, 3])
def test_what_drifts_have_moved_is_the_best_linear_prediction(readings):
    """As the dense covariance has it; repeats of a pointing share it, an outlier tells nothing."""
    rng = np.random.default_rng(5)
    given = recordings(20, readings, np.zeros(20 * readings))
    noise = Noise(0.4 if readings > 1 else 0.0, 0.7, ((1.5, 600.0), (0.5, 9000.0)))
    covariance = plain(given, noise)
    covariance.weights[3] = 0.0
    left = rng.standard_normal(20 * readings)
    time = given.at.numbers("time")
    apart = np.abs(time[:, None] - time)
    drift = sum(size**2 * np.exp(-apart / memory) for size, memory in noise.drifts)
    white = noise.within**2 * np.eye(len(time)) + noise.between**2 * (apart == 0)
    white[3, 3] += 1e6
    wanted = drift @ np.linalg.solve(drift + white, left)

    np.testing.assert_allclose(covariance.drifted(left), wanted, atol=1e-3)
