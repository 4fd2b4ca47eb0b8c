"""The campaigns of one telescope: when it observed, how askew and how noisy it is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, datetime

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.examiner.worlds.earth import SITES, wander
from pyport.examiner.worlds.mount import Mount
from pyport.examiner.worlds.schedule import Plan, draw_plan, sessions, take, with_planet


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


_DAY_S = 86400.0

#: How many campaigns have a planet among their targets.
_PLANET_SHARE = 0.3

#: Kinds of noise.
NOISES = ("white", "drift", "heavy", "outliers", "gappy")


def unix(year: int, month: int, day: int) -> float:
    """Return seconds since 1970 of a date at 0 h UTC."""
    return datetime(year, month, day, tzinfo=UTC).timestamp()


def campaign(rng: np.random.Generator, rows: int, site_name: str | None = None) -> Plan:
    """Draw a campaign of one telescope: 5 to 9 sessions in 20 to 200 days between 1998 and 2020."""
    name = str(rng.choice(list(SITES))) if site_name is None else site_name
    site = SITES[name]
    first = unix(1998, 1, 1) + rng.uniform(0, 22 * 365.25) * _DAY_S
    observing = sessions(
        rng, int(rng.integers(5, 10)), first, rng.uniform(20, 200) * _DAY_S, (8.0, 22.0)
    )
    plan = draw_plan(rng, name, site, rows, observing, one_axis=bool(rng.random() < 0.5))
    return with_planet(rng, plan) if rng.random() < _PLANET_SHARE else plan


def gappy_campaign(rng: np.random.Generator, rows: int, site_name: str | None = None) -> Plan:
    """Draw a campaign of which stretches were lost, so that `rows` are left."""
    plan = campaign(rng, rows * 3 // 2, site_name)
    keep = np.ones(len(plan), bool)
    while keep.sum() > rows:
        start = int(rng.integers(len(plan)))
        length = min(int(rng.integers(10, 60)), int(keep.sum()) - rows)
        keep[start : start + length] = False
    return take(plan, keep)


def usual_mount(rng: np.random.Generator) -> Mount:
    """Draw a telescope that is askew in the seven ways that its model knows."""
    minute, half = 60 * ARCSEC, 30 * ARCSEC
    return Mount(
        azimuth_zero=3 * minute * rng.standard_normal(),
        elevation_zero=3 * minute * rng.standard_normal(),
        beam_left=half * rng.standard_normal(),
        skew=half * rng.standard_normal(),
        tilt_north=half * rng.standard_normal(),
        tilt_east=half * rng.standard_normal(),
        sag_cosine=minute * rng.standard_normal(),
    )


def usual_noise(rng: np.random.Generator, kind: str = "white") -> Noise:
    """Draw noise of a kind, 3 to 20 arcsec in cross-elevation and about as much in elevation."""
    sigma = ARCSEC * np.exp(rng.uniform(np.log(3), np.log(20)))
    noise = Noise(sigma, sigma * rng.uniform(0.7, 1.4), step=0.2 * sigma)
    if kind == "drift":
        memory_s = 3600 * np.exp(rng.uniform(np.log(0.5), np.log(8)))
        return replace(noise, drift_share=rng.uniform(0.1, 0.4), memory_s=memory_s)
    if kind == "heavy":
        return replace(noise, tail_degrees=3.0)
    if kind == "outliers":
        return replace(noise, outlier_share=rng.uniform(0.01, 0.06))
    return noise
