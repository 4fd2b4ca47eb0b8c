"""The RT32's robust fit, beside scipy's least squares and katpoint's fit."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from benchmarks import limits

from pyport.angles import ARCSEC, DEG
from pyport.effects import Circumstances
from pyport.pointing import Rt32Model, printed
from pyport.pointing.exact import formulae
from pyport.recordings.schema import Recordings
from pyport.studies.rt32 import fit_rt32

POINTS = 5600
SIGMA = 12 * ARCSEC

ROWS = {"test_exact": "fit-exact", "test_approximate": "fit-approximate"}


def campaign():
    """Return offsets of both axes with noise, one in fifty of them an outlier."""
    rng = np.random.default_rng(0)
    at = Circumstances(rng.uniform(-90, 450, POINTS) * DEG, rng.uniform(8, 84, POINTS) * DEG)
    x, y = Rt32Model(printed()).offsets(at) + rng.normal(0, SIGMA, (2, POINTS))
    x[::50] += 200 * ARCSEC
    nothing = np.full(POINTS, np.nan)
    return Recordings(at, x, y, nothing, nothing, np.arange(POINTS), Path("made.csv"))


def exact():
    """Fit the exact form."""
    return fit_rt32(campaign(), method="soft-l1")


def approximate():
    """Fit the approximate form."""
    return fit_rt32(campaign(), exact=False, method="soft-l1")


def test_exact(beside):
    """The exact form, votes and all; the same loss by `scipy.optimize.least_squares`.

    Its Jacobian is taken by differences, the model the plain formulae of
    `pyport.pointing.exact`, as anyone would write them.
    """
    from scipy.optimize import least_squares

    made = campaign()
    az, el, level = made.at.az - np.pi, made.at.el, np.cos(made.at.el)

    def residual(p):
        d_az, d_alt = formulae(az, el, p)
        return np.concatenate([made.x - d_az * level, made.y - d_alt]) / SIGMA

    def theirs():
        return least_squares(residual, np.zeros(12), loss="soft_l1")

    ours = beside(
        lambda: fit_rt32(made, method="soft-l1"),
        {"scipy": theirs},
        rounds=15,
        limit=limits.of_rounds(9, POINTS, 8),
        both=True,
    )

    assert np.abs((ours.values - printed()) / ours.sigmas).max() < 5
    assert np.abs((theirs().x - ours.values) / ours.sigmas).max() < 1


def test_approximate(beside):
    """The approximate form with the same votes; katpoint's weighted fit of twelve parameters.

    Katpoint has no votes, an outlier counts in full.
    """
    katpoint = pytest.importorskip("katpoint")
    made = campaign()
    level = np.cos(made.at.el)
    sigma = np.full(POINTS, SIGMA)
    which = [1, 3, 4, 5, 6, 7, 8, 9, 11, 12, 13, 14]

    def theirs():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FutureWarning)
            return katpoint.PointingModel().fit(
                made.at.az, made.at.el, made.x / level, made.y, sigma / level, sigma, which
            )

    beside(
        lambda: fit_rt32(made, exact=False, method="soft-l1"),
        {"katpoint": theirs},
        rounds=40,
        limit=limits.of_rounds(5, POINTS, 8),
        both=True,
    )

    assert np.isfinite(theirs()[0]).all()
