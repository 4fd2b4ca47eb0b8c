"""Arrays: the common part and each antenna's own."""

import numpy as np
import pytest

from pyport.diagnosis.arrays.findings import split


def coefficients(common, own, sigma, seed):
    """Return one coefficient for each antenna in each session, with noise."""
    rng = np.random.default_rng(seed)
    sessions, antennas = np.meshgrid(range(len(common)), range(len(own)))
    value = np.add(common, np.array(own)[:, None]) + sigma * rng.normal(size=sessions.shape)
    names = np.char.add("A", np.char.zfill(antennas.ravel().astype(str), 2))
    return names, sessions.ravel().astype(str), value.ravel(), np.full(sessions.size, sigma)


def test_common_and_own_parts_are_distinguished():
    """A part that changes by session and one that stays with the antenna both come back."""
    rng = np.random.default_rng(0)
    own = rng.normal(size=20)
    own -= own.mean()
    found = split(*coefficients([5.0, 1.0, -6.0], own, 0.1, 1))

    np.testing.assert_allclose(found.common, [5, 1, -6], atol=0.15)
    np.testing.assert_allclose(found.own, own, atol=0.35)
    assert found.spread == pytest.approx(1.0, rel=0.35)
    assert found.has_common
    assert found.changes


def test_nothing_common_is_said_to_be_nothing():
    """Own parts about zero have no common part, session by session, in nearly all draws."""
    rng = np.random.default_rng(2)
    claims = [
        split(*coefficients([0.0], rng.normal(size=15), 0.1, seed)).has_common
        for seed in range(100)
    ]

    assert np.mean(claims) < 0.05


def test_a_constant_common_part_does_not_change():
    """The same amount in every session is no change, in nearly all draws."""
    rng = np.random.default_rng(3)
    claims = [
        split(*coefficients([2.0, 2.0, 2.0], rng.normal(size=15), 0.1, seed)).changes
        for seed in range(100)
    ]

    assert np.mean(claims) < 0.05
