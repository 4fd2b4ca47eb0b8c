"""Picking columns that differ: directions of the columns themselves, the most different first."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pyport.least_squares.robust import most_different


def made(seed, rows=30, columns=8, rank=5):
    """Return unit columns of some rank."""
    rng = np.random.default_rng(seed)
    found = rng.normal(size=(rows, rank)) @ rng.normal(size=(rank, columns))
    return found / np.linalg.norm(found, axis=0)


@given(st.integers(0, 2**32 - 1), st.integers(0, 9))
def test_directions_are_orthonormal_and_lie_in_the_span(seed, room):
    """No direction comes from anywhere but the columns, and none twice."""
    columns = made(seed)

    found = most_different(columns, room, 0.05)

    assert found.shape[1] <= min(room, 5)
    np.testing.assert_allclose(found.T @ found, np.eye(found.shape[1]), atol=1e-12)
    inside = columns @ np.linalg.lstsq(columns, found, rcond=1e-9)[0]
    np.testing.assert_allclose(inside, found, atol=1e-8)


@given(st.integers(0, 2**32 - 1))
def test_with_room_for_all_every_column_is_drawn(seed):
    """What is left of each column is less than was asked for."""
    columns = made(seed)

    found = most_different(columns, 8, 0.05)

    left = columns - found @ (found.T @ columns)
    assert np.linalg.norm(left, axis=0).max() < 0.05 + 1e-9


def test_the_first_of_equally_different_columns_is_picked():
    """Columns that differ in length by rounding only are taken in their order."""
    columns = np.eye(4)[:, :3] * (1 + 1e-15 * np.arange(3))

    np.testing.assert_array_equal(np.abs(most_different(columns, 1, 0.05)), np.eye(4)[:, :1])
