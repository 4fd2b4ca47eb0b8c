"""The distance between floats, on which every promise of parity rests."""

import numpy as np
import pytest
from hypothesis import given
from strategies import any_real4

from pyport.parity.compare import UNLIKE, ulps

SMALLEST = float(np.finfo(np.float32).smallest_subnormal)
LARGEST = float(np.finfo(np.float32).max)
NAN_WITH_PAYLOAD = np.uint32(0xFFC12345).view(np.float32)


@pytest.mark.parametrize(
    ("expected", "actual", "distance"),
    [
        (1.0, 1.0, 0),
        (1.0, np.nextafter(np.float32(1), np.float32(2)), 1),
        (1.0, np.nextafter(np.float32(1), np.float32(0)), 1),
        (1.0, 1 + 2**-20, 8),
        (0.0, -0.0, 1),
        (-SMALLEST, SMALLEST, 3),
        (np.nan, NAN_WITH_PAYLOAD, 0),
        (np.nan, 1.0, UNLIKE),
        (1.0, np.nan, UNLIKE),
        (np.inf, np.inf, 0),
        (np.inf, -np.inf, UNLIKE),
        (np.inf, LARGEST, UNLIKE),
        (-LARGEST, -np.inf, UNLIKE),
        (np.inf, np.nan, UNLIKE),
    ],
)
def test_distance(expected, actual, distance):
    """Neighbours are one apart, the two zeros too; NaN and infinity are like no number."""
    assert ulps([expected], [actual]) == [distance]


@given(a=any_real4, b=any_real4)
def test_distance_is_symmetric_and_zero_only_for_equal_bits(a, b):
    """Two numbers are zero apart only with the same bits, or both NaN, whichever comes first."""
    distance = ulps(a, b)
    same = a.view(np.uint32) == b.view(np.uint32) or (np.isnan(a) and np.isnan(b))

    assert distance == ulps(b, a)
    assert (distance == 0) == same
