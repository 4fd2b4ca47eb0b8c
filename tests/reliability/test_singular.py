"""Where formulae are singular, answers are defined: zenith, horizon, poles, no tilt, blind spot."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyport.angles import DEG
from pyport.effects import CATALOGUE, Circumstances, MissingColumn, Site
from pyport.pointing import (
    PARAMETERS,
    approximate_offsets,
    exact_offsets,
    has_jumped,
    jump_altitude,
)

#: Zenith, horizon, plunge's end, nadir's side; the cardinal points and full turns of the cable.
ALTITUDES = np.array([math.pi / 2, 0.0, 95 * DEG, -5 * DEG, math.nextafter(math.pi / 2, 0)])
AZIMUTHS = np.array([0.0, math.pi / 2, math.pi, -math.pi, 2 * math.pi, -1.5 * math.pi])
AZ, EL = (one.ravel() for one in np.meshgrid(AZIMUTHS, ALTITUDES))
SIZES = st.floats(-0.5 * DEG, 0.5 * DEG)


@pytest.mark.parametrize("offsets", [exact_offsets, approximate_offsets])
def test_a_telescope_without_errors_points_where_it_is_told_to(offsets):
    """No tilt, no skew, nothing: exactly nothing, at the zenith and below the horizon too."""
    d_az, d_alt = offsets(AZ, EL, np.zeros(len(PARAMETERS)))

    np.testing.assert_array_equal(d_az, 0)
    np.testing.assert_allclose(d_alt, 0, atol=3e-16)


@given(st.lists(SIZES, min_size=len(PARAMETERS), max_size=len(PARAMETERS)))
def test_the_exact_form_is_finite_wherever_formulae_are_singular(p):
    """Half a degree of anything, at zenith and horizon, in the blind spot and out of it."""
    assert np.isfinite(exact_offsets(AZ, EL, np.array(p))).all()


@given(SIZES, SIZES)
def test_tilt_zero_is_the_limit_of_small_tilts(north, east):
    """A tilt a million times smaller moves a million times less, down to none at all."""
    low = EL < 80 * DEG
    p = np.zeros(len(PARAMETERS))
    p[4], p[5] = north, east
    whole = np.stack(exact_offsets(AZ[low], EL[low], 1e-3 * p))
    small = np.stack(exact_offsets(AZ[low], EL[low], 1e-9 * p))

    np.testing.assert_allclose(small, 1e-6 * whole, rtol=1e-3, atol=2e-16)


def test_the_curve_of_the_jump_is_defined_everywhere():
    """At every azimuth of the cable, and on either side of it."""
    assert np.isfinite(jump_altitude(AZ)).all()
    assert set(np.unique(has_jumped(AZ, EL))) <= {False, True}


def circumstances(latitude):
    """Return every singular direction, both celestial poles too, with all that effects ask for."""
    az = np.concatenate([AZ, [0.0, math.pi]])
    el = np.concatenate([EL, [latitude, -latitude]])
    n = len(az)
    rng = np.random.default_rng(2)
    columns = {
        "time": 1.2e9 + 4e4 * np.arange(n),
        "hour_angle": np.where(np.arange(n) % 2 == 0, 0.0, math.pi),
        "ra": np.zeros(n),
        "dec": np.where(np.arange(n) % 3 == 0, math.pi / 2, latitude),
        "scan_direction": rng.choice([-1.0, 0.0, 1.0], n),
        "scan_rate": np.zeros(n),
        "sun_az": az,
        "sun_el": el,
        "wind_az": az,
        **{
            name: np.where(np.arange(n) % 2 == 0, value, 0.0)
            for name, value in (
                ("temperature_c", -40.0),
                ("humidity_pct", 100.0),
                ("pressure_hpa", 1100.0),
                ("wind_speed_m_s", 50.0),
                ("frequency_mhz", 327.0),
            )
        },
        **{
            name: np.where(np.arange(n) % 2 == 0, "one", "other")
            for name in ("source", "session", "receiver", "channel", "polarisation")
        },
    }
    return Circumstances(az, el, Site(latitude, 0.3), columns)


@pytest.mark.parametrize("latitude", [0.0, 0.9, math.pi / 2, -math.pi / 2])
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_every_effect_is_finite_in_singular_directions(latitude):
    """At zenith, horizon, both celestial poles, the Sun's own place; at equator and poles."""
    at = circumstances(latitude)
    seen = 0
    for effect in CATALOGUE.values():
        try:
            told = [(one, one.columns(at)) for one in effect.variants(at)]
        except MissingColumn:
            continue
        for one, columns in told:
            assert np.isfinite(columns).all(), (one.id, one.variant)
            seen += 1

    assert seen > 100
