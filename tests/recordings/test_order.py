"""Where no time is recorded: whether the order of the rows stands for it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pyport.angles import Array
from pyport.recordings import read
from pyport.recordings.sky import clock, horizon, with_nights


def raster() -> tuple[Array, Array]:
    """Return a grid along azimuth."""
    az, el = np.meshgrid(np.arange(10.0, 350.0, 20.0), np.arange(10.0, 80.0, 10.0))
    return az.ravel(), el.ravel()


def columns_of_elevation() -> tuple[Array, Array]:
    """Return a grid along elevation."""
    el, az = np.meshgrid(np.arange(10.0, 80.0, 5.0), np.arange(10.0, 350.0, 60.0))
    return az.ravel(), el.ravel()


def followed() -> tuple[Array, Array]:
    """Return one source in three nights of ten hours."""
    hour_angle = np.tile(np.radians(np.linspace(-75.0, 75.0, 40)), 3)
    az, el = horizon(hour_angle, np.full(len(hour_angle), np.radians(20.0)), np.radians(53.0))
    return np.degrees(az) % 360, np.degrees(el)


def stars() -> tuple[Array, Array]:
    """Return directions in any order."""
    rng = np.random.default_rng(1)
    return rng.uniform(0, 360, 80), rng.uniform(10, 85, 80)


def ring() -> tuple[Array, Array]:
    """Return directions of one elevation, in any order."""
    return np.random.default_rng(2).uniform(0, 360, 80), np.full(80, 45.0)


@pytest.mark.parametrize(
    ("places", "in_order"),
    [
        (raster, False),
        (columns_of_elevation, False),
        (followed, True),
        (stars, True),
        (ring, True),
    ],
)
def test_order_stands_for_time_unless_the_rows_run_along_a_grid(
    tmp_path: Path, places: Callable[[], tuple[Array, Array]], *, in_order: bool
) -> None:
    """Lines of a grid along one coordinate are a table's; a source moves in both."""
    az, el = places()
    path = tmp_path / "places.csv"
    lines = [f"{a:.6f},{e:.6f},1.0,2.0" for a, e in zip(az, el, strict=True)]
    path.write_text("\n".join(["az_deg,el_deg,d_xel_arcsec,d_el_arcsec", *lines]) + "\n")
    recordings = with_nights(read(path))
    assert np.isfinite(clock(recordings.at)).any() == in_order
    assert ("order_from" in recordings.meta) == in_order
