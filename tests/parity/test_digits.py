"""Which program printed the published digits."""

import numpy as np
import pytest
import rt32_digits as digits
from rt32 import of_oracle
from rt32_inputs import MODEL3_DEG, points

PROMOTED, AS_PRINTED, REDUCED = range(3)


@pytest.fixture(scope="module")
def tried():
    """Return the three hypotheses, tried."""
    return digits.hypotheses()


def test_rows_at_270_are_the_reference_at_minus_90(tried):
    """Called with azimuth -90 deg the reference prints both rows at 270 to the last digit."""
    az_deg, _, printed = digits.printed_rows()
    there = az_deg == 270

    assert there.sum() == 2
    assert np.abs(tried[REDUCED].answers_deg - printed)[there] == pytest.approx(0, abs=0.51e-7)
    assert tried[REDUCED].coarse.tolist() == there.tolist()


def test_no_parameters_let_the_promoted_program_print_the_rows(tried):
    """Whatever the parameters behind the printed ones, promotion misses a row by 100 units."""
    assert tried[PROMOTED].violation_deg > 100e-7


def test_azimuth_as_printed_is_no_multiple_of_the_step(tried):
    """Called with -270 deg the reference would print multiples of 2**-15 deg; the page has none."""
    assert tried[AS_PRINTED].coarse.sum() == 4
    assert tried[AS_PRINTED].off_grid_deg > 100e-7


def test_reduced_azimuth_explains_all_rows_but_two_units(tried):
    """With azimuth reduced the grid fits to the last digit, all rows to 2 units of it."""
    assert tried[REDUCED].off_grid_deg <= 0.5e-7
    assert tried[REDUCED].violation_deg < 2e-7


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle")
def test_reference_and_promoted_build_say_the_same(tried):
    """The compiled builds answer as the ports that the hypotheses were tried with."""
    az_deg, zd_deg, _ = digits.printed_rows()
    at = points(np.radians(az_deg), np.radians(90 - zd_deg), MODEL3_DEG)
    converted = of_oracle(at)[:, 0]
    promoted = of_oracle(at, "promoted")[:, 0]

    assert tried[AS_PRINTED].answers_deg.tolist() == converted.tolist()
    assert tried[PROMOTED].answers_deg == pytest.approx(promoted, abs=1e-7)
