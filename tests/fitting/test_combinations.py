"""Coefficients that the data do not know alone come as the combination that they know."""

from __future__ import annotations

import re

import numpy as np
import pytest
from diagnosis.made import recordings
from samples import sample

from pyport.angles import ARCSEC
from pyport.effects.base import Coefficient
from pyport.fitting.combinations import (
    HIDDEN,
    INFLATED,
    _spectrum,
    _visible,
    combinations,
    of_fit,
)
from pyport.fitting.fit import fit
from pyport.fitting.table import as_json, text
from pyport.formats.models import load
from pyport.recordings import read


def pair(apart, size=200, seed=1):
    """Return two columns that differ by a share `apart` of their length, and one by itself."""
    rng = np.random.default_rng(seed)
    one, other, third = np.linalg.qr(rng.normal(size=(size, 3)))[0].T * np.sqrt(size)
    return np.stack([one, np.sqrt(1 - apart**2) * one + apart * other, third], axis=1)


def solved(columns, truth, noise=1.0, seed=2, units=("arcsec",) * 3, largest=np.inf):
    """Fit columns to a truth [arcsec] with noise [arcsec], and return the combinations."""
    scale = np.array([ARCSEC if one == "arcsec" else 1.0 for one in units])
    columns = columns * ARCSEC / scale
    rng = np.random.default_rng(seed)
    data = columns @ (truth * scale) + noise * ARCSEC * rng.normal(size=len(columns))
    inverse = np.linalg.pinv(columns.T @ columns, rcond=1e-14)
    names = ("one", "other", "third")
    coefficients = [
        Coefficient(name, unit, float(size))
        for name, unit, size in zip(names, units, scale, strict=True)
    ]
    covariance = inverse * (noise * ARCSEC) ** 2
    return combinations(
        names, coefficients, columns, inverse @ (columns.T @ data), covariance, largest
    )


@pytest.mark.parametrize("apart", [0.05, 0.099, 0.101, 0.3])
def test_a_visible_share_is_what_other_columns_leave(apart):
    """A column that differs from another by a share shows that share of itself."""
    assert _visible(*_spectrum(pair(apart))[1:]) == pytest.approx([apart, apart, 1.0])


@pytest.mark.parametrize(("apart", "told"), [(0.05, True), (0.099, True), (0.101, False)])
def test_nine_tenths_decide(apart, told):
    """Two coefficients are a combination where more than nine tenths of each hide."""
    found = solved(pair(apart), np.array([400.0, -395.0, 10.0]))

    assert bool(found) == told
    assert (apart < HIDDEN) == told
    if told:
        assert found[0].names == ("one", "other")


def test_the_combination_is_the_one_that_was_hidden():
    """Its value is right and its error small, whatever noise does to the coefficients alone."""
    pulls = []
    for seed in range(60):
        (found,) = solved(pair(0.01), np.array([400.0, -395.0, 10.0]), seed=seed)
        (known,) = found.known
        truth = known.weights[0] * 400 - known.weights[1] * 395
        pulls.append((known.value / ARCSEC - truth) / (known.sigma / ARCSEC))

        assert known.sigma < 0.2 * ARCSEC
        assert known.weights == pytest.approx((1.0, 1.0), abs=0.02)
        assert "one and other are known in combination only" in found.sentence
    assert 0.7 < np.std(pulls) < 1.3


def test_what_is_merely_inflated_goes_with_what_it_hides():
    """Of three columns that nearly add up, the one that shows an eighth is in the combination."""
    rng = np.random.default_rng(3)
    one, other, rest = np.linalg.qr(rng.normal(size=(300, 3)))[0].T
    columns = np.stack([one, other, 0.5 * one + other + 0.08 * rest], axis=1)
    shares = _visible(*_spectrum(columns)[1:])

    assert shares[0] > HIDDEN > shares[1]
    assert shares[0] ** -2 > INFLATED
    assert solved(columns, np.ones(3), noise=0.01)[0].names == ("one", "other", "third")


def test_columns_that_are_the_same_leave_their_sum():
    """A direction that the data leave open altogether is no number, the other is known."""
    (found,) = solved(pair(0.0), np.array([400.0, -395.0, 10.0]))
    (known,) = found.known

    assert known.value == pytest.approx(5 * ARCSEC, abs=0.5 * ARCSEC)


def test_units_are_in_the_formula():
    """A clock's seconds beside a tilt's arcseconds: the sum is in arcsec."""
    (found,) = solved(
        pair(0.02), np.array([4.0, -3.0, 0.0]), units=("arcsec", "s", "arcsec"), noise=0.1
    )

    assert re.search(r"1 one \+ 1 arcsec/s other = (0\.9|1\.0)\d+", found.sentence)


def test_no_number_is_larger_than_the_data():
    """What comes out bigger than any offset is not told."""
    (found,) = solved(pair(0.05), np.array([400.0, 300.0, 0.0]), largest=100 * ARCSEC)

    assert not found.known
    assert "no combination of them is known" in found.sentence


def test_a_fit_tells_its_own():
    """Over a narrow band of elevation both zeros, collimation and skew are told together."""
    made = recordings(300, 4)
    narrow = made.take((made.at.el > 0.7) & (made.at.el < 0.8))
    done = fit(narrow, load("altaz"))
    told = " ".join(text(done).split())

    assert {one.names for one in of_fit(done)} >= {("azimuth_zero", "collimation", "skew")}
    assert "azimuth zero, collimation and skew are known in combination only" in told
    assert as_json(done)["combinations"][0]["coefficients"] == list(of_fit(done)[0].names)


@pytest.mark.parametrize("name", ["rts2/sutherland-2016.csv"])
def test_real_recordings_tell_one_combination(name):
    """A robotic telescope's zero, collimation and skew are known together, each hardly alone."""
    (found,) = of_fit(fit(read(sample(name)), load("altaz")))

    assert found.names == ("azimuth_zero", "collimation", "skew")
    assert abs(found.known[0].value) > 2 * found.known[0].sigma
