"""Refraction as an effect: by cot E and by the formulae of the literature."""

from __future__ import annotations

import numpy as np
import pytest

from pyport.angles import DEG
from pyport.effects import CATALOGUE, Circumstances
from pyport.effects.sky.atmosphere import SHAPES, formula_of_refraction, mean_refraction


def looking(*el_deg: float) -> Circumstances:
    """Return pointings at azimuth zero."""
    el = np.array(el_deg) * DEG
    return Circumstances(az=np.zeros(len(el)), el=el)


@pytest.mark.parametrize("name", SHAPES)
def test_shape_is_the_formula_over_its_value_at_45_degrees(name):
    """The coefficient is the refraction at 45 deg; nothing moves across elevation."""
    x, y = formula_of_refraction(name).columns(looking(5, 20, 45, 70))
    expected = mean_refraction(name, np.array([5, 20, 45, 70]) * DEG) / mean_refraction(
        name, 45 * DEG
    )

    assert not x.any()
    np.testing.assert_allclose(y[:, 0], expected, rtol=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_refraction_lifts_toward_the_zenith_from_either_side(name):
    """In plunge the elevation counter is moved the other way by as much."""
    _, y = formula_of_refraction(name).columns(looking(85, 95))

    assert y[0, 0] == pytest.approx(-y[1, 0], abs=1e-12)
    assert abs(y[0, 0]) > 0.05


def test_below_the_horizon_shapes_stay_finite():
    """The last half degree is held constant, as cot E is."""
    for name in SHAPES:
        _, y = formula_of_refraction(name).columns(looking(-1, 0, 0.5))

        assert np.all(np.isfinite(y))
        assert np.all(y == y[2])


def test_formulae_are_tried_only_where_they_can_be_told_apart():
    """With elevations below 10 deg every formula is a variant; above, cot E alone."""
    effect = CATALOGUE["refraction"]

    assert [one.variant for one in effect.variants(looking(5, 60))] == ["", *SHAPES]
    assert [one.variant for one in effect.variants(looking(15, 60))] == [""]
