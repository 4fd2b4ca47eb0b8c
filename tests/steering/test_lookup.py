"""Offsets between the nodes, their errors, and what is asked outside."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyport.errors import BadInput
from pyport.steering import Grid, Table, offsets_at, tabulate
from pyport.steering.lookup import answers, interpolation_errors
from pyport.steering.tabulate import offsets_of

pytestmark = pytest.mark.usefixtures("both_paths")

GRID = Grid(np.arange(-270.0, 271, 10), np.arange(-5.0, 90))
AZ_DEG, ZD_DEG = GRID.points_deg()
PLANE = Table(GRID, 0.1 * AZ_DEG + ZD_DEG, AZ_DEG * ZD_DEG)


@given(st.floats(-270, 270), st.floats(-5, 89))
def test_interpolation_is_exact_for_what_is_linear_in_each(az_deg, zd_deg):
    """A plane and a product of both coordinates come out as they are."""
    d_az, d_zd = offsets_at(PLANE, az_deg, zd_deg)

    assert d_az == pytest.approx(0.1 * az_deg + zd_deg, abs=1e-9)
    assert d_zd == pytest.approx(az_deg * zd_deg, abs=1e-8)


def test_nodes_are_answered_as_they_stand():
    """At a grid point the answer is the table's number, at the last one too."""
    d_az, d_zd = offsets_at(PLANE, AZ_DEG, ZD_DEG)

    np.testing.assert_array_equal(d_az, PLANE.d_az_deg)
    np.testing.assert_array_equal(d_zd, PLANE.d_zd_deg)


@pytest.mark.parametrize(
    ("az_deg", "zd_deg", "said"),
    [
        (270.5, 10, "azimuth 270.5"),
        (-270.001, 10, "azimuth"),
        (0, 89.5, "zenith distance 89.5"),
        (0, float("nan"), "zenith distance nan"),
    ],
)
def test_outside_is_said(az_deg, zd_deg, said):
    """Beyond the table there is no answer, and NaN is beyond."""
    with pytest.raises(BadInput, match=said):
        offsets_at(PLANE, az_deg, zd_deg)


def test_batch_answers_line_by_line():
    """Each line is answered before the next is asked for; a bad one is told by its number."""
    asked = []

    def lines():
        for line in ("10 20\n", "\n", "-270 89\n", "10\n"):
            asked.append(line)
            yield line

    stream = answers(PLANE, lines(), "targets")

    assert next(stream).split()[:2] == ["10.0000000", "20.0000000"]
    assert asked == ["10 20\n"]
    assert next(stream).split()[0] == "-270.0000000"
    with pytest.raises(BadInput, match=r"targets:4: expected azimuth"):
        next(stream)


def test_batch_outside_names_the_line():
    """A target outside the table is told by file and line."""
    with pytest.raises(BadInput, match=r"targets:1: azimuth 999"):
        list(answers(PLANE, ["999 20"], "targets"))


def test_errors_are_large_at_the_zenith_and_across_the_jump_only():
    """Between 1 and 80 deg interpolation is good to a millidegree, but where the jump runs."""
    grid = Grid(np.arange(-180.0, 181, 1), np.arange(-5.0, 90))
    table = tabulate(grid=grid, reading="float64")
    bands = interpolation_errors(table, offsets_of("rt32-3model", "rt32-table", "float64"))
    by_band = {(one.zd_from_deg, one.zd_to_deg): one for one in bands}

    assert by_band[-1, 1].az_max_deg > 0.1
    for one in bands[2:-1]:
        assert one.az_max_deg < 1e-3
        assert one.zd_max_deg < 1e-3
    assert sum(one.steps for one in bands) > 100
    assert max(one.step_deg for one in bands) == pytest.approx(0.0102, abs=1e-4)
    assert by_band[80, 89].zd_max_deg == pytest.approx(3.24e-3, abs=1e-4)


def test_numbers_stay_apart_where_azimuth_is_far_off():
    """Near the zenith by more than a hundred degrees."""
    far = Table(GRID, np.full(AZ_DEG.shape, -100.3402176), np.full(AZ_DEG.shape, 0.1))
    (answer,) = answers(far, ["-260 0"], "targets")

    assert [float(one) for one in answer.split()] == [-260, 0, -100.3402176, 0.1]
