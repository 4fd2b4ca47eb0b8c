"""The compiled kernel: its functions against fifty digits, its offsets against numpy's."""

from __future__ import annotations

import runpy
from pathlib import Path

import mpmath
import numpy as np
import pytest

from pyport.angles import DEG
from pyport.noise.whitening import factor
from pyport.pointing import approximate_offsets, exact_offsets, has_jumped, kernel, recovered
from pyport.steering import RT32_GRID, Grid, Table
from pyport.steering.as_written import refraction4
from pyport.steering.ascii import text as ascii_text
from pyport.steering.tabulate import rt32_offsets

SOURCE = Path(__file__).parents[2] / "pyport" / "pointing" / "kernel_src"
#: Units of the last place that each function may be off.
WITHIN_ULP = 2.5

compiled = kernel.KERNEL
if compiled is None:
    pytest.skip("the kernel is not installed: make wheel", allow_module_level=True)


@pytest.fixture(params=compiled.levels())
def level(request):
    """Use each instruction set that this processor has."""
    best = compiled.level()
    compiled.choose(request.param)
    yield request.param
    compiled.choose(best)


def arguments():
    """Return numbers for every function: angles large and near quarter turns, shares, sides."""
    rng = np.random.default_rng(0)
    quarters = rng.integers(-8, 9, 500) * np.pi / 2 + rng.normal(0, 1e-9, 500)
    angles = np.concatenate([rng.uniform(-5, 5, 500), rng.uniform(-1e6, 1e6, 500), quarters])
    sides = rng.normal(0, 1, 1500) * 10 ** rng.uniform(-9, 1, 1500)
    return {
        "sine": (0, sides, angles),
        "cosine": (1, sides, angles),
        "arcsine": (2, sides, np.concatenate([rng.uniform(-1, 1, 1498), [1.0, -0.5]])),
        "arctangent": (3, sides, angles),
    }


TRUE = {
    "sine": lambda _, x: mpmath.sin(x),
    "cosine": lambda _, x: mpmath.cos(x),
    "arcsine": lambda _, x: mpmath.asin(x),
    "arctangent": mpmath.atan2,
}


@pytest.mark.parametrize("name", TRUE)
def test_functions_against_fifty_digits(level, name):
    """No function is further off than its promise, in units of the last place."""
    which, y, x = arguments()[name]
    found = np.empty(len(x))
    compiled.elementary(which, y, x, found)

    with mpmath.workdps(50):
        true = [TRUE[name](mpmath.mpf(a), mpmath.mpf(b)) for a, b in zip(y, x, strict=True)]
        off = [abs(mpmath.mpf(one) - other) for one, other in zip(found, true, strict=True)]
    units = np.array(off, float) / np.spacing(np.abs(np.array(true, float)))

    assert units.max() < WITHIN_ULP, level


def test_functions_of_what_is_no_number(level):
    """What is no number gives none; signs of zeros and quarter turns are the C library's."""
    odd = np.array([0.0, -0.0, 1.0, -1.0, np.nan])
    y, x = (one.ravel().copy() for one in np.meshgrid(odd, odd))
    found = np.empty(len(x))

    for which, numpys in enumerate((np.sin, np.cos, np.arcsin)):
        compiled.elementary(which, y, x, found)
        np.testing.assert_allclose(found, numpys(x), rtol=1e-15, err_msg=level)
    compiled.elementary(3, y, x, found)
    np.testing.assert_allclose(found, np.arctan2(y, x), rtol=1e-15)
    known = np.isfinite(found)
    np.testing.assert_array_equal(np.signbit(found[known]), np.signbit(np.arctan2(y, x)[known]))


@pytest.mark.parametrize("form", [exact_offsets, approximate_offsets])
def test_numpys_offsets(level, form, monkeypatch):
    """All over the sky, in plunge and where none reaches, within 2e-15 rad over the cosine."""
    rng = np.random.default_rng(1)
    az, alt = rng.uniform(-270, 270, 20_000) * DEG, rng.uniform(-5, 95, 20_000) * DEG
    alt[:100] = np.pi / 2 + rng.normal(0, 3e-4, 100)
    ours = form(az, alt, recovered())
    monkeypatch.setattr(kernel, "KERNEL", None)
    numpys = form(az, alt, recovered())

    # where rounding decides whether the step is there
    near = has_jumped(az, alt - 1e-14) != has_jumped(az, alt + 1e-14)
    for one, other in zip(ours, numpys, strict=True):
        off = np.abs(one - other)
        off = np.minimum(off, 2 * np.pi - off) * np.abs(np.cos(alt))
        assert off[~near].max() < 2e-15, level


def test_the_step_is_where_numpy_has_it(level, monkeypatch):
    """On the steering table's grid, where some nodes lie on the curve itself."""
    p = np.zeros(12)
    p[11] = 1.0
    az, alt = RT32_GRID.az_deg[:, None] * DEG, (90 - RT32_GRID.zd_deg) * DEG
    ours = exact_offsets(az, alt, p)[1]
    monkeypatch.setattr(kernel, "KERNEL", None)

    np.testing.assert_allclose(ours, exact_offsets(az, alt, p)[1], atol=1e-14, err_msg=level)


def test_large_angles_are_left_to_numpy(monkeypatch):
    """Angles that the kernel cannot reduce are numpy's, in an array with others too."""
    az = np.array([1.0, 3e6, -1e12])
    ours = exact_offsets(az, 0.5, recovered())
    monkeypatch.setattr(kernel, "KERNEL", None)

    np.testing.assert_array_equal(ours, exact_offsets(az, 0.5, recovered()))


@pytest.mark.parametrize("sizes", [(21, 3, 3, 3, 3), (22, 3, 2, 3, 3), (22, 3, 3, 3, 4)])
def test_arrays_of_wrong_sizes_are_refused(sizes):
    """Nothing is read or written beyond an array's end."""
    with pytest.raises(ValueError, match="sizes"):
        compiled.scattered(True, *(np.zeros(size) for size in sizes))  # noqa: FBT003 - as C has it


def test_arrays_of_other_numbers_are_refused():
    """Float32 and arrays that cannot be written to are no doubles to write to."""
    good, single, fixed = np.zeros(22), np.zeros(3, np.float32), np.zeros(3)
    fixed.flags.writeable = False

    with pytest.raises(TypeError, match="float64"):
        compiled.scattered(True, good, single, single, single, single)  # noqa: FBT003
    with pytest.raises((ValueError, BufferError)):
        compiled.scattered(True, good, fixed, fixed, fixed, fixed)  # noqa: FBT003


def test_the_polynomials_are_those_of_their_script():
    """The coefficients in the C source are what the script computes, and good to half a digit."""
    script = runpy.run_path(str(SOURCE / "polynomials.py"))

    assert (SOURCE / "polynomials.h").read_text() == script["header"]()
    assert all(script["coefficients"](name)[1] < 5e-17 for name in script["POLYNOMIALS"])


@pytest.mark.parametrize("rows", [0, 1, 7, 1000])
def test_products_of_columns(level, rows):
    """Weighted products of columns, with one another and with a target, are those of matrices."""
    rng = np.random.default_rng(4)
    columns, (weight, target) = rng.normal(size=(5, rows)), rng.normal(size=(2, rows))

    normal, right = kernel.gram(columns, weight, target)

    np.testing.assert_allclose(normal, columns * weight @ columns.T, atol=1e-12, err_msg=level)
    np.testing.assert_allclose(right, columns @ target, atol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 7, 1000, 1001])
def test_median(level, count):
    """The middle number, or the mean of two, to the last digit; some numbers are equal."""
    values = np.random.default_rng(5).normal(size=count)
    values[::3] = np.round(values[::3])

    assert kernel.median(values) == np.median(values), level


@pytest.mark.parametrize("drifts", [(), ((0.7, 30.0),), ((0.7, 30.0), (1.5, 900.0), (3.0, 9e4))])
def test_whitening_is_celerites(monkeypatch, level, drifts):
    """Columns, and the variance of each row given those before it; also of some rows alone."""
    rng = np.random.default_rng(7)
    columns, variance = rng.normal(size=(400, 13)), rng.uniform(0.5, 2, 400)
    time = np.sort(np.round(rng.uniform(0, 1e4, 400), -1))
    rows = np.sort(rng.permutation(400)[:250])
    found = factor(columns, variance, time, drifts)
    placed = np.full((400, 13), 7.0)
    some = kernel.whiten(columns, variance[rows], time[rows], drifts, (rows, placed))
    with monkeypatch.context() as without:
        without.setattr(kernel, "KERNEL", None)
        expected = factor(columns, variance, time, drifts)
        fewer = factor(columns[rows], variance[rows], time[rows], drifts)

    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12, err_msg=level)
    np.testing.assert_allclose(some[0], fewer[0], rtol=1e-12)
    np.testing.assert_allclose(placed[rows], fewer[1], rtol=1e-9, atol=1e-12)
    assert np.all(np.delete(placed, rows, axis=0) == 7)


@pytest.mark.parametrize("drifts", [(), ((4.5, 3e4),), ((0.7, 30.0), (1.5, 900.0), (4.5, 3e4))])
@pytest.mark.parametrize(("rows", "mostly_zero", "full"), [(1, 3, 2), (300, 40, 21), (77, 0, 5)])
def test_products_are_those_of_whitened_columns(level, rows, mostly_zero, full, drifts):
    """Of columns that are zero but in some rows, and of others, under strong slow drifts."""
    rng = np.random.default_rng(8)
    columns = rng.normal(size=(rows, mostly_zero + full))
    columns[:, :mostly_zero] *= rng.random((rows, mostly_zero)) < 0.1
    variance, time = rng.uniform(0.5, 2, rows), np.sort(rng.uniform(0, 1e4, rows))
    given = kernel.Columns.of(columns, mostly_zero)
    d, products = kernel.products(given, variance, time, drifts)
    expected, white = factor(columns, variance, time, drifts)

    np.testing.assert_allclose(d, expected, rtol=1e-12, err_msg=level)
    np.testing.assert_allclose(products, white.T @ white, rtol=1e-9, atol=1e-11)


def test_products_are_the_same_bits_on_every_instruction_set():
    """Wider registers hold more columns, and each column's sum is added up in the same order."""
    best = compiled.level()
    rng = np.random.default_rng(9)
    columns = rng.normal(size=(150, 50))
    columns[:, :30] *= rng.random((150, 30)) < 0.1
    given = kernel.Columns.of(columns, 30)
    variance, time = rng.uniform(0.5, 2, 150), np.sort(rng.uniform(0, 1e4, 150))
    found = {}
    try:
        for name in compiled.levels():
            compiled.choose(name)
            found[name] = kernel.products(given, variance, time, ((0.7, 30.0), (4.5, 3e4)))[1]
    finally:
        compiled.choose(best)

    first, *others = found.values()
    assert all(np.array_equal(first, one) for one in others)


def test_variances_that_are_none_are_left_to_numpy():
    """A covariance that is not positive definite, and rows that there are not."""
    columns, time = np.ones((3, 2)), np.arange(3.0)

    impossible, drift = np.array([1.0, -5, 1]), (0.1, 9.0)

    assert kernel.whiten(columns, impossible, time, (drift,)) is None
    assert kernel.products(kernel.Columns.of(columns, 1), impossible, time, (drift,)) is None
    with pytest.raises(ValueError, match="what there is not"):
        kernel.whiten(columns, np.ones(3), time, (), (np.array([0, 1, 3]), np.empty((3, 2))))


GRIDS = {
    "the published one": (np.arange(-270.0, 271, 9), np.arange(-5.0, 90)),
    "between degrees, beyond a turn": (np.linspace(-500.3, 499.1, 61), np.linspace(-89.9, 120, 77)),
    "what is no place": (np.array([np.nan, np.inf, 0.0, -0.0]), np.array([np.nan, 0.0, 90, 1e9])),
}


@pytest.mark.parametrize("axes", GRIDS.values(), ids=GRIDS)
def test_the_tables_offsets_are_those_of_single_numbers(monkeypatch, axes):
    """To the bit, so that a table's bytes are the same with the kernel and without."""
    grid = axes[0][:, None], axes[1][None, :]
    points = tuple(one.ravel() for one in np.broadcast_arrays(*grid))
    p = recovered() * np.linspace(0.5, 40, 12)

    for place in (grid, points):
        ours = rt32_offsets(*place, p, "rt32-table", "as-written", exact=True)
        with monkeypatch.context() as without:
            without.setattr(kernel, "KERNEL", None)
            theirs = rt32_offsets(*place, p, "rt32-table", "as-written", exact=True)
        np.testing.assert_array_equal(ours, theirs)


def test_the_tables_refraction_is_that_of_single_numbers():
    """To the bit, on both sides of the zenith and below the horizon."""
    zd_deg = np.concatenate([np.linspace(-120, 120, 4801), [0.0, -0.0]])
    found = np.empty_like(zd_deg)
    compiled.table_refraction(zd_deg, found)

    assert found.tobytes() == np.array([refraction4(one) for one in zd_deg], float).tobytes()


@pytest.mark.parametrize("step", [1.0, 0.25])
def test_the_tables_text_is_numpys(monkeypatch, step):
    """Large and small offsets, of either sign, on grids in whole degrees and between."""
    rng = np.random.default_rng(6)
    grid = Grid(np.arange(-5, 20, step), np.arange(-3, 9, step))
    offsets = rng.normal(size=(2, len(grid.az_deg), len(grid.zd_deg))) * 10.0 ** rng.integers(-9, 2)
    offsets[:, 0, :4] = 214.7483647, -214.7483647, -4e-8, 9.9999999999
    text = ascii_text(Table(grid, *offsets))
    with monkeypatch.context() as without:
        without.setattr(kernel, "KERNEL", None)
        assert text == ascii_text(Table(grid, *offsets))


def test_the_environment_can_ask_for_an_older_instruction_set(monkeypatch, level):
    """Each one that this processor has, by its name."""
    monkeypatch.setenv("PYPORT_KERNEL", level)
    compiled.choose(compiled.levels()[0])

    assert runpy.run_path(str(SOURCE.parent / "compiled.py"))["KERNEL"].level() == level


def test_an_older_kernel_is_left_out(monkeypatch):
    """One that lacks what this version calls is as good as none."""
    monkeypatch.setattr(compiled, "INTERFACE", 1)
    monkeypatch.delenv("PYPORT_KERNEL", raising=False)
    lookup = SOURCE.parent / "compiled.py"
    assert runpy.run_path(str(lookup))["KERNEL"] is None

    monkeypatch.setenv("PYPORT_KERNEL", "required")
    with pytest.raises(ImportError, match="another version"):
        runpy.run_path(str(lookup))
