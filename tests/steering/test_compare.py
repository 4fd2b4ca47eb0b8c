"""Two tables beside each other."""

from __future__ import annotations

import numpy as np
import pytest

from pyport.errors import BadInput
from pyport.steering import Grid, Table, tabulate
from pyport.steering.grid import compare, describe, picture

GRID = Grid(np.arange(0.0, 40, 10), np.arange(10.0, 60, 10))


def flat(value: float, grid: Grid = GRID) -> Table:
    """Return a table that is the same everywhere."""
    shape = len(grid.az_deg), len(grid.zd_deg)
    return Table(grid, np.full(shape, value), np.full(shape, -value))


def test_equal_tables_are_called_equal():
    """Nothing differs, and nothing is said to."""
    assert describe(compare(flat(0.1), flat(0.1)))[1:] == [
        "azimuth: equal everywhere",
        "azimuth on the sky: equal everywhere",
        "zenith distance: equal everywhere",
    ]


def test_difference_has_place_size_and_direction():
    """One changed cell is found, with its sign, size and place."""
    new = flat(0.1)
    new.d_zd_deg[2, 3] -= 0.004
    line = describe(compare(new, flat(0.1)))[-1]

    assert "1 differ, 0 % upward" in line
    assert "most -4.0000 mdeg at azimuth 20, zenith distance 40" in line


def test_tables_on_other_grids_meet_where_they_can():
    """Only common points are compared; none in common is an error."""
    other = Grid(np.arange(10.0, 90, 20), np.arange(0.0, 90, 20))
    difference = compare(flat(1), flat(0.5, other))

    assert list(difference.grid.az_deg) == [10, 30]
    assert list(difference.grid.zd_deg) == [20, 40]
    np.testing.assert_allclose(difference.az_deg, 0.5, atol=1e-12)
    with pytest.raises(BadInput, match="no point in common"):
        compare(flat(1), flat(1, Grid(np.array([0.5, 1.5]), np.array([0.5, 1.5]))))


def test_azimuth_differences_are_taken_the_short_way():
    """Offsets of 179 and -179 deg are 2 deg apart; on the sky they shrink with sin z."""
    difference = compare(flat(179), flat(-179))

    np.testing.assert_allclose(difference.az_deg, -2, atol=1e-12)
    np.testing.assert_allclose(difference.on_sky_deg[:, 2], -1, atol=1e-12)


def test_exact_and_approximate_form_agree_but_at_the_zenith():
    """Beyond 3 deg from the zenith the two published forms differ by less than 0.1 mdeg."""
    grid = Grid(np.arange(-180.0, 181, 15), np.arange(3.0, 90))
    exact = tabulate("rt32-exact", grid=grid, reading="float64")
    difference = compare(tabulate("rt32-approximate", grid=grid, reading="float64"), exact)

    assert np.max(np.abs(difference.on_sky_deg)) < 1e-4
    assert np.max(np.abs(difference.zd_deg)) < 1e-4


def test_picture_is_a_png(tmp_path):
    """The comparison is drawn into a file."""
    picture(compare(flat(1), flat(0.5)), tmp_path / "a.png", "new - old")

    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
