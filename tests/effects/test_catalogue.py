"""The catalogue as a vocabulary: its ids are stable, its entries complete."""

import math

import pytest
from effects.cases import AT

from pyport.angles import ARCSEC, DEG
from pyport.effects import CATALOGUE

#: The ids that reports and scores use.
STABLE = {
    *("azimuth_zero", "elevation_zero", "collimation", "skew"),
    *("tilt", "sag_cosine", "sag_sine", "azimuth_eccentricity"),
    *("azimuth_harmonics", "elevation_harmonics", "elevation_encoder_harmonics", "azimuth_scale"),
    *("elevation_scale", "azimuth_track", "site_latitude", "site_longitude"),
    *("clock", "polar_motion", "annual_aberration", "diurnal_aberration"),
    *("nutation", "precession", "source_position", "parallax"),
    *("refraction", "refraction_curvature", "wet_refraction", "ionosphere"),
    *("scan_direction", "scan_timing", "backlash_azimuth", "backlash_elevation"),
    *("servo_lag_azimuth", "servo_lag_elevation", "thermal_tilt", "temperature"),
    *("wind_tilt", "receiver_offset", "beam_squint", "epoch_offset"),
    *("epoch_azimuth_zero", "epoch_tilt", "epoch_sag", "epoch_clock", "drift"),
    *("subreflector_jump",),
    *("nasmyth", "rotator_circle", "driven_term", "oscillation", "azimuth_turns"),
    *("clock_rate",),
}

#: Radians (or seconds, or none) in one of each unit that a report may show.
UNITS = {
    "arcsec": (ARCSEC,),
    "arcsec/deg": (ARCSEC / DEG,),
    "arcsec/K": (ARCSEC,),
    "arcsec/hPa": (ARCSEC,),
    "s": (1.0, 15 * ARCSEC),
    "s/d": (15.041067 * ARCSEC / 86400,),
    "": (1.0, 15.041067 * ARCSEC),
}

#: What physics fixes, in reported units.
KNOWN = {
    "annual_aberration": 20.4955,
    "diurnal_aberration": 0.32,
    "nutation": 1.0,
    "precession": 1.0,
    "polar_motion": 1.0,
}

#: What all antennas see alike: the sky, the air, the clock.
OF_THE_SKY = {
    *("clock", "polar_motion", "annual_aberration", "diurnal_aberration", "nutation"),
    *("precession", "source_position", "parallax", "refraction", "refraction_curvature"),
    *("wet_refraction", "ionosphere", "epoch_clock", "clock_rate"),
}


def test_ids_are_the_stable_ones():
    """Every id that reports use is there, and no other physical effect."""
    assert {one.id for one in CATALOGUE.values() if one.physical} == STABLE


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda one: one.id)
def test_entry_is_complete(effect):
    """Every effect has a sentence without a full stop, a source and a formula."""
    assert effect.sentence
    assert effect.sentence[0].islower()
    assert not effect.sentence.endswith(".")
    assert effect.citation
    assert any(effect.formula)


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda one: one.id)
def test_units_are_known(effect):
    """A coefficient's scale is that of the unit it is reported in."""
    for one in effect.coefficients:
        assert one.scale in UNITS[one.unit]


def test_known_coefficients():
    """Where physics fixes a coefficient the catalogue expects that value, and nowhere else."""
    expected = {
        effect.id: one.expected
        for effect in CATALOGUE.values()
        for one in effect.coefficients
        if one.expected is not None
    }

    assert set(expected) == set(KNOWN)
    for name, value in expected.items():
        assert math.isclose(value, KNOWN[name], rel_tol=1e-4)


def test_who_shares_a_coefficient():
    """The sky is one for all antennas, a time tag one for a session, mechanics each one's own."""
    common = {effect.id: effect.common for effect in CATALOGUE.values()}

    assert {name for name, how in common.items() if how == "array"} == OF_THE_SKY
    assert {name for name, how in common.items() if how == "session"} == {"scan_timing"}


def test_what_drives_an_effect_and_what_it_changes_with():
    """The weather drives by its column, the Sun by the hour; epochs change with the session."""
    drivers = {effect.id: effect.driver for effect in CATALOGUE.values() if effect.driver}
    changing = {effect.id for effect in CATALOGUE.values() if effect.changes_with == "session"}

    assert drivers == {
        "temperature": "temperature_c",
        "wet_refraction": "humidity_pct",
        "wind_tilt": "wind_speed_m_s",
        "thermal_tilt": "the hour",
        "drift": "the hour",
        "clock_rate": "the hour",
        "driven_term": "temperature_c",
    }
    epochs = {"azimuth_zero", "clock", "offset", "sag", "tilt"}
    assert changing == {f"epoch_{one}" for one in epochs}
    for name in changing:
        assert all(one.changes_with == "session" for one in CATALOGUE[name].variants(AT))
