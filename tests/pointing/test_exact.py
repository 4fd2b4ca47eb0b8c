"""The exact form against the printed routine, the approximate form, and rotation matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyport.angles import ARCSEC, DEG, wrap
from pyport.pointing import approximate_offsets, exact_offsets, printed
from pyport.pointing.exact import skewed, tilted

pytestmark = pytest.mark.usefixtures("both_paths")

azimuths = st.floats(-270 * DEG, 270 * DEG)
altitudes = st.floats(-5 * DEG, 89 * DEG)
small = st.floats(-0.05 * DEG, 0.05 * DEG)


def printed_routine(az, alt, p):
    """Follow the arithmetic of routine Model line by line, in double precision."""
    xi, zeta, sigma, beta = p[4], p[5], p[2], p[3]
    sh, ch = math.sin(alt), math.cos(alt)
    se = math.copysign(math.hypot(math.sin(xi), math.sin(zeta)), ch)
    ce = math.sqrt(1 - se * se)
    alfa = math.atan2(math.sin(zeta), math.sin(xi))
    at_az = math.atan2(
        ch * math.sin(alfa - az), sh * se - ch * ce * math.cos(alfa - az)
    ) - math.atan2(math.sin(alfa), -ce * math.cos(alfa))
    at_az -= az
    ht = math.asin(ce * sh + se * ch * math.cos(alfa - az))
    if ch < 0:
        at_az, ht = math.pi - at_az, math.pi - ht
    sine = (math.sin(sigma) * math.sin(ht) + math.sin(beta)) / (math.cos(ht) * math.cos(sigma))
    d_az = math.asin(min(1, max(-1, sine)))
    hb = math.atan2(
        math.sin(ht) * math.cos(sigma) + math.cos(ht) * math.sin(sigma) * math.sin(d_az),
        math.cos(ht) * math.cos(d_az),
    )
    d_az += at_az + p[0] + p[8] * math.sin(2 * az) + p[9] * math.cos(2 * az)
    d_alt = hb - alt + p[1] + p[6] * ch + p[7] * sh + p[10] * math.sin(2 * az)
    return float(wrap(d_az)), d_alt


@given(azimuths, st.floats(-5 * DEG, 95 * DEG), st.lists(small, min_size=11, max_size=11))
def test_equals_the_printed_routine_within_rounding(az, alt, p):
    """Everywhere from -5 to 95 deg the offsets are the routine's, to its own rounding.

    The routine takes the arc sine of a number near 1, which costs it half its digits
    near the zenith: 1e-8 rad, and in azimuth that over the cosine of altitude.
    """
    if abs(math.cos(alt)) < math.sin(0.2 * DEG):
        return  # the blind spot has its own test
    d_az, d_alt = exact_offsets(az, alt, [*p, 0.0])
    d_az_routine, d_alt_routine = printed_routine(az, alt, p)

    rounding = 4e-16 / math.cos(alt) ** 2 + 4e-15
    assert abs(wrap(d_az - d_az_routine)) < 40 * rounding
    assert abs(d_alt - d_alt_routine) < 40 * rounding


@given(azimuths, altitudes, small, small)
def test_tilt_is_a_rotation_of_the_sky(az, alt, xi, zeta):
    """A tilted mount reads the direction turned by one rotation that carries its axis upright."""
    toward = math.atan2(math.sin(zeta), math.sin(xi))
    eta = math.asin(math.hypot(math.sin(xi), math.sin(zeta)))
    about = np.array([math.sin(toward), -math.cos(toward), 0.0])
    cross = np.cross(np.eye(3), about)
    rotation = np.eye(3) + math.sin(eta) * cross + (1 - math.cos(eta)) * cross @ cross
    axis = [math.sin(eta) * math.cos(toward), math.sin(eta) * math.sin(toward), math.cos(eta)]
    np.testing.assert_allclose(rotation @ axis, [0, 0, 1], atol=1e-15)

    def read(direction):
        x, y, z = rotation @ direction
        return math.atan2(y, x), math.asin(np.clip(z, -1, 1))

    az_read, alt_read = read(
        [math.cos(alt) * math.cos(az), math.cos(alt) * math.sin(az), math.sin(alt)]
    )
    south = read([1.0, 0.0, 0.0])[0]
    turn, alt_tilted = tilted(np.float64(az), np.float64(alt), xi, zeta)

    # near the zenith azimuths lose meaning as 1/cos
    assert abs(wrap(az_read - south - az - turn)) * math.cos(alt) < 1e-14
    assert abs(alt_read - alt_tilted) < 1e-12


@given(altitudes, small, small)
def test_skew_and_box_put_the_beam_on_the_source(altitude, sigma, beta):
    """Turned by the axes' settings, a beam off a skewed axis points where the source is."""
    turn, setting = skewed(np.float64(altitude), sigma, beta)
    if abs(turn) > 1.5:
        return  # the blind spot
    # at azimuth 0 the elevation axis points west, its west end raised by sigma
    axis = np.array([0, math.cos(sigma), math.sin(sigma)])
    along = np.array([1.0, 0, 0])
    up = np.cross(along, axis)
    boresight = math.cos(setting) * along + math.sin(setting) * up
    beam = math.cos(beta) * boresight - math.sin(beta) * axis
    azimuth_of_beam = math.atan2(beam[1], beam[0])

    assert abs(math.asin(beam[2]) - altitude) < 1e-12
    assert abs(azimuth_of_beam + turn) * math.cos(altitude) < 1e-12


@given(azimuths, st.floats(0, 80 * DEG))
def test_approximate_form_agrees_away_from_the_zenith(az, alt):
    """With the published parameters both forms agree within 0.02 arcsec below 80 deg."""
    exact = exact_offsets(az, alt, printed())
    rough = approximate_offsets(az, alt, printed())

    np.testing.assert_allclose(exact, rough, rtol=0, atol=0.02 * ARCSEC)


@given(azimuths, st.floats(90.2 * DEG, 95 * DEG))
def test_plunge_follows_the_same_conventions_in_both_forms(az, alt):
    """Beyond the zenith both forms turn the tilt's sign in altitude."""
    d_az, d_alt = exact_offsets(az, alt, printed())
    d_az_rough, d_alt_rough = approximate_offsets(az, alt, printed())

    assert abs(d_alt - d_alt_rough) < 0.2 * ARCSEC
    assert abs((d_az - d_az_rough) * math.cos(alt)) < 0.2 * ARCSEC


def test_offsets_take_any_shape():
    """Azimuth and altitude broadcast; every element equals the scalar answer."""
    az = np.linspace(-4, 4, 5)[:, None]
    alt = np.linspace(0.1, 1.5, 7)
    d_az, d_alt = exact_offsets(az, alt, printed())

    assert d_az.shape == d_alt.shape == (5, 7)
    one = exact_offsets(az[3, 0], alt[2], printed())
    assert (d_az[3, 2], d_alt[3, 2]) == (one[0], one[1])


def test_blind_spot_stops_a_quarter_turn_away():
    """Closer to the zenith than |sigma + beta| the azimuth stops 90 deg off, finite."""
    p = printed() * [0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0]
    edge = abs(p[2] + p[3])
    inside = exact_offsets(0.0, math.pi / 2 - 0.9 * edge, p)
    outside = exact_offsets(0.0, math.pi / 2 - 1.1 * edge, p)

    assert abs(inside[0]) == math.pi / 2
    assert abs(outside[0]) < 1.2
    assert abs(outside[0]) > 1.0
    assert np.all(np.isfinite(exact_offsets(0.3, [math.pi / 2, 0.0], printed())))


def test_azimuth_offset_is_wrapped():
    """An encoder zero of 350 deg is reported as -10 deg."""
    d_az, _ = exact_offsets(0.2, 0.5, np.eye(12)[0] * 350 * DEG)

    assert abs(d_az + 10 * DEG) < 1e-14
