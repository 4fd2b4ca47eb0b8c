"""The regenerated table against every number that was printed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pyport.pointing import PARAMETERS, printed, recovered
from pyport.steering import check
from pyport.steering.published import published


@pytest.fixture(scope="module")
def checks():
    """Return the check of the program's own 3model."""
    return {one.block.name: one for one in check()}


def test_joined_columns_are_read_apart():
    """The row at 0.1 deg is printed without blanks between its numbers."""
    block = published()[0]
    row = block.printed[block.zd_deg == 0.1]

    assert list(row[:3]) == [-2366, -2758, -3007]
    assert row[-1] == -2366


def test_row_of_dots_stands_for_zeroes():
    """Between 10 and 89 deg the differences are all zero."""
    block = published()[2]
    between = block.printed[(block.zd_deg > 10) & (block.zd_deg < 89)]

    assert len(between) == 7 * 13
    assert not between.any()


@pytest.mark.parametrize("reading", ["as-written", "routine", "float64"])
def test_printed_parameters_alone_miss_cells_at_the_zenith_only(reading):
    """In any reading the azimuth extract agrees with the printed parameters but at z = 0.1."""
    result = check(reading=reading, parameters=printed())[0]

    assert set(result.block.zd_deg[result.misses]) <= {0.1}
    assert result.agree >= 140


def test_recovered_parameters_round_to_the_printed_ones():
    """What was recovered differs from the print only in digits that the print left out."""
    rounded = [f"{degrees:.6f}" for degrees in np.degrees(recovered())]

    assert rounded == [one.printed_deg for one in PARAMETERS]


def test_other_readings_miss_full_rows():
    """Neither the routine with unwrapped azimuth nor double precision gives all full rows."""
    for reading in ("routine", "float64"):
        azimuth = check(reading=reading)[4]

        assert azimuth.agree < 6


def test_a_wrong_number_is_seen(checks):
    """A computed cell that is off by one unit counts as a miss."""
    result = checks["azimuth offsets"]
    spoilt = replace(result, computed=result.computed + np.eye(1, result.total, 50)[0])

    assert spoilt.agree == result.agree - 1
    assert 50 in spoilt.misses
