"""Noise: whitening is generalised least squares, and the fit finds what was put in."""

from pathlib import Path

import numpy as np
import pytest

from pyport.diagnosis import noise_fit
from pyport.diagnosis.noise import Noise, series, whiten
from pyport.diagnosis.pointings import pointings
from pyport.effects import Circumstances
from pyport.fitting.stacking import stack
from pyport.recordings.schema import Recordings


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


@pytest.mark.parametrize(
    "noise", [Noise(0.3, 0.5), Noise(0.3, 0.5, ((0.8, 300.0),)), Noise(0, 1.0)]
)
def test_whitened_products_are_those_of_the_inverse_covariance(noise):
    """C'C of whitened columns equals C' V^-1 C with the dense covariance."""
    rng = np.random.default_rng(0)
    readings = 2 if noise.within else 1
    given = recordings(12, readings, rng.normal(size=12 * readings))
    parts = series(given, stack(given))
    columns = rng.normal(size=(12 * readings, 3))

    white = whiten(columns, np.ones(len(columns)), parts, [noise])
    same = pointings(given)[:, None] == pointings(given)
    time = given.at.column("time")
    covariance = noise.within**2 * np.eye(len(time)) + noise.between**2 * same
    if noise.time_s:
        covariance += noise.drift**2 * np.exp(-np.abs(time[:, None] - time) / noise.time_s)

    np.testing.assert_allclose(
        white.T @ white, columns.T @ np.linalg.solve(covariance, columns), rtol=1e-9
    )


def test_sessions_do_not_hang_together():
    """The drift of one session tells nothing of the next, however close they are."""
    label = np.repeat(["a", "b"], 6)
    given = recordings(12, 1, np.zeros(12), label)
    columns = np.eye(12)

    white = whiten(
        columns, np.ones(12), series(given, stack(given)), [Noise(0, 1, ((1.0, 600.0),))]
    )
    products = white.T @ white

    np.testing.assert_allclose(products[:6, 6:], 0, atol=1e-12)
    assert abs(products[0, 1]) > 0.1


def test_scatter_within_and_between_pointings_is_found():
    """Two readings of each pointing tell both parts of the noise."""
    rng = np.random.default_rng(1)
    y = np.repeat(rng.normal(scale=2e-4, size=400), 2) + rng.normal(scale=5e-5, size=800)
    given = recordings(400, 2, y)
    base = np.ones((800, 1))

    (noise,), _ = noise_fit.fit(y, base, [np.zeros((800, 0))], series(given, stack(given)))

    assert noise.within == pytest.approx(5e-5, rel=0.1)
    assert noise.between == pytest.approx(2e-4, rel=0.1)
    assert noise.how == "replicates"


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
    base, nothing = np.ones((n, 1)), [np.zeros((n, 0))]
    given = recordings(n, 1, white)
    parts = series(given, stack(given))

    (found,), _ = noise_fit.fit(white + slow, base, nothing, parts)
    (plain,), _ = noise_fit.fit(white, base, nothing, parts)

    assert plain.drift < 0.1e-4
    assert found.drift == pytest.approx(drift, rel=0.35)
    assert found.time_s == pytest.approx(time_s, rel=0.6)
    assert found.between == pytest.approx(1e-4, rel=0.15)


def test_outliers_do_not_widen_the_noise():
    """A tenth of wild readings leaves the noise of the others as it is."""
    rng = np.random.default_rng(3)
    y = 1e-4 * rng.normal(size=500)
    y[::10] += 5e-3
    given = recordings(500, 1, y)

    (noise,), weights = noise_fit.fit(
        y, np.ones((500, 1)), [np.zeros((500, 0))], series(given, stack(given))
    )

    assert noise.floor == pytest.approx(1e-4, rel=0.1)
    assert weights[::10].max() < 0.01


def test_weights_alone_are_those_of_the_fit():
    """Judged anew beside the same model, the same readings are wild."""
    rng = np.random.default_rng(4)
    y = 1e-4 * rng.normal(size=500) + 3e-3
    y[::10] += 5e-3
    given = recordings(500, 1, y)
    parts = series(given, stack(given))

    alone = noise_fit.weights(y, np.ones((500, 1)), parts)
    fitted = noise_fit.fit(y, np.ones((500, 1)), [np.zeros((500, 0))], parts)[1]

    np.testing.assert_allclose(alone, fitted, atol=0.02)
    assert alone[::10].max() < 0.01
    assert np.median(alone) > 0.9
