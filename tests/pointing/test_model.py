"""The RT32's parameters, its effects, its jump, and the model in the program's own frame."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from pyport.angles import ARCSEC, DEG
from pyport.effects import Circumstances
from pyport.pointing import (
    PARAMETERS,
    Rt32Model,
    approximate_columns,
    exact_offsets,
    has_jumped,
    jump_altitude,
    printed,
    printed_sigmas,
)
from pyport.pointing.approximate import effect_of

pytestmark = pytest.mark.usefixtures("both_paths")

TABLE = Path(__file__).parents[2] / "golden_tables/published/model3_parameters.txt"


def sky(n=400, highest=88.0, seed=3):
    """Return n pointings all over the sky, azimuth from north."""
    rng = np.random.default_rng(seed)
    return Circumstances(az=rng.uniform(-90, 450, n) * DEG, el=rng.uniform(1, highest, n) * DEG)


def test_parameters_are_the_printed_ones():
    """Values and sigmas equal the published table digit for digit."""
    rows = [line for line in TABLE.read_text().splitlines() if line.endswith(" deg")][1:]
    values = [tuple(row.split("= ")[-1].removesuffix(" deg").split("+/-")) for row in rows]

    assert [(one.printed_deg, one.printed_sigma_deg) for one in PARAMETERS] == values


def test_printed_degrees_and_arcseconds_tell_the_same():
    """The table prints each parameter twice; both round to one number."""
    rows = [line for line in TABLE.read_text().splitlines() if line.endswith(" deg")][1:]
    arcsec = [float(row.split("+/-")[0].split()[-1]) for row in rows]

    np.testing.assert_allclose(printed() / ARCSEC, arcsec, rtol=0, atol=0.0501)
    assert np.all(printed_sigmas() > 0)


def test_every_parameter_is_a_coefficient_of_an_effect():
    """Each p_i names an effect of the catalogue and one of its columns."""
    for number, parameter in enumerate(PARAMETERS, start=1):
        effect = effect_of(number)

        assert effect.id == parameter.effect
        assert parameter.column < len(effect.coefficients)


def test_approximate_columns_are_equations_18_and_19():
    """The sum of effects is the published formula, azimuth turned by half a circle."""
    at = sky()
    a, h = at.az - math.pi, at.el
    p = np.arange(1, 13) * 1e-3
    x, y = approximate_columns(at)
    d_az = (
        p[0]
        + (p[4] * np.sin(a) - p[5] * np.cos(a) + p[2]) * np.tan(h)
        + p[3] / np.cos(h)
        + p[8] * np.sin(2 * a)
        + p[9] * np.cos(2 * a)
    )
    d_alt = p[1] + p[4] * np.cos(a) + p[5] * np.sin(a) + p[6] * np.cos(h) + p[7] * np.sin(h)
    d_alt += p[10] * np.sin(2 * a) + p[11] * has_jumped(a, h)

    np.testing.assert_allclose(x @ p, d_az * np.cos(h), rtol=0, atol=1e-16 * 100)
    np.testing.assert_allclose(y @ p, d_alt, rtol=0, atol=1e-16 * 100)


def test_model_in_the_programs_frame():
    """The x offset is the azimuth offset times cos E, at the azimuth counted from south."""
    at = sky()
    x, y = Rt32Model(printed()).offsets(at)
    d_az, d_alt = exact_offsets(at.az - math.pi, at.el, printed())

    np.testing.assert_array_equal(x, d_az * np.cos(at.el))
    np.testing.assert_array_equal(y, d_alt)


def columns(model, at):
    """Return d(x, y)/dp of a model, zeros in full, shape (2, n, 12)."""
    found = np.zeros((2, len(at), 12))
    for whole, slopes in zip(found, model.slopes(at), strict=True):
        whole[:, list(slopes)] = np.stack(list(slopes.values()), axis=1)
    return found


@pytest.mark.parametrize("exact", [True, False])
def test_columns_predict_a_small_change(exact):
    """A change of the parameters moves the offsets by the columns times that change."""
    at = sky(highest=80)
    change = np.linspace(-2, 2, 12) * ARCSEC
    before = Rt32Model(printed(), exact)
    after = Rt32Model(printed() + change, exact)

    for moved, still, column in zip(
        after.offsets(at), before.offsets(at), columns(before, at), strict=True
    ):
        np.testing.assert_allclose(moved - still, column @ change, rtol=0, atol=1e-4 * ARCSEC)


def test_a_fit_by_columns_finds_the_parameters_again():
    """Gauss-Newton from zero reaches the parameters of noiseless offsets in three steps."""
    at = sky(highest=85)
    truth = printed()
    target = np.concatenate(Rt32Model(truth).offsets(at))
    p = np.zeros(12)
    for _ in range(3):
        here = Rt32Model(p)
        misfit = target - np.concatenate(here.offsets(at))
        p = p + np.linalg.lstsq(np.concatenate(columns(here, at)), misfit, rcond=None)[0]

    np.testing.assert_allclose(p, truth, rtol=0, atol=1e-5 * ARCSEC)


@pytest.mark.parametrize(
    ("az_south_deg", "altitude_deg"),
    [(0, 72), (-180, 65), (95, 55), (180, 55 + 15 * (85 / 90) ** 2), (-100, 65 + 7 * 0.6427876)],
)
def test_curve_of_the_jump(az_south_deg, altitude_deg):
    """The curve is 65 + 7 cos(A/2) east of south and a parabola about 95 deg west of it."""
    assert jump_altitude(az_south_deg * DEG) / DEG == pytest.approx(altitude_deg, abs=1e-6)


def test_jump_is_not_periodic():
    """The same direction reached by the other turn of the cable has another jump."""
    assert jump_altitude(260 * DEG) > 100 * DEG
    assert jump_altitude(-100 * DEG) < 70 * DEG
    assert not has_jumped(260 * DEG, 80 * DEG)
    assert has_jumped(-100 * DEG, 80 * DEG)


def test_jump_below_the_horizon_and_on_it():
    """The routines add the step below the horizon too, and not at altitude zero."""
    below, on, above = has_jumped(0.5, [-0.01, 0.0, 0.01])

    assert below
    assert not on
    assert not above
