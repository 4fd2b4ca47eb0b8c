"""The table as its own program computed it: roundings, wrapped azimuth, plunge, refraction."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from steering.feasible import tilted_over_the_shoulder

from pyport import legacy
from pyport.angles import DEG
from pyport.effects.sky.atmosphere import mean_refraction
from pyport.pointing import exact_offsets, recovered
from pyport.pointing.exact import tilted
from pyport.steering import as_written

pytestmark = pytest.mark.usefixtures("both_paths")

real4 = np.float32
P4 = (recovered() / DEG).astype(real4)


@given(st.integers(-180, 180), st.integers(1, 89))
def test_is_routine_model_short_of_the_zenith(az_deg, zd_deg):
    """On every grid point with positive zenith distance it equals the port of Model bit for bit."""
    az4, alt4 = real4(az_deg * DEG), real4((90 - zd_deg) * DEG)

    assert as_written.exact4(az4, alt4, P4) == legacy.model(az4, alt4, P4)


@given(st.floats(-math.pi, math.pi), st.floats(-0.1, 1.5), st.floats(-1e-4, 1e-4))
def test_tilt_short_of_the_zenith_is_the_routines(az, alt, tilt):
    """Only in plunge does the program's way with the tilt differ."""
    az, alt = np.float64(az), np.float64(alt)
    expected = tilted(az, alt, tilt, -tilt / 2)

    np.testing.assert_allclose(
        tilted_over_the_shoulder(az, alt, tilt, -tilt / 2), expected, atol=1e-15
    )


@given(st.floats(-math.pi, math.pi), st.floats(91 * DEG, 95 * DEG))
def test_tilt_in_plunge_differs_in_second_order(az, alt):
    """In plunge a tilt t turns azimuth by another t^2 tan^2 H at most, altitude by t^2 tan H."""
    az, alt = np.float64(az), np.float64(alt)
    t = 3e-5
    theirs = tilted_over_the_shoulder(az, alt, t, 0.0)
    ours = tilted(az, alt, t, 0.0)

    assert abs(theirs[0] - ours[0]) <= 1.1 * (t * math.tan(alt)) ** 2
    assert abs(theirs[1] - ours[1]) <= 1.1 * t**2 * abs(math.tan(alt))


@pytest.mark.parametrize(
    ("az_deg", "expected"), [(-270, 90), (-181, 179), (-180, -180), (180, 180), (270, -90)]
)
def test_azimuth_is_wrapped_and_both_ends_kept(az_deg, expected):
    """What the program passed for a column of the table."""
    assert as_written.wrapped_deg(az_deg) == expected


def test_columns_a_turn_apart_agree():
    """With azimuth wrapped, Az and Az + 360 differ by the REAL*4 grid alone, the jump included."""
    zd_deg = np.arange(1.0, 90)
    for az_deg in (-270.0, -200.0, -181.0):
        turn = [[real4(as_written.wrapped_deg(az) * DEG) for az in (az_deg, az_deg + 360)]]
        for low, high in turn:
            for zd in zd_deg:
                alt4 = real4((90 - zd) * DEG)
                one = as_written.exact4(low, alt4, P4)
                other = as_written.exact4(high, alt4, P4)

                assert abs(one[0] - other[0]) <= 2.0**-15
                assert abs(one[1] - other[1]) < 1e-6


def test_offsets_at_plus_270_stand_on_the_grid_and_at_minus_270_do_not():
    """The printed rows' own trace: steps of 2^-15 deg at one end of the cable only."""
    alt4 = real4((90 - np.arange(20, 89)) * DEG)
    west, east = (
        np.array([as_written.exact4(real4(az * DEG), alt, P4)[0] for alt in alt4], float) * 2**15
        for az in (90, -90)
    )

    assert np.all(east == np.rint(east))
    assert np.mean(west == np.rint(west)) < 0.1


@given(st.floats(-5, 89))
def test_refraction_has_the_sign_of_the_zenith_distance(zd_deg):
    """R in REAL*4 is the formula `rt32-table` with the sign of z, to 2e-7 deg."""
    expected = math.copysign(mean_refraction("rt32-table", (90 - abs(zd_deg)) * DEG) / DEG, zd_deg)

    assert abs(as_written.refraction4(zd_deg) - expected) < 2e-7


@given(st.floats(-math.pi, math.pi), st.floats(1 * DEG, 89 * DEG))
def test_is_the_exact_form_within_real4(az, alt):
    """Off the 2^-15 deg grid the offsets are the float64 model's within REAL*4 rounding."""
    az4, alt4 = real4(az), real4(alt)
    d_az, d_alt = exact_offsets(float(az4), float(alt4), recovered())
    ours = as_written.exact4(az4, alt4, P4)
    rounding = 2.0**-16 + 1e-6

    assert abs(ours[0] - d_az / DEG) < rounding
    assert min(abs(ours[1] - d_alt / DEG), abs(abs(ours[1] - d_alt / DEG) + P4[11])) < 1e-6
