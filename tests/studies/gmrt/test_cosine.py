"""A fitted cosine of hour angle: its polar form, and how far it is from a published one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from pyport.angles import ARCMIN, DEG
from pyport.studies.gmrt.curves import Cosine, columns, condition
from pyport.studies.gmrt.published import Wave

sizes = st.floats(1, 30)
signs = st.sampled_from([-1.0, 1.0])


def wave(a, b, d, of_a=0.4, of_b=0.5, of_d=3.0):
    """Return a published curve, a and b in arcmin, d in degrees."""
    units = (ARCMIN, ARCMIN, ARCMIN, ARCMIN, DEG, DEG)
    values = (a, of_a, b, of_b, d, of_d)
    return Wave("C00", "day", *(v * u for v, u in zip(values, units, strict=True)))


def fitted(like, sigma, moved=(0, 0, 0)):
    """Return a cosine near a curve, moved by some of the coefficients' sigmas [arcmin]."""
    value = np.array([like.a, like.b * np.cos(like.d), -like.b * np.sin(like.d)])
    rng = np.random.default_rng(0)
    root = sigma * ARCMIN * (np.eye(3) + 0.2 * rng.normal(size=(3, 3)))
    return Cosine(value + np.array(moved) * sigma * ARCMIN, root @ root.T)


@given(a=st.floats(-40, 40), b=sizes, sign=signs, d=st.floats(-500, 500))
def test_the_polar_form_is_the_same_curve(a, b, sign, d):
    """a, b and d come back in the branch of the curve that they are held against."""
    like = wave(a, sign * b, d)
    found = fitted(like, 0.1).polar(like)

    assert [value for value, _ in found] == pytest.approx([like.a, like.b, like.d])


@given(a=st.floats(-40, 40), b=sizes, sign=signs, d=st.floats(-500, 500))
def test_the_same_curve_is_no_sigma_away(a, b, sign, d):
    """A cosine that is the published curve differs by nothing, to the grid of phases."""
    like = wave(a, sign * b, d)

    np.testing.assert_allclose(fitted(like, 0.3).sigmas_from(like), 0, atol=0.02)


@given(
    sign=signs,
    d=st.floats(-180, 180),
    moved=st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3)),
)
def test_small_errors_give_the_difference_over_the_combined_sigma(sign, d, moved):
    """Where b is many sigmas large the profile is what everyone computes."""
    like = wave(10, 60 * sign, d, 0.3, 0.3, 0.3)
    one = fitted(like, 0.3, moved)
    expected = [
        abs(value - getattr(like, name)) / np.hypot(sigma, getattr(like, f"sigma_{name}"))
        for name, (value, sigma) in zip("abd", one.polar(like), strict=True)
    ]

    np.testing.assert_allclose(one.sigmas_from(like), expected, atol=0.05)


def test_where_errors_are_large_the_nearest_agreeing_curve_counts():
    """An ill-determined b or d is as far off as minimising over all curves finds."""
    like = wave(6, -3, 20, 0.3, 0.4, 5)
    one = fitted(like, 2.0, (1, 2, -2))
    weight = np.linalg.inv(one.covariance[1:, 1:])

    def squares(b_and_d, which):
        b, d = b_and_d[0] * ARCMIN, b_and_d[1]
        left = one.value[1:] - [b * np.cos(d), -b * np.sin(d)]
        own = ((b - like.b) / like.sigma_b, (d - like.d) / like.sigma_d)[which]
        return left @ weight @ left + own**2

    for which in (0, 1):
        best = min(
            minimize(squares, (b, d), (which,), bounds=[(-60, 0), (None, None)]).fun
            for b in (-1, -6)
            for d in (like.d, *one.polar(like)[2][:1])
        )
        assert one.sigmas_from(like)[1 + which] == pytest.approx(np.sqrt(best), abs=0.02)


def test_a_small_amplitude_leaves_the_phase_open():
    """Upside down by less than its sigma, a cosine is within a sigma or two in d."""
    like = wave(6, -0.5, 0, 0.3, 0.3, 20)
    one = fitted(like, 1.0, (0, 1.0, 0))

    assert abs(one.polar(like)[2][0]) > 170 * DEG
    assert one.sigmas_from(like)[2] < 1.5


def test_sigma_of_the_curve_is_how_curves_scatter():
    """Curves drawn by the covariance scatter about it as `sigma` says."""
    one = fitted(wave(10, -5, 30), 0.5)
    hours = np.linspace(-1.2, 1.2, 7)
    rng = np.random.default_rng(1)
    drawn = rng.multivariate_normal(one.value / ARCMIN, one.covariance / ARCMIN**2, 4000)

    scatter = (columns(hours) @ drawn.T).std(axis=1)

    np.testing.assert_allclose(one.sigma(hours) / ARCMIN, scatter, rtol=0.05)


def test_fewer_hours_trade_more():
    """The condition number grows as the hours are cut, and is small over a whole turn."""
    turn = np.linspace(-np.pi, np.pi, 100, endpoint=False)

    assert condition(turn) == pytest.approx(1, abs=0.5)
    assert condition(turn[:20]) > condition(turn[:50]) > condition(turn)
