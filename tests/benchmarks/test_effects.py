"""The whole catalogue on 5,600 rows, beside ERFA's chain from catalogue to apparent place."""

import erfa
import numpy as np
import pytest
from effects.sky import SITE, campaign, julian

from pyport.effects import CATALOGUE, MissingColumn

ROWS = 5600
GROUP = "5,600 recordings against the sky"


@pytest.fixture(scope="module")
def recordings():
    """Return the circumstances of a campaign with every column of the contract."""
    return campaign(ROWS)


def whole_catalogue(at):
    """Return how many columns all members of all effects have."""
    columns = 0
    for effect in CATALOGUE.values():
        try:
            columns += sum(one.columns(at)[0].shape[1] for one in effect.variants(at))
        except MissingColumn:
            continue
    return columns


@pytest.mark.benchmark(group=GROUP)
def test_catalogue(benchmark, recordings):
    """Evaluate every member of every effect."""
    columns = benchmark.pedantic(whole_catalogue, (recordings,), rounds=3, warmup_rounds=1)

    assert columns > 200


@pytest.mark.benchmark(group=GROUP)
def test_erfa_places(benchmark, recordings):
    """Compute as many apparent places with `atco13`, the work of one column."""
    at = recordings.columns
    place = (at["ra"], at["dec"], 0, 0, 0, 0, *julian(at["time"]), 0)
    site = (SITE.longitude, SITE.latitude, SITE.height_m, 0, 0, 0, 0, 0, 1)

    az = benchmark.pedantic(lambda: erfa.atco13(*place, *site)[0], rounds=3)

    assert np.isfinite(az).all()
