"""Outliers lose their vote; ordinary noise keeps it."""

import numpy as np
import pytest

from pyport.least_squares import robust


def test_a_third_of_outliers_does_not_drag_a_line():
    """With a third of the readings far off, the line is that of the others."""
    rng = np.random.default_rng(0)
    x = np.linspace(0, 1, 90)
    columns = np.column_stack([np.ones(90), x])
    value = 2 + 3 * x + 0.01 * rng.normal(size=90)
    value[::3] += rng.uniform(5, 50, 30)

    weight, _, _ = robust.weights(columns, value, reach=6)
    root = np.sqrt(weight)
    fitted = np.linalg.lstsq(columns * root[:, None], value * root, rcond=None)[0]

    np.testing.assert_allclose(fitted, [2, 3], atol=0.01)
    assert weight[::3].max() == 0


def test_ordinary_noise_keeps_its_weight():
    """Among a thousand normal readings almost all weigh one."""
    rng = np.random.default_rng(1)
    weight, _, _ = robust.weights(np.ones((1000, 1)), rng.normal(size=1000), reach=6)

    assert weight.mean() > 0.995


def test_scale_of_normal_noise():
    """The robust scale of normal noise is its sigma, within two percent."""
    rng = np.random.default_rng(2)

    assert robust.scale(rng.normal(scale=3, size=200_000)) == pytest.approx(3, rel=0.02)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (np.repeat([1.0, 2.0, 3.0, 5.0], 5), 1 / np.sqrt(12)),
        (np.random.default_rng(3).normal(size=50), 0.0),
        (np.ones(10), 0.0),
    ],
)
def test_rounding_shows_in_the_steps_of_the_digits(values, expected):
    """Whole numbers scatter by one over the root of twelve; smooth values show no step."""
    assert robust.rounding(values) == pytest.approx(expected)
