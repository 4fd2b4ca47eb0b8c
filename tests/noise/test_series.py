"""What of a drift shows within a span."""

from __future__ import annotations

import numpy as np
import pytest

from pyport.noise.series import Noise


@pytest.mark.parametrize("memory", [10.0, 100.0, 1e3, 1e4, 1e5])
def test_about_its_mean_a_drift_moves_as_its_covariance_says(memory):
    """That of many places in the span, less their mean's."""
    time = np.linspace(0, 1000, 2001)
    kept = 4 * np.exp(-np.abs(time[:, None] - time) / memory)
    moved = 4 - kept.mean()

    found = Noise(0.0, 1.0, ((2.0, memory),)).about_mean(1000.0)

    assert found.drift**2 == pytest.approx(moved, rel=0.005)
    assert found.time_s == pytest.approx(min(memory, 1000.0))


def test_about_its_mean_nothing_moves_at_one_time():
    """A single pointing tells nothing of what drifts."""
    assert Noise(0.0, 1.0, ((2.0, 100.0),)).about_mean(0.0).drift == 0


def test_within_a_span_a_walk_changes_as_fast_as_it_does():
    """With a memory of the span, and the variance that it changes by there."""
    found = Noise(0.0, 1.0, ((2.0, 100.0), (1.0, 4e4))).shown_within(9e3)

    assert found.drifts == ((2.0, 100.0), (pytest.approx(np.sqrt(9 / 40)), 9e3))
    assert Noise(0.0, 1.0, ((2.0, 100.0),)).shown_within(0.0).drifts == ()
