"""Sufficient statistics give what a least-squares fit of the whole gives."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyport.least_squares.gram import Gram, Part, Solution, inverted


@given(seed=st.integers(0, 2**32 - 1), blocks=st.integers(1, 5))
def test_shared_and_own_coefficients_equal_a_dense_fit(seed, blocks):
    """A coefficient for all blocks beside one for each is what the expanded design gives."""
    rng = np.random.default_rng(seed)
    rows = 12 * blocks
    block = rng.permutation(np.arange(rows) % blocks)
    columns, data = rng.normal(size=(rows, 3)), rng.normal(size=rows)
    gram = Gram.of(np.column_stack([columns, data]), block, blocks)
    shared = Part(np.array([0, 2]), np.zeros(blocks, int))
    own = Part(np.array([1]), np.arange(blocks))

    dense = np.column_stack(
        [columns[:, [0, 2]], columns[:, 1:2] * (block[:, None] == range(blocks))]
    )
    expected = np.linalg.lstsq(dense, data, rcond=None)[0]
    actual = gram.solve([shared, own])

    np.testing.assert_allclose(actual.values, expected, atol=1e-9)
    np.testing.assert_allclose(
        actual.residual, ((data - dense @ expected) ** 2).sum(), rtol=1e-8, atol=1e-9
    )


def test_what_is_known_beforehand_is_a_reading_more_of_each_coefficient():
    """As rows that read zero; a coefficient that nothing is known of is as free as before."""
    rng = np.random.default_rng(3)
    columns, data = rng.normal(size=(30, 3)), rng.normal(size=30)
    precision = np.array([0.0, 4.0, 1e9])
    whole = np.column_stack([columns, data])
    actual = Solution.of(whole.T @ whole, precision)
    more = np.vstack([columns, np.diag(np.sqrt(precision))])
    expected = np.linalg.lstsq(more, np.append(data, np.zeros(3)), rcond=None)[0]

    assert actual.values == pytest.approx(expected, abs=1e-9)
    assert actual.residual == pytest.approx(((data - columns @ expected) ** 2).sum())
    assert actual.rank == 2
    assert actual.values[2] == pytest.approx(0, abs=1e-6)


def test_products_add_up_over_chunks():
    """The matrices of two halves are those of the whole: a fold is taken off by subtraction."""
    rng = np.random.default_rng(0)
    whitened, block = rng.normal(size=(40, 4)), rng.integers(0, 3, 40)

    halves = [Gram.of(whitened[s], block[s], 3).matrices for s in (slice(0, 17), slice(17, 40))]

    np.testing.assert_allclose(sum(halves), Gram.of(whitened, block, 3).matrices, atol=1e-12)


def test_what_the_data_leave_open_is_said():
    """Two equal columns cannot be distinguished: both unknown, the third known, rank two."""
    rng = np.random.default_rng(1)
    one, two = rng.normal(size=(2, 30))
    columns = np.column_stack([one, one, two])

    _, rank, _, known = inverted(columns.T @ columns)

    assert rank == 2
    assert known.tolist() == [False, False, True]


def test_units_do_not_matter():
    """A column in microradians beside one in degrees has the same condition number."""
    rng = np.random.default_rng(2)
    columns = rng.normal(size=(30, 3))
    scaled = columns * [1e-9, 1.0, 1e6]

    plain = inverted(columns.T @ columns)
    other = inverted(scaled.T @ scaled)

    np.testing.assert_allclose(other[2], plain[2], rtol=1e-6)
