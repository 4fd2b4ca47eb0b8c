"""A drift that is counted from its mean: its covariance, and that a constant is no drift."""

import numpy as np

from pyport.noise.covariance import Covariance
from pyport.noise.series import Noise, Series

N = 30
DRIFTS = ((0.7, 500.0), (1.2, 50000.0))
_RNG = np.random.default_rng(8)
TIME = np.sort(_RNG.uniform(0, 1e4, N))


def covariance(*, centred):
    """Return the covariance of one axis of N pointings."""
    part = Series(np.arange(N), np.arange(N), TIME, np.arange(N), "A", is_y=False)
    noise = Noise(0.0, 0.4, DRIFTS, centred=centred)
    return Covariance((part,), (noise,), np.ones(N), np.ones(N))


def dense():
    """Return the covariance with the mean of the drifts taken away, (N, N), by matrices."""
    drift = sum(a**2 * np.exp(-np.abs(TIME[:, None] - TIME) / memory) for a, memory in DRIFTS)
    less_mean = np.eye(N) - 1 / N
    return less_mean @ drift @ less_mean + 0.4**2 * np.eye(N)


def test_centred_drift_has_the_covariance_of_its_deviations():
    """Products of whitened columns, and the determinant, are those of matrices to 1e-9."""
    columns = _RNG.standard_normal((N, 3))
    given = covariance(centred=True)

    white = given.whiten(columns)

    np.testing.assert_allclose(
        white.T @ white, columns.T @ np.linalg.solve(dense(), columns), rtol=1e-9
    )
    np.testing.assert_allclose(given.log_determinant, np.linalg.slogdet(dense())[1], rtol=1e-9)


def test_centring_changes_nothing_beside_a_constant_and_shows_the_constant():
    """With a constant fitted another column is known as before, the constant far better."""
    columns = np.stack([np.ones(N), np.cos(TIME / 3000)], axis=1)

    known = {}
    for centred in (False, True):
        white = covariance(centred=centred).whiten(columns)
        known[centred] = np.linalg.inv(white.T @ white)

    np.testing.assert_allclose(known[True][1, 1], known[False][1, 1], rtol=1e-9)
    assert known[True][0, 0] < known[False][0, 0] / 50
