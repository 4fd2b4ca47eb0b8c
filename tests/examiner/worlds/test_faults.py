"""Faults of time swing as they say."""

from types import SimpleNamespace

import numpy as np
import pytest

from pyport.examiner.worlds.faults import surroundings

STEP_S = 60.0
TIME = 1.2e9 + STEP_S * np.arange(30_000)


def drawn(effect):
    """Return the swing of a zero, of unit rms, and its period [s]."""
    plan = SimpleNamespace(time_s=TIME, labels={"session": np.arange(len(TIME)) // 600})
    world = SimpleNamespace(plan=plan, with_mount=lambda **parts: parts)
    fault = surroundings.TIMES[effect](world, np.random.default_rng(3))
    swing = fault.apply(world, 1.0)["elevation_zero"]
    return swing / np.sqrt(np.mean(swing**2)), fault.facts["period_s"]


def test_an_oscillation_comes_back_after_each_period():
    """From the first session to the last."""
    swing, period_s = drawn("oscillation")
    waves = np.exp(2j * np.pi * (TIME % period_s) / period_s)
    basis = np.stack([waves.real, waves.imag], axis=1)

    assert 1800 <= period_s <= 599 * STEP_S
    assert np.abs(swing - basis @ np.linalg.lstsq(basis, swing, rcond=None)[0]).max() < 1e-4


@pytest.mark.parametrize("periods", [0.5, 1.0, 2.0])
def test_a_wandering_oscillation_forgets_its_phase(periods):
    """By exp(-pi / Q) in each period; after half of one the sign is the other."""
    swing, period_s = drawn("wandering_oscillation")
    steps = round(periods * period_s / STEP_S)
    turns = steps * STEP_S / period_s

    expected = np.cos(2 * np.pi * turns) * np.exp(-np.pi * turns / 10)
    assert np.mean(swing[steps:] * swing[:-steps]) == pytest.approx(expected, abs=0.08)
