"""What the digits tell: the refraction, and the parameters inside their rounding."""

from __future__ import annotations

import numpy as np
import pytest
from steering.feasible import feasible

from pyport.pointing import PARAMETERS, printed, recovered
from pyport.pointing.exact import tilted
from pyport.pointing.parameters import PRINTED_ROUNDING
from pyport.steering.check import candidates, refraction_bounds

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def answer():
    """Return the linear programme's answer for the table's own program."""
    return feasible()


def test_bounds_on_refraction_are_tight_where_rows_are_printed_in_full():
    """At 88 and 89 deg R is known to 1e-7 deg; elsewhere to less than a millidegree."""
    bounds = refraction_bounds()
    width_deg = bounds.high_deg - bounds.low_deg

    assert np.all(width_deg > 0)
    assert np.all(width_deg < 1e-3)
    assert np.all(width_deg[-2:] <= 1.01e-7)


def test_refraction_is_not_zero_at_the_zenith_and_has_the_sign_of_z():
    """At 0.1 deg R is 0.6 to 0.9 arcsec; at -5 deg it is negative."""
    bounds = refraction_bounds()

    assert bounds.low_deg[bounds.zd_deg == 0.1][0] * 3600 > 0.6
    assert bounds.high_deg[bounds.zd_deg == -5][0] < 0


def test_one_formula_reproduces_every_zenith_cell_and_no_other_does():
    """Of all candidates the recovered one alone gives 149 of 149; each has its residual."""
    found = {(one.name, one.iterations): one for one in candidates()}

    assert found["rt32-table", 0].agree == found["rt32-table", 0].total == 149
    assert [key for key, one in found.items() if one.agree == one.total] == [("rt32-table", 0)]
    assert found["bennett-improved", 1].outside_deg.max() < 1e-3
    assert 0.35 < found["none", 0].outside_deg.max() < 0.36


def test_parameters_inside_their_rounding_reproduce_everything(answer):
    """584 printed numbers have a common solution, and the shipped parameters are in it."""
    half = PRINTED_ROUNDING * 1.000001

    assert answer.excess_deg == 0
    assert answer.binding == ()
    assert np.all(np.abs(answer.low - printed()) <= half)
    assert np.all(np.abs(answer.high - printed()) <= half)
    assert np.all(answer.low <= recovered())
    assert np.all(recovered() <= answer.high)


def test_digits_tell_the_sag_to_a_ten_thousandth_of_an_arcsecond(answer):
    """Of p2 and p7 the rounding leaves 1e-6 deg open; the table's digits leave 3e-8."""
    width_deg = np.degrees(answer.high - answer.low)

    assert PARAMETERS[6].name == "Sag"
    assert width_deg[1] < 4e-8
    assert width_deg[6] < 4e-8


def test_routine_as_printed_cannot_give_the_rows_in_plunge():
    """With Model's own tilt in plunge some full row stays out of its rounding by 1.9e-7 deg."""
    without = feasible(tilted)

    assert without.excess_deg == pytest.approx(1.87e-7, abs=1e-9)
    assert without.low is None
    assert {where for where in without.binding if "azimuth" in where[0]} == {
        ("full rows, azimuth", -270.0, zd) for zd in (-5.0, -4.0, 89.0)
    }


def test_another_refraction_is_infeasible():
    """Bennett's formula, iterated to rest, misses rows by thousands of a degree."""
    assert feasible(refraction_name="bennett-improved").excess_deg > 1e-3
