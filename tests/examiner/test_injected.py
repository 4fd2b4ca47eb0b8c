"""Causes in the noise of real recordings: whose noise, how it is dealt, what is put in."""

import numpy as np
import pytest

from pyport.examiner.real import injected
from pyport.examiner.worlds.kinds import Spec

SET = "GMRT 2003-03-31"


@pytest.fixture
def noise(monkeypatch):
    """Stand in for what the program leaves of a set."""
    found = injected._read(SET, None)
    drawn = np.random.default_rng(1).standard_normal((len(found), 2)) * 30
    drawn[~np.isfinite(found.offsets())] = np.nan
    monkeypatch.setattr(injected, "_noise", lambda *_: drawn)
    return drawn


def test_noise_is_dealt_anew_and_jumps_nowhere(noise):
    """Blanks are where they were; within a night neighbours were neighbours, or are the same."""
    found = injected._read(SET, None)
    dealt = injected._dealt(np.random.default_rng(2), found, noise)

    def steps(values):
        nights = [values[found.group == one] for one in np.unique(found.group)]
        known = [night[np.isfinite(night)] for night in nights]
        return np.concatenate([np.abs(np.diff(night)) for night in known])

    np.testing.assert_array_equal(np.isfinite(dealt), np.isfinite(noise))
    assert not np.array_equal(dealt, noise, equal_nan=True)
    for axis in (0, 1):
        near = np.append(steps(noise[:, axis]), 0.0)
        for one in steps(dealt[:, axis]):
            assert np.abs(near - one).min() < 1e-9


@pytest.mark.usefixtures("noise")
def test_a_cause_has_the_size_that_was_asked_for():
    """Half of the noise beside the model; without one, the same noise and no signature."""
    case, empty = (
        Spec("real", "real", one, 0.5, real=SET).make(3) for one in ("scan_direction", None)
    )
    (cause,) = case.truth["effects"]

    assert max(cause["rho_xel"], cause["rho_el"]) == pytest.approx(0.5)
    assert not np.any(empty.signature)
    assert case.arguments == ("--model", "gmrt-paper")
    assert not {"d_el_arcmin", "d_xel_arcsec"} & set(case.columns)


def test_without_a_folder_of_data_the_shipped_sets_stand():
    """All of them, and no copy or simulation."""
    assert len(injected.names(None)) == 5
    assert all(one.startswith("GMRT") for one in injected.names(None))
