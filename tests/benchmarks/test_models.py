"""A model as a control loop asks it, and over a million directions."""

from dataclasses import replace

import numpy as np
import pytest

from pyport.correction.use import PointingModel
from pyport.effects import CATALOGUE
from pyport.effects.empirical.fields import field
from pyport.effects.telescope.structure import curved_jump
from pyport.formats.models import load
from pyport.models.model import Term

DIRECTIONS = 1_000_000
ONE, MANY = "one direction of a model", "a million directions of a model"


def model(*more):
    """Return the classical terms with coefficients, and more."""
    own = [
        replace(term, values=(1e-4,) * len(term.effect.coefficients))
        for term in load("altaz").terms
    ]
    return PointingModel(replace(load("altaz"), terms=(*own, *more)))


def bumps(kind, count, **told):
    """Return a curve without a name on both axes, of so many bumps and as many coefficients."""
    axes, which = [0] * count + [1] * count, [*range(count)] * 2
    mix = np.random.default_rng(2).normal(size=(2 * count, count)).tolist()
    return Term(field({"kind": kind, **told}, axes, which, mix, "a", "b"), values=(1e-6,) * count)


MORE = {
    "classical": (),
    "with a jump and refraction": (
        Term(curved_jump((0.9, 0.1, 0.05, 0.0, 0.02)), values=(1e-4,)),
        Term(CATALOGUE["refraction"], values=(3e-4,)),
    ),
    "with curves without a name": (
        bumps("azimuth", 18, width_rad=0.35),
        bumps("elevation", 12, width_rad=0.087, centres_rad=(0.4 + 0.087 * np.arange(12)).tolist()),
    ),
}


@pytest.fixture(params=MORE)
def asked(request):
    """Return a model that was asked before."""
    one = model(*MORE[request.param])
    one.offsets_rad(0.1, 0.5)
    return one


@pytest.mark.benchmark(group=ONE)
def test_one_direction(benchmark, asked):
    """Numbers in, numbers out."""
    x, y = benchmark(asked.offsets_rad, 1.0, 0.7)

    assert x != 0 != y


@pytest.mark.benchmark(group=ONE)
def test_one_direction_in_quantities(benchmark, asked):
    """Degrees in, Quantities out."""
    found = benchmark(asked.offsets, 57.0, 40.0)

    assert found.d_el.unit == "arcsec"


@pytest.mark.benchmark(group=MANY)
def test_a_million_directions(benchmark, asked):
    """Arrays of degrees in, arrays of Quantities out."""
    rng = np.random.default_rng(1)
    az, el = rng.uniform(0, 360, DIRECTIONS), rng.uniform(5, 88, DIRECTIONS)
    found = benchmark.pedantic(asked.offsets, (az, el), rounds=3, warmup_rounds=1)

    assert np.isfinite(found.d_xel.value).all()
