"""Rays through layers of air bend as they are known to."""

import erfa
import numpy as np
import pytest

from pyport.angles import ARCSEC, DEG
from pyport.examiner.worlds.sky import Air, bending, refractivity

AIR = Air(np.array([1005.0]), np.array([10.0]), np.array([0.6]))


@pytest.mark.parametrize(("el_deg", "within"), [(80, 0.02), (45, 0.01), (20, 0.01), (10, 0.015)])
def test_layers_bend_as_erfas_coefficients_say(el_deg, within):
    """From 10 to 80 degrees the ray's bending is refco's to one or two per cent."""
    a, b = erfa.refco(1005.0, 10.0, 0.6, 1e6)
    (lift,) = bending(np.array([el_deg * DEG]), AIR)
    cot = 1 / np.tan(el_deg * DEG + lift)

    assert lift == pytest.approx(a * cot + b * cot**3, rel=within)


def test_refractivity_at_the_ground_is_that_of_the_books():
    """Dry air of 1013.25 hPa and 0 deg C has 288; it is less than a third of it at 10 km."""
    ground, high = refractivity(np.array([0.0, 10e3]), Air(1013.25, 0.0, 0.0))[0]

    assert ground == pytest.approx(288.2, abs=0.3)
    assert high < ground / 3


def test_moist_air_bends_more():
    """At 25 deg C saturated air bends a quarter to a half more than dry air."""
    el = np.array([30 * DEG])
    dry, wet = (bending(el, Air(np.array([1000.0]), np.array([25.0]), np.array([h])))[0]
                for h in (0.0, 1.0))  # fmt: skip

    assert 1.25 < wet / dry < 1.55
    assert dry / ARCSEC == pytest.approx(92, abs=4)
