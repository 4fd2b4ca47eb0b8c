"""Tables of any model, on any grid, by any reading."""

from __future__ import annotations

import numpy as np
import pytest

from pyport.errors import BadInput
from pyport.steering import Grid, tabulate
from pyport.steering.grid import span
from pyport.steering.tabulate import Conditions

MODEL = """
name = "mine"
[[term]]
effect = "azimuth_zero"
value_arcsec = 36
[[term]]
effect = "collimation"
value_arcsec = 72
[[term]]
effect = "sag_cosine"
value_arcsec = 36
"""
GRID = Grid(np.arange(0.0, 361, 30), np.array([0.0, 30, 60, 89]))


@pytest.fixture
def model(tmp_path):
    """Return the path of a model with three terms."""
    path = tmp_path / "mine.toml"
    path.write_text(MODEL)
    return str(path)


def test_table_of_a_toml_model(model):
    """Azimuth offsets are a + b / sin z, zenith-distance offsets -g sin z - R."""
    table = tabulate(model, "none", GRID)
    sine = np.sin(np.radians(GRID.zd_deg[1:]))

    np.testing.assert_allclose(table.d_az_deg[:, 1:], [0.01 + 0.02 / sine] * 13, atol=1e-12)
    np.testing.assert_allclose(table.d_zd_deg[:, 1:], [-0.01 * sine] * 13, atol=1e-12)
    assert table.reading == "float64"


def test_refraction_lowers_the_zenith_distance(model):
    """At 60 deg refraction takes a hundred arcseconds off, whichever formula is chosen."""
    without = tabulate(model, "none", GRID)
    for name in ("bennett-improved", "saemundsson", "rt32-table", "field-system"):
        lifted = tabulate(model, name, GRID).d_zd_deg - without.d_zd_deg

        np.testing.assert_allclose(lifted[:, 2] * 3600, -101, atol=14)


def test_azimuth_at_the_zenith_is_held_to_a_quarter_turn(model):
    """Where azimuth has no meaning the table holds 90 deg, not infinity."""
    table = tabulate(model, "none", GRID)

    assert np.all(np.abs(table.d_az_deg[:, 0]) == 90)


def test_model_without_coefficients_is_refused():
    """A list of terms that nobody fitted makes no table."""
    with pytest.raises(BadInput, match="no coefficients"):
        tabulate("altaz", None, GRID)


def test_model_that_needs_more_than_a_direction_is_refused(tmp_path):
    """A term in hour angle cannot stand in a table of azimuth and zenith distance."""
    path = tmp_path / "wave.toml"
    path.write_text('[[term]]\neffect = "hour_angle_wave"\nvalue_arcsec = [1, 2]\n')
    with pytest.raises(BadInput, match="needs hour_angle"):
        tabulate(str(path), None, GRID)


@pytest.mark.parametrize(
    "words",
    [("nowhere", None, "as-written"), ("rt32-exact", "x", "float64"), ("rt32-exact", None, "x")],
)
def test_unknown_names_are_refused(words):
    """A model, refraction or reading that does not exist is told."""
    name, refraction, reading = words
    with pytest.raises(BadInput, match="called"):
        tabulate(name, refraction, GRID, reading)


def test_readings_differ_where_they_should():
    """Routine and as-written part where the cable is past half a turn, by the jump."""
    grid = Grid(np.array([-100.0, 260]), np.arange(10.0, 21))
    ours = tabulate(grid=grid).d_zd_deg
    cable = tabulate(grid=grid, reading="routine").d_zd_deg

    np.testing.assert_allclose(ours[0], cable[0], atol=1e-6)
    np.testing.assert_allclose(ours[1], ours[0], atol=1e-6)
    assert np.all(np.abs(ours[1] - cable[1]) > 0.02)


def test_float64_reading_is_within_single_precision():
    """Off the zenith double precision and the published program differ by REAL*4 rounding."""
    grid = Grid(np.arange(-180.0, 181, 20), np.arange(5.0, 90, 7))
    single, double = (tabulate(grid=grid, reading=one) for one in ("as-written", "float64"))

    np.testing.assert_allclose(single.d_az_deg, double.d_az_deg, rtol=0, atol=1.6e-5)
    np.testing.assert_allclose(single.d_zd_deg, double.d_zd_deg, rtol=0, atol=1e-6)


def test_span_includes_both_ends():
    """0:1:0.25 is five values; steps that miss the end, or no numbers, are refused."""
    np.testing.assert_array_equal(span("0:1:0.25"), [0, 0.25, 0.5, 0.75, 1])
    for wrong in ("0:1:0.3", "1:0:0.5", "0:1", "a:b:c", "0:1:0", "0:inf:1", "2:2:1"):
        with pytest.raises(BadInput, match=wrong.replace(":", ".")):
            span(wrong)


@pytest.mark.parametrize("model", ["rt32-3model", "rt32-exact", "rt32-approximate"])
def test_the_rt32_s_azimuth_starts_at_south(model):
    """Its form has no other zero."""
    with pytest.raises(BadInput, match="counts azimuth from south"):
        tabulate(model, "none", GRID, beside=Conditions("north"))
