"""Figures 3 to 5 show what is left, and say where the data come from."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pyport.angles import ARCSEC, DEG
from pyport.effects import Circumstances
from pyport.pointing import Rt32Model, printed
from pyport.recordings.schema import Recordings
from pyport.studies.rt32 import fit_rt32
from pyport.studies.rt32.sky import (
    Residuals,
    distributions,
    residuals,
    smooth,
    smoothed,
    vectors,
    write_figures,
)


@pytest.fixture(scope="module")
def fit():
    """Return a fit to 800 offsets, said to be simulated."""
    rng = np.random.default_rng(0)
    at = Circumstances(az=rng.uniform(-90, 450, 800) * DEG, el=rng.uniform(8, 84, 800) * DEG)
    x, y = Rt32Model(printed()).offsets(at) + 15 * ARCSEC * rng.normal(size=(2, 800))
    altitude = np.arange(800) % 2 == 0
    x[altitude], y[~altitude], x[1] = np.nan, np.nan, 0.5 * DEG
    nothing = np.full(800, np.nan)
    meta = {"simulated": "here"}
    return fit_rt32(Recordings(at, x, y, nothing, nothing, np.arange(800), Path("made.csv"), meta))


def here(value, az_deg=0.0, altitude_deg=45.0):
    """Return residuals [rad] at one place in the sky, or at as many as are given."""
    value = np.asarray(value, float)
    return Residuals(
        np.full(value.shape, az_deg) * DEG, np.full(value.shape, altitude_deg) * DEG, value
    )


def averaged(left, az_deg, altitude_deg):
    """Return the smoothed residual at one place [rad]."""
    return smoothed(left, np.array([az_deg]) * DEG, np.array([altitude_deg]) * DEG)[0]


def test_residuals_are_split_by_axis(fit):
    """Azimuth residuals come first, altitude residuals second, none lost."""
    across, along = residuals(fit)

    assert len(across.value) == len(along.value) == 400
    np.testing.assert_array_equal(np.concatenate([across.value, along.value]), fit.residual)
    np.testing.assert_allclose(across.az_south, fit.recordings.at.az[1::2] - np.pi)


def test_smoothing_weighs_by_the_cosine_of_the_distance():
    """At the centre one, half way out cos 45 deg, from 5 deg on nothing."""
    left = Residuals(
        np.zeros(4), np.array([45.0, 45.0, 47.5, 50.1]) * DEG, np.array([1, 1, 4, 9]) * ARCSEC
    )
    weight = np.cos(np.pi / 4)

    assert averaged(left, 0.0, 45.0) / ARCSEC == pytest.approx((2 + 4 * weight) / (2 + weight))


def test_smoothing_leaves_out_what_is_large():
    """Residuals beyond 0.01 deg have no part in an average."""
    left = here([1 * ARCSEC, 1 * ARCSEC, 1 * ARCSEC, 0.0101 * DEG])

    assert averaged(left, 0.0, 45.0) == pytest.approx(1 * ARCSEC)


def test_smoothing_needs_three_on_the_same_turn():
    """Two residuals are no average, nor are three that the cable reaches the other way round."""
    assert np.isnan(averaged(here([1e-5, 1e-5]), 0.0, 45.0))
    assert np.isnan(averaged(here([1e-5] * 3, az_deg=-100.0), 260.0, 45.0))
    assert averaged(here([1e-5] * 3, az_deg=260.0), 260.0, 45.0) == pytest.approx(1e-5)


def test_smoothing_measures_distance_on_the_sky():
    """At 80 deg altitude 25 deg of azimuth are less than 5 deg of the sky."""
    left = here([1e-5] * 3, az_deg=25.0, altitude_deg=80.0)

    assert averaged(left, 0.0, 80.0) == pytest.approx(1e-5)
    assert np.isnan(averaged(left, -5.0, 80.0))


@pytest.mark.parametrize("draw", [vectors, smooth, distributions])
def test_every_figure_has_labels_with_units_and_says_simulated(fit, draw):
    """Both axes are named in degrees; made-up data are called so, measured ones are not."""
    figure = draw(fit)
    outer = [axes for axes in figure.axes if axes.get_xlabel() or axes.get_ylabel()]

    assert "SIMULATED" in figure.get_suptitle()
    assert any("[deg]" in axes.get_xlabel() for axes in outer)
    assert any("[deg]" in axes.get_ylabel() for axes in outer)
    measured = replace(fit, recordings=replace(fit.recordings, meta={}))
    assert "SIMULATED" not in draw(measured).get_suptitle()


def test_bars_are_residuals_to_the_scale_of_the_bar(fit):
    """A bar of figure 3 is as much longer than the scale bar as its residual is than 0.02 deg."""
    axes = vectors(fit).axes[0]
    across, _ = residuals(fit)
    small = across.value[~across.large]
    segments = np.array(axes.collections[0].get_segments())
    bar = next(line for line in axes.lines if line.get_linewidth() == 2.5)

    np.testing.assert_allclose(
        (segments[:, 1, 0] - segments[:, 0, 0]) / np.ptp(bar.get_xdata()),
        small / (0.02 * DEG),
        rtol=1e-6,
        atol=1e-9,
    )


def test_the_jump_is_drawn_where_the_model_has_it(fit):
    """South of the cable's middle the curve stands at 72 deg, at 95 deg west at 55."""
    points = np.concatenate([line.get_xydata() for line in vectors(fit).axes[1].lines])

    for place in ((0.0, 72.0), (95.0, 55.0), (-180.0, 65.0)):
        assert np.min(np.hypot(*(points - place).T)) < 1e-6


def test_a_wild_offset_is_a_cross_and_not_a_bar(fit):
    """An offset of half a degree is marked, and counted in the title."""
    axes = vectors(fit).axes[0]

    assert sum(len(line.get_xdata()) for line in axes.lines if line.get_marker() == "x") == 1
    assert "1 of them beyond 0.04 deg" in axes.get_title()


@pytest.mark.slow
def test_figures_are_written_the_same_every_time(fit, tmp_path):
    """Three PNG files, the same bytes for the same fit."""
    once, again = (write_figures(fit, tmp_path / name) for name in ("once", "again"))

    assert [path.name for path in once] == ["figure-3.png", "figure-4.png", "figure-5.png"]
    for one, other in zip(once, again, strict=True):
        assert one.read_bytes() == other.read_bytes()
