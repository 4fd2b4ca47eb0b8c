"""Effects together: small ones add up, whatever their sizes and wherever the telescope stands."""

import erfa
import numpy as np
from effects.mount import encoders
from hypothesis import given, settings
from hypothesis import strategies as st

from pyport.angles import ARCSEC, DEG
from pyport.effects import CATALOGUE, Circumstances, Site

sizes = st.floats(-60, 60).map(lambda arcsec: arcsec * ARCSEC)
latitudes = st.floats(-89, 89).map(lambda degrees: degrees * DEG)

AZ, EL = (one.ravel() for one in np.meshgrid(np.linspace(0, 6, 13), np.linspace(0.1, 1.4, 9)))
AT = Circumstances(AZ, EL)


@settings(max_examples=50, deadline=None)
@given(st.tuples(sizes, sizes, sizes, sizes, sizes, sizes, sizes))
def test_flaws_of_a_mount_add_up(flaws):
    """Seven flaws at once give the sum of seven effects, but for their products."""
    zero_az, zero_el, beam, axle, north, east, sag = flaws
    x, y = encoders(
        AZ,
        EL,
        read_az=lambda _: zero_az,
        read_el=lambda _: zero_el,
        beam_left=beam,
        right_end_up=axle,
        lean=(north, east),
        droop=lambda el: sag * np.cos(el),
    )
    names = "azimuth_zero", "elevation_zero", "collimation", "skew", "tilt", "sag_cosine"
    columns = [CATALOGUE[name].columns(AT) for name in names]
    across, along = (np.concatenate([one[axis] for one in columns], axis=1) for axis in (0, 1))
    products = np.sum(np.abs(flaws)) ** 2 * np.tan(EL.max())

    np.testing.assert_allclose(across @ flaws, x, rtol=0, atol=products + 1e-13)
    np.testing.assert_allclose(along @ flaws, y, rtol=0, atol=products + 1e-13)


@settings(deadline=None)
@given(latitudes)
def test_speed_of_the_sky_is_the_cosine_of_declination(latitude):
    """An hour-angle shift moves a source by cos Dec, at every site and in every direction."""
    at = Circumstances(AZ, EL, Site(latitude))
    x, y = CATALOGUE["clock"].columns(at)
    _, dec = erfa.ae2hd(AZ, EL, latitude)

    np.testing.assert_allclose(np.hypot(x, y)[:, 0], np.cos(dec), atol=1e-12)


@settings(deadline=None)
@given(latitudes, st.floats(-60, 60))
def test_longitude_is_a_turn_of_the_mount(latitude, arcsec):
    """A longitude error turns azimuth by sin phi of it and tilts toward the west by cos phi."""
    at = Circumstances(AZ, EL, Site(latitude))
    size = arcsec * ARCSEC
    turn = size * np.sin(latitude), 0.0, size * np.cos(latitude)
    parts = [CATALOGUE[name].columns(at) for name in ("azimuth_zero", "tilt")]

    for axis, whole in enumerate(CATALOGUE["site_longitude"].columns(at)):
        sum_of_parts = np.concatenate([one[axis] for one in parts], axis=1) @ turn
        np.testing.assert_allclose(size * whole[:, 0], sum_of_parts, rtol=0, atol=1e-15)


@settings(deadline=None)
@given(latitudes, st.floats(-30, 30), st.floats(-30, 30))
def test_lags_of_one_size_are_a_late_clock(latitude, lag_s, other_s):
    """Both axes late by the same time is a clock that is late; the two lags are independent."""
    at = Circumstances(AZ, EL, Site(latitude))
    azimuth = CATALOGUE["servo_lag_azimuth"].columns(at)
    elevation = CATALOGUE["servo_lag_elevation"].columns(at)
    clock = CATALOGUE["clock"].columns(at)
    turn = 15.041067 * ARCSEC

    np.testing.assert_allclose(azimuth[0] * lag_s, clock[0] * lag_s * turn, rtol=1e-12)
    np.testing.assert_allclose(elevation[1] * other_s, clock[1] * other_s * turn, rtol=1e-12)
    assert not azimuth[1].any()
    assert not elevation[0].any()


@settings(deadline=None)
@given(latitudes)
def test_what_rises_does_so_at_any_latitude(latitude):
    """So the play of the elevation drive needs none on an altitude-azimuth mount."""
    known, unknown = (
        CATALOGUE["backlash_elevation"].columns(at)
        for at in (Circumstances(AZ, EL, Site(latitude)), AT)
    )
    rate = CATALOGUE["servo_lag_elevation"].columns(Circumstances(AZ, EL, Site(latitude)))[1]

    np.testing.assert_array_equal(known[1], np.sign(rate))
    np.testing.assert_array_equal(unknown[1], known[1])
