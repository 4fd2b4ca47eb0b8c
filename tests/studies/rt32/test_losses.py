"""Votes of residuals: each loss against its own definition."""

import numpy as np
import pytest

from pyport.angles import ARCSEC
from pyport.studies.rt32.losses import LEVEL, METHODS, cut_factor, student_t, variance

NORMAL = 10 * ARCSEC * np.random.default_rng(0).normal(size=4000)


@pytest.mark.parametrize("method", [m for m in METHODS if m != "document"])
def test_slope_is_the_derivative_of_weight_times_residual(method):
    """Central differences of the vote agree with the slope."""
    tuned = METHODS[method](LEVEL)(NORMAL)
    # away from Huber's corner, where there is none
    r, step = np.array([-60, -30, -3, 0, 2, 9, 25]) * ARCSEC, 1e-4 * ARCSEC

    def vote(r):
        return tuned.weight(r) * r

    np.testing.assert_allclose(
        (vote(r + step) - vote(r - step)) / (2 * step), tuned.slope(r, tuned.weight(r)), atol=1e-6
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_small_residual_votes_more_than_a_large_one(method):
    """Weights fall with the size of the residual, whatever its sign."""
    tuned = METHODS[method](LEVEL)(NORMAL)
    size = np.linspace(0, 200, 50) * ARCSEC
    weight = tuned.weight(size)

    assert (np.diff(weight) <= 0).all()
    np.testing.assert_array_equal(weight, tuned.weight(-size))


def test_students_t_finds_its_own_shape():
    """Scale and degrees of freedom are those that the residuals were drawn with."""
    rng = np.random.default_rng(1)
    tuned = student_t(10 * ARCSEC * rng.standard_t(3, 20000))
    scale, nu = (float(word) for word in tuned.text.split() if word[0].isdigit())

    assert scale == pytest.approx(10, rel=0.05)
    assert nu == pytest.approx(3, rel=0.15)


@pytest.mark.parametrize(("method", "efficiency"), [("huber", 0.95), ("student-t", 0.97)])
def test_variance_with_normal_noise(method, efficiency):
    """With normal noise the variance of the mean is that of the loss's known efficiency."""
    tuned = METHODS[method](LEVEL)(NORMAL)
    weight = tuned.weight(NORMAL)
    of_the_mean = variance(NORMAL, tuned, np.ones(len(NORMAL))) / weight.mean()

    assert of_the_mean / np.var(NORMAL) == pytest.approx(1 / efficiency, rel=0.05)


def test_cutting_normal_noise_makes_sigmas_too_small():
    """What the formal sigma misses by the cut is what many means of cut samples scatter more."""
    rng = np.random.default_rng(2)
    level = 1.5
    means, formal, factors = [], [], []
    for _ in range(400):
        sample = rng.normal(size=600)
        mean = 0.0
        for _ in range(60):
            kept = np.abs(sample - mean) <= level
            mean = sample[kept].mean()
        means.append(mean)
        formal.append(np.sqrt(np.mean((sample[kept] - mean) ** 2) / kept.sum()))
        factors.append(cut_factor(sample - mean, level))

    assert np.std(means) / np.mean(formal) == pytest.approx(np.median(factors), rel=0.15)
