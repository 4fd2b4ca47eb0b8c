"""The sky is ERFA's, and each step that is left out leaves what it should."""

import erfa
import numpy as np
import pytest

from pyport.angles import ARCSEC, DEG
from pyport.examiner.worlds import sky
from pyport.examiner.worlds.earth import SITES, dynamical, julian_date, motion, orientation
from pyport.examiner.worlds.sky import sources

SITE = SITES["rt32"]
AIR = sky.Air(1000.0, 10.0, 0.6)


def up():
    """Return positions and times, 2003 and 2004, of sources above 8 degrees."""
    catalogue = sources()
    time_s = np.linspace(1.05e9, 1.085e9, 40 * len(catalogue.ra))
    ra, dec = np.tile(catalogue.ra, 40), np.tile(catalogue.dec, 40)
    el = sky.observed(ra, dec, time_s, SITE, AIR).el
    high = (el > 8 * DEG) & (el < 85 * DEG)
    return ra[high], dec[high], time_s[high]


def shift(*left_out):
    """Return how far sources seem to move [arcsec] when steps are left out, (x, y)."""
    where = up()
    full = sky.observed(*where, SITE, AIR)
    less = sky.observed(*where, SITE, AIR, sky.STEPS - set(left_out))
    x = (full.az - less.az + np.pi) % (2 * np.pi) - np.pi
    return x * np.cos(full.el) / ARCSEC, (full.el - less.el) / ARCSEC


def test_all_steps_together_are_erfas_own_reduction():
    """Nothing differs from atco13 (IAU 2006/2000A) by more than 2 mas."""
    ra, dec, time_s = up()
    place = sky.observed(ra, dec, time_s, SITE, AIR)
    dut1, x, y = orientation(time_s)
    az, zenith_distance, *_ = erfa.atco13(
        ra, dec, 0, 0, 0, 0, *julian_date(time_s), dut1, SITE.longitude, SITE.latitude,
        SITE.height_m, x, y, 1000.0, 10.0, 0.6, 1e6,
    )  # fmt: skip

    assert np.abs((place.az - az) * np.cos(place.el)).max() / ARCSEC < 2e-3
    assert np.abs(np.pi / 2 - zenith_distance - place.el).max() / ARCSEC < 2e-3


@pytest.mark.parametrize(
    ("step", "least", "most"),
    [
        ("annual_aberration", 20.0, 20.9),
        ("diurnal_aberration", 0.17, 0.21),
        ("nutation", 8.0, 20.0),
        ("precession", 150.0, 260.0),
        ("polar_motion", 0.2, 0.7),
        ("ut1", 4.0, 8.0),
    ],
)
def test_a_step_left_out_moves_sources_by_what_is_known_of_it(step, least, most):
    """The greatest shift is that of the books: 20.5 arcsec of aberration, 50 a year precession."""
    greatest = np.hypot(*shift(step)).max()

    assert least < greatest < most


@pytest.mark.slow
def test_refraction_left_out_is_sixty_arcsec_at_45_deg():
    """Radio refraction is about 60 arcsec times cot E, in elevation alone."""
    x, y = shift("refraction")
    ra, dec, time_s = up()
    el = sky.observed(ra, dec, time_s, SITE, AIR).el
    high = el > 30 * DEG

    assert np.abs(x).max() < 0.1
    np.testing.assert_allclose((y * np.tan(el))[high], 60, atol=8)


def test_the_interpolated_earth_is_erfas():
    """Place and velocity are epv00's to 1e-7 au and 1e-8 of the velocity, at any minute."""
    time_s = 1.05e9 + np.arange(0, 3e6, 1234.5)
    from_sun, moving = motion(time_s)
    sun, barycentre = erfa.epv00(*dynamical(time_s))

    np.testing.assert_allclose(from_sun, sun["p"], atol=1e-7)
    np.testing.assert_allclose(moving["v"], barycentre["v"], atol=2e-10)


def test_orientation_needs_no_network_and_is_that_of_iers():
    """UT1-UTC was +0.717 s on 1999 January 1 and -0.390 s on 2004 January 1."""
    dut1, pole_x, pole_y = orientation(np.array([915148800.0, 1072915200.0]))

    np.testing.assert_allclose(dut1, [0.717, -0.390], atol=1e-3)
    assert np.all(np.hypot(pole_x, pole_y) / ARCSEC < 0.6)
