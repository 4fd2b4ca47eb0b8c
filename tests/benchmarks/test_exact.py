"""The exact and the approximate form, beside the Fortran routines in a loop and katpoint."""

from __future__ import annotations

import numpy as np
import pytest

from pyport.angles import DEG
from pyport.pointing import approximate_offsets, exact_offsets, has_jumped, recovered
from pyport.steering import RT32_GRID

POINTS = 10_000_000

ROWS = {
    "test_grid": "exact-grid",
    "test_grid_in_fortran": "exact-grid",
    "test_scattered": "exact-scattered",
    "test_scattered_in_fortran": "exact-scattered",
    "test_approximate": "approximate-scattered",
    "test_approximate_by_katpoint": "approximate-scattered",
}


def axes():
    """Return the grid's azimuths and altitudes [rad]."""
    return RT32_GRID.az_deg * DEG, (90 - RT32_GRID.zd_deg) * DEG


@pytest.fixture(scope="module")
def points():
    """Return azimuths and altitudes all over the sky [rad], half a degree off the zenith."""
    rng = np.random.default_rng(1)
    return rng.uniform(-270, 270, POINTS) * DEG, rng.uniform(-5, 89.5, POINTS) * DEG


def grid():
    """Compute the whole grid."""
    az, alt = axes()
    return exact_offsets(az[:, None], alt, recovered())


def scattered():
    """Compute a million points."""
    some = np.linspace(-4, 4, 1_000_000), np.linspace(0, 1.5, 1_000_000)
    return exact_offsets(*some, recovered())


def approximate():
    """Compute a million points by the approximate form."""
    some = np.linspace(-4, 4, 1_000_000), np.linspace(0, 1.5, 1_000_000)
    return approximate_offsets(*some, recovered())


def test_grid(measured):
    """All of the grid from its axes."""
    measured("pyport", grid, rounds=30)


def test_grid_in_fortran(measured, routines):
    """The routine called once for each point, all of them correct to its rounding."""
    call, real = routines
    az, alt = (one.astype(real) for one in axes())
    p, out = (recovered() / DEG).astype(real), np.empty((2, len(az), len(alt)), real)
    measured(
        f"gfortran -O3, {real.__name__}",
        lambda: call("grid", len(az), len(alt), az, alt, p, *out),
        rounds=20,
    )

    ours = grid()
    rounding = 1e-9 if real is np.float64 else 4e-5
    same = ~near_the_jump(*axes()) & (np.abs(alt - np.pi / 2) > 0.01)
    for axis in (0, 1):
        assert np.abs(out[axis] * DEG - ours[axis])[same].max() < rounding


def near_the_jump(az, alt):
    """Tell the points of a grid where rounding decides on which side of the jump they are."""
    near = [has_jumped(az[:, None], alt + step) for step in (-1e-5, 1e-5)]
    return near[0] != near[1]


def test_scattered(measured, points):
    """Ten million points."""
    measured("pyport", lambda: exact_offsets(*points, recovered()), rounds=3)


def test_scattered_in_fortran(measured, points, routines):
    """The same by the routine."""
    call, real = routines
    az, alt = (one.astype(real) for one in points)
    p, out = (recovered() / DEG).astype(real), np.empty((2, POINTS), real)
    measured(
        f"gfortran -O3, {real.__name__}",
        lambda: call("scattered", POINTS, az, alt, p, *out),
        rounds=2,
    )


def test_approximate(measured, points):
    """The approximate form at ten million points."""
    measured("pyport", lambda: approximate_offsets(*points, recovered()), rounds=3)


def test_approximate_by_katpoint(measured, points):
    """Katpoint's model with as many terms."""
    katpoint = pytest.importorskip("katpoint")
    model = katpoint.PointingModel([1e-4] * 8 + [0, 0, 1e-4, 1e-4, 1e-4, 1e-4])
    measured("katpoint", lambda: model.offset(*points), rounds=2)
