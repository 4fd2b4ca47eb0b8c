"""Fits recover what was put in, and the GMRT's published curves."""

from pathlib import Path

import numpy as np
import pytest

from pyport.angles import ARCSEC
from pyport.effects import CATALOGUE, Circumstances
from pyport.errors import BadInput
from pyport.fitting.fit import fit
from pyport.formats import models
from pyport.models.model import CLASSICAL_TERMS
from pyport.recordings.schema import Recordings

TRUTH = np.array([30.0, -55, 21, -13, 8, -5, 44]) * ARCSEC


def simulated(n, noise_arcsec, seed):
    """Return recordings of the classical seven terms with white noise."""
    rng = np.random.default_rng(seed)
    at = Circumstances(rng.uniform(0, 2 * np.pi, n), rng.uniform(0.2, 1.4, n))
    parts = [CATALOGUE[name].columns(at) for name in CLASSICAL_TERMS.split()]
    x, y = (np.concatenate(axis, axis=1) @ TRUTH for axis in zip(*parts, strict=True))
    x, y = (one + noise_arcsec * ARCSEC * rng.normal(size=n) for one in (x, y))
    nothing = np.full(n, np.nan)
    return Recordings(at, x, y, nothing, nothing, np.arange(n), Path("simulated"))


def test_altaz_is_recovered_within_its_sigmas():
    """Over many noise draws the misses are normal with the sigmas that the fit states."""
    misses = []
    for seed in range(40):
        done = fit(simulated(150, 5, seed), models.load("altaz"))
        value = np.concatenate([one.value for one in done.coefficients])
        sigma = np.concatenate([one.sigma for one in done.coefficients])
        misses.append((value - TRUTH) / sigma)

    scatter = np.std(misses)

    assert 0.85 < scatter < 1.15
    assert np.abs(np.mean(misses, axis=0)).max() < 0.6


def test_too_few_offsets_are_refused():
    """Seven coefficients cannot come from six numbers."""
    with pytest.raises(BadInput, match="6 measured offsets cannot determine 7"):
        fit(simulated(3, 1, 0), models.load("altaz"))
