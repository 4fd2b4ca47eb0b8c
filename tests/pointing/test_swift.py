"""The quick evaluation against the formulae as they are written, and against fifty digits."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyport.angles import DEG, wrap
from pyport.effects import Circumstances
from pyport.pointing import approximate_columns, recovered, swift
from pyport.pointing.exact import formulae
from pyport.pointing.leaning import Axis

pytestmark = pytest.mark.usefixtures("both_paths")

azimuths = st.floats(-270 * DEG, 270 * DEG)
altitudes = st.floats(-5 * DEG, 95 * DEG)
small = st.floats(-0.05 * DEG, 0.05 * DEG)
parameters = st.lists(small, min_size=12, max_size=12)


def fifty_digits(az, alt, p):
    """Return the exact offsets in fifty digits: the printed routine's formulae."""
    with mpmath.workdps(50):
        az, alt = mpmath.mpf(az), mpmath.mpf(alt)
        az0, alt0, sigma, beta, xi, zeta, sag, sag_sine, sin_2a, cos_2a, nod, _ = map(mpmath.mpf, p)
        facing = 1 if mpmath.cos(alt) > 0 else -1
        sin_eta = facing * mpmath.hypot(mpmath.sin(xi), mpmath.sin(zeta))
        cos_eta = mpmath.sqrt(1 - sin_eta**2)
        toward = mpmath.atan2(mpmath.sin(zeta), mpmath.sin(xi))
        level = mpmath.cos(alt)
        turn = mpmath.atan2(
            level * mpmath.sin(toward - az),
            mpmath.sin(alt) * sin_eta - level * cos_eta * mpmath.cos(toward - az),
        ) - mpmath.atan2(mpmath.sin(toward), -cos_eta * mpmath.cos(toward))
        read = mpmath.asin(cos_eta * mpmath.sin(alt) + sin_eta * level * mpmath.cos(toward - az))
        turn -= az
        if facing < 0:
            turn, read = mpmath.pi - turn, mpmath.pi - read
        skew = mpmath.asin(
            (mpmath.sin(sigma) * mpmath.sin(read) + mpmath.sin(beta))
            / (mpmath.cos(read) * mpmath.cos(sigma))
        )
        set_to = mpmath.atan2(
            mpmath.sin(read) * mpmath.cos(sigma)
            + mpmath.cos(read) * mpmath.sin(sigma) * mpmath.sin(skew),
            mpmath.cos(read) * mpmath.cos(skew),
        )
        sine, cosine = mpmath.sin(2 * az), mpmath.cos(2 * az)
        d_az = turn + skew + az0 + sin_2a * sine + cos_2a * cosine
        d_az -= 2 * mpmath.pi * mpmath.nint(d_az / (2 * mpmath.pi))
        d_alt = set_to - alt + alt0 + sag * level + sag_sine * mpmath.sin(alt) + nod * sine
        return d_az, d_alt


@given(azimuths, altitudes, parameters)
def test_exact_offsets_are_those_of_the_formulae(az, alt, p):
    """Everywhere but in the blind spot, to the rounding of a double over the cosine."""
    if abs(math.cos(alt)) < math.sin(0.2 * DEG):
        return
    d_az, d_alt = swift.exact(az, alt, p)
    expected_az, expected_alt = formulae(az, alt, p)

    assert abs(wrap(d_az - expected_az)) < 2e-15 / abs(math.cos(alt))
    assert abs(d_alt - expected_alt) < 2e-15 / abs(math.cos(alt))


def test_grid_is_within_1e_12_of_fifty_digits():
    """On points of the table's grid, one degree and more off the zenith; between them 0.1 deg."""
    p = recovered()
    rng = np.random.default_rng(3)
    points = [(a * DEG, (90 - z) * DEG) for a in range(-270, 271, 27) for z in (-5, -1, 1, 30, 89)]
    points += list(zip(rng.uniform(-4.7, 4.7, 40), rng.uniform(-0.08, 1.569, 40), strict=True))
    for az, alt in points:
        d_az, d_alt = swift.exact(az, alt, [*p[:-1], 0.0])
        true_az, true_alt = fifty_digits(az, alt, p)

        assert abs(mpmath.mpf(float(d_az)) - true_az) < 1e-12
        assert abs(mpmath.mpf(float(d_alt)) - true_alt) < 1e-12


@given(azimuths, altitudes, parameters)
def test_approximate_offsets_are_the_sum_of_their_effects(az, alt, p):
    """The effects' columns times the parameters, over the cosine in azimuth."""
    if abs(math.cos(alt)) < math.sin(0.2 * DEG):
        return
    x, y = approximate_columns(Circumstances(np.array([az + math.pi]), np.array([alt])))
    d_az, d_alt = swift.approximate(az, alt, p)

    assert abs(wrap(d_az - float(x[0] @ p) / math.cos(alt))) < 1e-15 / abs(math.cos(alt))
    assert abs(d_alt - float(y[0] @ p)) < 1e-15


def test_columns_are_those_of_the_effects():
    """All over the sky, below the horizon and in plunge."""
    rng = np.random.default_rng(2)
    az, alt = rng.uniform(-90, 450, 500) * DEG, rng.uniform(-5, 95, 500) * DEG

    quick = swift.approximate_columns(Axis.of(az - math.pi), Axis.of_altitudes(alt))

    for one, other in zip(quick, approximate_columns(Circumstances(az, alt)), strict=True):
        for k, column in enumerate(other.T):
            np.testing.assert_allclose(one.get(k, np.zeros(500)), column, atol=2e-15)


@pytest.mark.parametrize("form", [swift.exact, swift.approximate])
def test_points_do_not_depend_on_their_company(form, monkeypatch):
    """A grid by its axes, the same points one by one and in blocks of three agree to the bit."""
    az = np.linspace(-4.7, 4.7, 7)
    alt = np.concatenate([np.linspace(-0.08, 1.65, 11), [np.pi / 2 - 1e-5, np.pi / 2]])
    p = recovered()
    grid = form(az[:, None], alt, p)
    flat = form(*(one.ravel() for one in np.meshgrid(az, alt, indexing="ij")), p)
    alone = [form(a, h, p) for a in az for h in alt]
    monkeypatch.setattr(swift, "BLOCK", 3)
    in_blocks = form(az[:, None], alt, p)

    for axis in (0, 1):
        np.testing.assert_array_equal(grid[axis].ravel(), flat[axis])
        np.testing.assert_array_equal(grid[axis].ravel(), [one[axis] for one in alone])
        np.testing.assert_array_equal(grid[axis], in_blocks[axis])


def test_shapes_broadcast():
    """Any shapes that broadcast, of any number of axes."""
    az, alt = np.zeros((2, 1, 3)), np.full((4, 1), 0.5)

    d_az, d_alt = swift.exact(az, alt, recovered())

    assert d_az.shape == d_alt.shape == (2, 4, 3)
    assert np.all(d_az == d_az.flat[0])


@pytest.mark.parametrize("form", [swift.exact, swift.approximate])
def test_what_is_no_number_hides_nothing_beside_it(form):
    """Plunge and what no setting reaches are themselves, whatever else is in the block."""
    p = [*recovered()[:2], 0.3 * DEG, 0.2 * DEG, *recovered()[4:]]
    az, alt = np.array([1.0, 1.0, 2.0, 3.0, 4.0]), np.array([95.0, 90.0, np.nan, 45.0, -5.0]) * DEG
    together = np.array(form(az, alt, p))
    alone = np.array([form(one, other, p) for one, other in zip(az, alt, strict=True)]).T

    np.testing.assert_array_equal(together, alone)
    assert np.isnan(together).tolist() == [[False, False, True, False, False]] * 2


@pytest.mark.parametrize("form", [swift.exact, swift.approximate])
def test_an_infinite_parameter_gives_no_number(form):
    """It is no reason to stop: no table would come out, and neither would a word why."""
    p = list(recovered())
    p[3] = np.inf

    assert np.isnan(form(1.0, 0.5, p)[0])
