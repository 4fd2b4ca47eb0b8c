"""Refits: the same answers as fits from scratch, whatever the weights and the design."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyport.least_squares.robust import Refit


def from_scratch(columns, value, weight):
    """Return the residuals of a weighted fit by singular values."""
    root = np.sqrt(weight)
    return value - columns @ np.linalg.lstsq(columns * root[:, None], value * root, rcond=1e-9)[0]


@given(st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_residuals_are_those_of_a_fit_from_scratch(seed, share):
    """With few or many weights other than one."""
    rng = np.random.default_rng(seed)
    columns, value = rng.normal(size=(60, 6)), rng.normal(size=60)
    weight = np.where(rng.random(60) < share, rng.uniform(0.01, 10, 60), 1.0)

    residual = Refit(columns, value).residual(weight)

    np.testing.assert_allclose(residual, from_scratch(columns, value, weight), atol=1e-9)


@pytest.mark.parametrize("repeated", [True, False])
def test_columns_that_weights_make_alike_are_fitted_by_singular_values(repeated):
    """A column that is zero wherever there is weight, or the copy of another, does no harm."""
    rng = np.random.default_rng(1)
    columns, value = rng.normal(size=(40, 3)), rng.normal(size=40)
    columns[:, 2] = columns[:, 1] if repeated else np.arange(40) < 5
    weight = (np.arange(40) >= 5).astype(float)

    residual = Refit(columns, value).residual(weight)

    np.testing.assert_allclose(residual, from_scratch(columns, value, weight), atol=1e-9)


def test_rank_counts_independent_columns():
    """A copy does not count."""
    columns = np.random.default_rng(2).normal(size=(20, 3))

    assert Refit(columns, columns[:, 0]).rank == 3
    assert Refit(np.column_stack([columns, columns[:, 0]]), columns[:, 0]).rank == 3
