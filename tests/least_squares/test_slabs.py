"""Slabs: nothing that is not empty is lost."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pyport.least_squares.gram import Gram, slabs, without


@given(st.integers(0, 2**32 - 1))
def test_slabs_hold_everything_once(seed):
    """Put together again they are the matrix, and none of them has an empty column."""
    rng = np.random.default_rng(seed)
    blocks, kinds = rng.integers(0, 3, 40), rng.integers(0, 2, 40)
    whole = rng.normal(size=(40, 6)) * (rng.random((2, 6)) < 0.5)[kinds]
    whole[rng.random(40) < 0.3] = 0

    again = np.zeros_like(whole)
    for slab in slabs(whole, blocks, kinds):
        assert slab.values.any(axis=0).all()
        assert set(blocks[slab.rows]) == {slab.block}
        again[np.ix_(slab.rows, slab.columns)] += slab.values

    np.testing.assert_array_equal(again, whole)
    matrices = Gram.of(whole, blocks, 3, kinds).matrices
    np.testing.assert_allclose(matrices, Gram.of(whole, blocks, 3).matrices, atol=1e-12)


def test_rows_of_rounding_are_left_out():
    """A row a million million times shorter than the others is none."""
    whole = np.ones((4, 2))
    whole[1] *= 1e-12

    (one,) = slabs(whole, np.zeros(4, np.intp), np.zeros(4, np.intp))

    np.testing.assert_array_equal(one.rows, [0, 2, 3])


def test_a_row_is_held_against_its_own_columns():
    """One cell of a column in another unit, or -9999 in it, makes no other row an empty one."""
    whole = np.ones((4, 4))
    whole[:, 2] *= 1e-3
    whole[1, 2] = 1e12

    (one,) = slabs(whole, np.zeros(4, np.intp), np.zeros(4, np.intp))
    (rest,) = without([one], 3)

    np.testing.assert_array_equal(one.rows, range(4))
    np.testing.assert_array_equal(rest.rows, range(4))
