"""An effect seen in both axes: one coefficient must come out of either."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyport.fitting.two_axes import difference


def _sky(n, seed):
    """Return columns of offsets and of a tilt on n pointings, and which rows are elevations."""
    rng = np.random.default_rng(seed)
    az, el = rng.uniform(0, 2 * np.pi, n), np.arcsin(rng.uniform(0.2, 0.98, n))
    zero, sin_a, cos_a, sin_e = np.zeros(n), np.sin(az), np.cos(az), np.sin(el)
    others = np.stack([np.r_[np.ones(n), zero], np.r_[zero, np.ones(n)]], axis=1)
    tilt = np.stack([np.r_[sin_e * sin_a, cos_a], np.r_[-sin_e * cos_a, sin_a]], axis=1)
    return others, tilt, np.repeat([False, True], n)


def _compared(others, tilt, is_y, data, **given):
    first, second = tilt * ~is_y[:, None], tilt * is_y[:, None]
    return difference(others, first, second, data, **given)


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.integers(0, 50))
def test_one_tilt_is_the_same_in_both_axes(north, east, seed):
    """Without noise each axis gives the tilt that was put in, and nothing differs."""
    others, tilt, is_y = _sky(30, seed)
    found = _compared(others, tilt, is_y, tilt @ [north, east] + others @ [3.0, -7.0])

    assert found.first == pytest.approx([north, east], abs=1e-6)
    assert found.second == pytest.approx([north, east], abs=1e-6)
    assert found.chi2 < 1e-12


def test_chances_are_uniform_where_both_are_one():
    """Of many tilts in noise of unit scatter a tenth comes out below 0.1."""
    others, tilt, is_y = _sky(40, 1)
    rng = np.random.default_rng(2)
    chances = [
        _compared(others, tilt, is_y, tilt @ [5, 1] + rng.normal(size=80)).p_value
        for _ in range(1000)
    ]

    # Errors that never narrow below unit scatter make the test a little timid.
    assert np.mean(np.array(chances) < 0.1) == pytest.approx(0.09, abs=0.025)
    assert np.mean(np.array(chances) < 0.5) == pytest.approx(0.47, abs=0.05)


@given(st.floats(3, 50))
def test_scatter_beyond_unity_widens_the_errors(scatter):
    """Errors go with scatter above unity, and stay where it is below."""
    others, tilt, is_y = _sky(40, 3)
    noise = np.random.default_rng(4).normal(size=80)
    calm, less, three, more = (
        _compared(others, tilt, is_y, size * noise) for size in (0.1, 0.2, 3.0, scatter)
    )

    assert calm.sigma_first == pytest.approx(less.sigma_first)
    assert more.sigma_first == pytest.approx(three.sigma_first * scatter / 3)


def test_an_effect_of_one_axis_is_not_compared():
    """What moves elevation alone has nothing to be compared with."""
    others, tilt, is_y = _sky(30, 5)

    assert _compared(others, tilt * is_y[:, None], is_y, tilt[:, 0]) is None


def test_a_coefficient_that_one_axis_leaves_open_is_passed_over():
    """Cross-elevation at one azimuth shows one component of the tilt; only that is compared."""
    others, tilt, is_y = _sky(30, 6)
    tilt[~is_y, 1] = 0
    found = _compared(others, tilt, is_y, tilt @ [2.0, 3.0])

    assert found.of.tolist() == [0]
    assert found.first == pytest.approx([2.0])


def test_axes_that_differ_by_many_sigmas_are_told_so():
    """Ten arcseconds against three, with an error of a few tenths, is beyond chance."""
    others, tilt, is_y = _sky(60, 7)
    data = tilt @ [3.0, 0.0] + 7 * tilt[:, 0] * is_y + np.random.default_rng(8).normal(size=120)
    found = _compared(others, tilt, is_y, data, dof=110.0)

    assert found.sigmas > 8
    assert found.second[0] - found.first[0] == pytest.approx(7, abs=4 * found.sigma_first[0])
