"""The exact and the approximate form, beside the Fortran routines in a loop and katpoint."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from benchmarks import limits

from pyport.angles import DEG
from pyport.pointing import approximate_offsets, exact_offsets, has_jumped, recovered
from pyport.steering import RT32_GRID

POINTS = 10_000_000

ROWS = {
    "test_grid": "exact-grid",
    "test_scattered": "exact-scattered",
    "test_approximate": "approximate-scattered",
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


def fortran(routines, name, sizes, angles, shape):
    """Return the routine in a loop over some angles [rad], and its answers, for each type."""
    loops, answers = {}, {}
    for real, call in routines.items():
        out = answers[real] = np.empty((2, *shape), real)
        given = [one.astype(real) for one in (*angles, recovered() / DEG)]
        loops[f"gfortran -O3, {real.__name__}"] = functools.partial(
            call, name, *sizes, *given, *out
        )
    return loops, answers


#: What the geometry of a mount that leans and has a skewed axis asks for, a point; an arcsine
#: costs as much with its root as without the square root that is also asked for.
ARCS = ("arcsine", "arctangent")


def test_grid(beside, routines):
    """All of the grid from its axes, and the routine called once for each point of it."""
    az, alt = axes()
    shape = len(az), len(alt)
    loops, answers = fortran(routines, "grid", shape, (az, alt), shape)

    limit = limits.of_points(az.size * alt.size, angles=False, functions=ARCS)
    ours = beside(grid, loops, rounds=30, at_a_time=3, limit=limit, both=True)

    same = ~near_the_jump(az, alt) & (np.abs(alt - np.pi / 2) > 0.01)
    for real, out in answers.items():
        rounding = 1e-9 if real is np.float64 else 4e-5
        for axis in (0, 1):
            assert np.abs(out[axis] * DEG - ours[axis])[same].max() < rounding


def near_the_jump(az, alt):
    """Tell the points of a grid where rounding decides on which side of the jump they are."""
    near = [has_jumped(az[:, None], alt + step) for step in (-1e-5, 1e-5)]
    return near[0] != near[1]


def test_scattered(beside, points, routines):
    """Ten million points, and the routine at each of them."""
    loops, _ = fortran(routines, "scattered", (POINTS,), points, (POINTS,))

    beside(
        lambda: exact_offsets(*points, recovered()),
        loops,
        rounds=3,
        limit=limits.of_points(POINTS, angles=True, functions=("sine", "sine", *ARCS)),
        both=True,
    )


def test_approximate(beside, points):
    """The approximate form at ten million points, and katpoint's model with as many terms."""
    katpoint = pytest.importorskip("katpoint")
    model = katpoint.PointingModel([1e-4] * 8 + [0, 0, 1e-4, 1e-4, 1e-4, 1e-4])

    beside(
        lambda: approximate_offsets(*points, recovered()),
        {"katpoint": lambda: model.offset(*points)},
        rounds=3,
        limit=limits.of_points(POINTS, angles=True, functions=("sine", "sine")),
        both=True,
    )
