"""Mean refraction: known values, and what every formula must do."""

from __future__ import annotations

import numpy as np
import pytest

from pyport.angles import ARCMIN, ARCSEC, DEG
from pyport.effects.sky.atmosphere import FORMULAE, mean_refraction
from pyport.errors import BadInput

PHYSICAL = sorted(set(FORMULAE) - {"none"})


@pytest.mark.parametrize("name", PHYSICAL)
def test_refraction_at_45_degrees(name):
    """Halfway up every formula gives one arcminute within 8 arcsec, those for radio included."""
    assert mean_refraction(name, 45 * DEG) / ARCSEC == pytest.approx(59, abs=8)


def test_bennett_as_meeus_prints_it():
    """An apparent altitude of half a degree stands 28.754' above the true one."""
    improved, plain = FORMULAE["bennett-improved"], FORMULAE["bennett"]

    assert plain.arcmin(np.array(0.5)) == pytest.approx(28.754, abs=5e-4)
    assert improved.arcmin(np.array(0.5)) == pytest.approx(28.7, abs=0.06)


def test_bennett_by_iteration_is_consistent_with_itself():
    """R of the true altitude equals the formula at the apparent altitude that it leads to."""
    true = np.array([1.0, 5, 20, 60]) * DEG
    lifted = mean_refraction("bennett-improved", true, iterations=30)
    again = FORMULAE["bennett-improved"].arcmin((true + lifted) / DEG)

    np.testing.assert_allclose(lifted / ARCMIN, again, rtol=0, atol=1e-9)


def test_saemundsson_inverts_bennett():
    """The formula for true altitudes was made to agree with Bennett's: to 0.1' above 1 deg."""
    true = np.linspace(1, 85, 50) * DEG
    difference = mean_refraction("saemundsson", true) - mean_refraction("bennett", true)

    assert np.max(np.abs(difference)) < 0.1 * ARCMIN


def test_none_is_zero():
    """No refraction is a choice like any other."""
    assert np.all(mean_refraction("none", np.linspace(0.1, 1.5, 4)) == 0)


def test_unknown_name_is_told_with_the_known_ones():
    """A wrong name is answered with the list of names."""
    with pytest.raises(BadInput, match=r"'benett'.*bennett-improved"):
        mean_refraction("benett", 1.0)
