"""Noise of every kind that a pointing measurement has."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import Array
from pyport.examiner.worlds.earth import wander
from pyport.examiner.worlds.schedule import Plan


@dataclass(frozen=True)
class Noise:
    """How a case is noisy."""

    #: `sigma_x`, `sigma_y`: rms of all of it but the outliers, per axis [rad].
    sigma_x: float
    sigma_y: float
    drift_share: float = 0.0  #: fraction of the variance that wanders (Ornstein-Uhlenbeck)
    memory_s: float = 7200.0  #: time in which the wandering forgets by e
    tail_degrees: float = 0.0  #: degrees of freedom of Student's t for the rest; 0 for a normal one
    #: `outlier_share`, `outlier_sigmas`: how many rows are bad, and how bad at the worst.
    outlier_share: float = 0.0
    outlier_sigmas: float = 30.0
    step: float = 0.0  #: encoder step that readings are rounded to [rad]; 0 for none

    def louder(self, factor: float) -> Noise:
        """Return the same noise, `factor` times as great."""
        return replace(
            self,
            sigma_x=self.sigma_x * factor,
            sigma_y=self.sigma_y * factor,
            step=self.step * factor,
        )


def draw(rng: np.random.Generator, noise: Noise, plan: Plan) -> tuple[Array, Array]:
    """Return noise for both axes [rad], shape (n,) each, each antenna's own."""
    x, y = (sigma * _unit(rng, noise, plan) for sigma in (noise.sigma_x, noise.sigma_y))
    bad = rng.random(len(plan)) < noise.outlier_share
    for axis, sigma in ((x, noise.sigma_x), (y, noise.sigma_y)):
        size = rng.uniform(8, noise.outlier_sigmas, len(plan)) * rng.choice([-1, 1], len(plan))
        axis[bad] += sigma * size[bad]
    return x, y


def _unit(rng: np.random.Generator, noise: Noise, plan: Plan) -> Array:
    """Return noise of unit rms."""
    if noise.tail_degrees > 2:
        heavy = noise.tail_degrees / (noise.tail_degrees - 2)
        fresh = rng.standard_t(noise.tail_degrees, len(plan)) / np.sqrt(heavy)
    else:
        fresh = rng.standard_normal(len(plan))
    slow = np.zeros(len(plan))
    for antenna in np.unique(plan.labels["antenna"]):
        own = plan.labels["antenna"] == antenna
        slow[own] = wander(rng, plan.time_s[own], noise.memory_s)
    return np.sqrt(1 - noise.drift_share) * fresh + np.sqrt(noise.drift_share) * slow


def rounded(value: Array, step: float) -> Array:
    """Return readings as an encoder of this step gives them."""
    return np.round(value / step) * step if step else value
