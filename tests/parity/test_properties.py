"""What the models must do beyond agreeing with the Fortran: geometry, periods, limits, inverses."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from rt32_inputs import MODEL3_DEG

from pyport import legacy
from pyport.angles import ARCSEC, DEG, wrap
from pyport.pointing import approximate_offsets, exact_offsets, has_jumped, printed

azimuths = st.floats(-270 * DEG, 270 * DEG)
altitudes = st.floats(-5 * DEG, 85 * DEG)
tilts = st.floats(-1 * DEG, 1 * DEG)
small = st.lists(st.floats(-0.05 * DEG, 0.05 * DEG), min_size=11, max_size=11)


def only(**values):
    """Return twelve parameters [rad], zero but for those named p1 to p12."""
    p = np.zeros(12)
    for name, value in values.items():
        p[int(name[1:]) - 1] = value
    return p


def read(az, alt, p):
    """Return what the encoders read for a true direction [rad]."""
    d_az, d_alt = exact_offsets(az, alt, p)
    return az + d_az, alt + d_alt


def unit_vector(az, alt):
    """Return the direction as a vector, x to the south, y to the west, z up."""
    return np.array([np.cos(alt) * np.cos(az), np.cos(alt) * np.sin(az), np.sin(alt)])


@given(azimuths, altitudes, azimuths, altitudes, tilts, tilts)
def test_tilt_keeps_the_angles_between_directions(az1, alt1, az2, alt2, xi, zeta):
    """A tilt alone is a rotation: two sources are as far apart to the encoders as in the sky."""
    p = only(p5=xi, p6=zeta)
    true = unit_vector(az1, alt1) @ unit_vector(az2, alt2)
    seen = unit_vector(*read(az1, alt1, p)) @ unit_vector(*read(az2, alt2, p))

    assert seen == pytest.approx(true, abs=1e-13)


@given(azimuths, st.floats(5 * DEG, 80 * DEG), small)
def test_approximate_form_tends_to_the_exact_one_as_the_square(az, alt, p):
    """A tenth of the parameters leaves a hundredth of the difference between the two forms."""
    p = np.array([*p, 0.0])

    def difference(scale):
        exact, approximate = (
            exact_offsets(az, alt, scale * p),
            approximate_offsets(az, alt, scale * p),
        )
        return np.hypot(wrap(exact[0] - approximate[0]) * math.cos(alt), exact[1] - approximate[1])

    bound = (np.abs(p[2:6]).sum() / math.cos(alt)) ** 2

    assert difference(1) <= 2 * bound + 1e-15
    assert difference(0.1) <= 2 * bound / 100 + 1e-15


@given(azimuths, st.floats(0.1, 1.5), small)
def test_a_full_turn_changes_nothing_but_the_jump(az, alt, p):
    """Azimuth plus 360 deg is the same direction; only the curve of Hjump counts the cable."""
    p = np.array([*p, 0.0])
    here, there = exact_offsets(az, alt, p), exact_offsets(az + 2 * math.pi, alt, p)

    assert abs(wrap(here[0] - there[0])) < 1e-12 / math.cos(alt)
    assert abs(here[1] - there[1]) < 1e-13
    step = exact_offsets(az, alt, only(p12=1e-3))[1] - exact_offsets(az, alt, only())[1]
    assert step == pytest.approx(1e-3 * has_jumped(az, alt), abs=1e-14)


def test_the_jump_counts_the_cable():
    """At -100 and 260 deg, one direction, the curve is at 69.5 and at 105.4 deg."""
    az = np.float32([-100 * DEG, 260 * DEG])
    curve = [legacy.hjump(one, np.float32(-0.1)) for one in az]

    assert curve == pytest.approx(
        [65 + 7 * math.cos(50 * DEG), 55 + (165 / 90) ** 2 * 15], abs=1e-4
    )


@given(azimuths, st.floats(0, 80 * DEG), small)
def test_the_inverse_undoes_the_model(az, alt, p):
    """The direction found by iteration from what the encoders read is the true one."""
    p = np.array([*p, 0.0])
    az_read, alt_read = read(az, alt, p)
    az_found, alt_found = az_read, alt_read
    for _ in range(12):
        d_az, d_alt = exact_offsets(az_found, alt_found, p)
        az_found, alt_found = az_read - d_az, alt_read - d_alt

    assert abs(wrap(az_found - az)) * math.cos(alt) < 1e-12
    assert abs(alt_found - alt) < 1e-12


@given(azimuths, st.floats(80 * DEG, 89 * DEG), tilts, tilts)
def test_tilt_in_plunge_turns_the_azimuth_as_from_the_front(az, alt, xi, zeta):
    """Over the shoulder a source needs the same azimuth correction for a tilt, to 2nd order."""
    assume(math.hypot(xi, zeta) < 0.1 * math.cos(alt))
    p = only(p5=xi, p6=zeta)
    plunging, facing = exact_offsets(az, math.pi - alt, p), exact_offsets(az + math.pi, alt, p)
    size = math.hypot(xi, zeta) * math.tan(alt)

    assert abs(plunging[0] - facing[0]) <= 2 * size**2 + 1e-13


@given(azimuths, st.floats(80 * DEG, 89 * DEG), st.floats(-0.01 * DEG, 0.01 * DEG))
def test_skew_and_box_in_plunge_turn_the_azimuth_the_other_way(az, alt, angle):
    """Seen over the shoulder the sky lies on the other side: skew and box change their sign."""
    for p in (only(p3=angle), only(p4=angle)):
        plunging, facing = exact_offsets(az, math.pi - alt, p), exact_offsets(az + math.pi, alt, p)

        assert plunging[0] == pytest.approx(-facing[0], abs=1e-12)
        assert plunging[1] == pytest.approx(-facing[1], abs=1e-12)


@given(azimuths, st.floats(80 * DEG, 89 * DEG), tilts)
def test_tilt_in_plunge_has_the_altitude_offset_of_the_ledger(az, alt, xi):
    """The routines turn the sign of the tilt's altitude offset in plunge, against the geometry.

    Geometry wants minus the offset that the source has from the front, since the altitude is
    counted over the zenith; the routines, and the port with them, give plus.
    """
    p = only(p5=xi)
    plunging, facing = (
        exact_offsets(az, math.pi - alt, p)[1],
        exact_offsets(az + math.pi, alt, p)[1],
    )
    second_order = xi**2 * math.tan(alt)

    assert plunging == pytest.approx(facing, abs=2 * second_order + 1e-13)


@settings(max_examples=50)
@given(st.floats(-180, 180), st.floats(10, 80))
def test_legacy_port_agrees_with_the_vectorised_one_on_the_sky(az_deg, alt_deg):
    """With the published parameters the two ports agree to a tenth of an arcsecond."""
    az, alt = np.float32(az_deg * DEG), np.float32(alt_deg * DEG)
    assume(bool(legacy.hjump(az, alt)) == bool(has_jumped(az, alt)))
    d_az, d_alt = legacy.model(az, alt, MODEL3_DEG)
    expected = exact_offsets(float(az), float(alt), printed())

    assert abs(d_az * DEG - expected[0]) * math.cos(alt) < 0.1 * ARCSEC
    assert abs(d_alt * DEG - expected[1]) < 0.001 * ARCSEC
