"""The points at which the ports are held to the oracle reach every decision of the routines."""

import math
import sys

import numpy as np
import pytest
import rt32_inputs as points
from rt32 import of_legacy, part, size
from rt32_inputs import around, edges

from pyport import legacy
from pyport.angles import DEG
from pyport.pointing import jump_altitude


def test_table_has_the_published_grid():
    """541 azimuths times 95 zenith distances, those running fastest, Model3 everywhere."""
    at = points.table()

    assert size(at) == 541 * 95 == 51395
    assert at["az"][0] == np.float32(-270 * DEG)
    assert at["alt"][[0, 94]] == pytest.approx([95 * DEG, 1 * DEG])
    assert (at["p"] == points.MODEL3_DEG).all()


def test_random_points_are_reproducible_and_spread():
    """One seed gives one set; azimuths, altitudes and parameters fill their ranges."""
    at, again = points.random(20_000, 1), points.random(20_000, 1)

    np.testing.assert_array_equal(at["az"], again["az"])
    np.testing.assert_array_equal(at["p"], again["p"])
    assert (at["az"].min() / DEG, at["az"].max() / DEG) == pytest.approx((-270, 270), abs=1)
    assert at["alt"].min() / DEG == pytest.approx(-5, abs=0.1)
    assert np.abs(at["p"][at["p"] != 0]).min() < 2e-6
    assert np.abs(at["p"]).max() > 0.9
    assert (at["p"] == 0).mean() == pytest.approx(0.1, abs=0.02)


def test_random_points_crowd_at_the_branches():
    """Hundreds of points in 20,000 lie within 3 ulp of the zenith, the horizon and the curve."""
    at = points.random(20_000, 2)
    ulp = np.spacing(np.float32(1.2))

    assert (np.abs(at["alt"] - np.float32(math.pi / 2)) <= 3 * ulp).sum() > 200
    assert (np.abs(at["alt"]) <= 3 * ulp).sum() > 200
    assert (np.abs(at["alt"] - jump_altitude(at["az"])) <= 3 * ulp).sum() > 200


def test_every_side_of_the_guarded_arcsine_is_reached(monkeypatch):
    """The argument of model.f:33 is taken below -1, between, above 1, and NaN."""
    arguments = []
    module = sys.modules["pyport.legacy.model"]
    guarded = module._arcsin
    monkeypatch.setattr(module, "_arcsin", lambda arg: arguments.append(arg) or guarded(arg))
    of_legacy(edges())
    arguments = np.array(arguments)

    assert (arguments < -1).any()
    assert (arguments > 1).any()
    assert (np.abs(arguments) < 1).any()
    assert np.isnan(arguments).any()


def test_every_side_of_the_jump_is_reached():
    """Above, on and below the curve east and west of south; above, on and below the horizon."""
    at = edges()
    sane = np.isfinite(at["az"]) & np.isfinite(at["alt"]) & (np.abs(at["az"]) < 5)
    az, alt = at["az"][sane], at["alt"][sane]
    jump = np.array([legacy.hjump(*pair) for pair in zip(az, alt, strict=True)])
    on_the_curve = np.abs(alt - jump_altitude(az)) < 2 * np.spacing(np.float32(1.2))

    for side in (az <= 0, az > 0):
        assert (side & on_the_curve & (jump == 1)).any()
        assert (side & on_the_curve & (jump == 0)).any()
        assert (side & (alt < 0) & (jump > 50)).any()
    assert ((alt == 0) & (jump == 0)).any()


def test_neighbours_are_neighbours():
    """`around` gives a REAL*4 and the nearest ones on both sides."""
    middle, below, above, *_ = np.float32(around(1.0, 2))

    assert (below, above) == (
        np.nextafter(middle, np.float32(0)),
        np.nextafter(middle, np.float32(2)),
    )


def test_part_keeps_points_and_parameters_together():
    """A part of some points has their parameters."""
    at = points.random(1000, 3)
    some = part(at, slice(450, 460))

    np.testing.assert_array_equal(some["p"], at["p"][450:460])
    assert size(some) == 10
