"""The campaigns of one telescope: when it observed, how askew and how noisy it is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, datetime

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.examiner.nulls import noises
from pyport.examiner.nulls.schedule import START, Pointings, horizontal
from pyport.examiner.worlds.earth import SITES, Site, wander
from pyport.examiner.worlds.mount import Mount
from pyport.examiner.worlds.schedule import (
    Plan,
    about_transit,
    draw_plan,
    sessions,
    take,
    with_planet,
)
from pyport.examiner.worlds.sky import Sources


@dataclass(frozen=True)
class Noise:
    """How a case is noisy."""

    #: `sigma_x`, `sigma_y`: rms of all of it but the outliers, per axis [rad].
    sigma_x: float
    sigma_y: float
    drift_share: float = 0.0  #: fraction of the variance that wanders (Ornstein-Uhlenbeck)
    memory_s: float = 7200.0  #: time in which the wandering forgets by e
    #: `outlier_share`, `outlier_sigmas`: how many rows are bad, and how bad at the worst.
    outlier_share: float = 0.0
    outlier_sigmas: float = 30.0
    step: float = 0.0  #: encoder step that readings are rounded to [rad]; 0 for none
    kind: str = ""  #: one of `noises.KINDS` that stands for the wandering and the rest

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
    x, y = np.array([[noise.sigma_x], [noise.sigma_y]]) * _unit(rng, noise, plan)
    bad = rng.random(len(plan)) < noise.outlier_share
    for axis, sigma in ((x, noise.sigma_x), (y, noise.sigma_y)):
        size = rng.uniform(8, noise.outlier_sigmas, len(plan)) * rng.choice([-1, 1], len(plan))
        axis[bad] += sigma * size[bad]
    return x, y


def _unit(rng: np.random.Generator, noise: Noise, plan: Plan) -> Array:
    """Return noise of both axes in units of sigma, shape (2, n)."""
    if noise.kind:
        return noises.KINDS[noise.kind].draw(rng, _pointings(plan)).value.T
    fresh = rng.standard_normal((2, len(plan)))
    slow = np.zeros((2, len(plan)))
    for antenna in np.unique(plan.labels["antenna"]):
        own = plan.labels["antenna"] == antenna
        slow[:, own] = [wander(rng, plan.time_s[own], noise.memory_s) for _ in range(2)]
    return np.sqrt(1 - noise.drift_share) * fresh + np.sqrt(noise.drift_share) * slow


def _pointings(plan: Plan) -> Pointings:
    """Return a plan as kinds of noise take it; places to a third of a degree."""
    midnight_s = START.astype("datetime64[s]").astype(float)
    latitude, longitude = (
        float(np.mean(one)) for one in (plan.reference.latitude, plan.reference.longitude)
    )
    time_s = plan.time_s - midnight_s
    az, el = horizontal(plan.ra, plan.dec, time_s, latitude, longitude)
    night, source = (
        np.unique(plan.labels[name], return_inverse=True)[1] for name in ("session", "source")
    )
    return Pointings(
        latitude, longitude, time_s, night, source, az, el, plan.ra, plan.dec, plan.weather
    )


def rounded(value: Array, step: float) -> Array:
    """Return readings as an encoder of this step gives them."""
    return np.round(value / step) * step if step else value


_DAY_S = 86400.0

#: How many campaigns have a planet among their targets.
_PLANET_SHARE = 0.3

#: Kinds of noise: the first two are such that an observer may know them.
NOISES = ("white", "drift", "gappy", *(one for one in noises.KINDS if one != "white"))
#: Kinds of sky: a list of radio sources, a grid of stars, one source followed, a cluster of them.
SKIES = ("radio", "grid", "one", "clustered")


def unix(year: int, month: int, day: int) -> float:
    """Return seconds since 1970 of a date at 0 h UTC."""
    return datetime(year, month, day, tzinfo=UTC).timestamp()


def campaign(
    rng: np.random.Generator, rows: int, site_name: str | None = None, sky: str = "radio"
) -> Plan:
    """Draw a campaign of one telescope: 5 to 9 sessions in 20 to 200 days between 1998 and 2020."""
    name = str(rng.choice(list(SITES))) if site_name is None else site_name
    site = SITES[name]
    first = unix(1998, 1, 1) + rng.uniform(0, 22 * 365.25) * _DAY_S
    observing = sessions(
        rng, int(rng.integers(5, 10)), first, rng.uniform(20, 200) * _DAY_S, (8.0, 22.0)
    )
    one_axis = bool(rng.random() < 0.5)
    if sky == "radio":
        plan = draw_plan(rng, name, site, rows, observing, one_axis=one_axis)
        return with_planet(rng, plan) if rng.random() < _PLANET_SHARE else plan
    seen, dwell = _seen(rng, sky, site)
    if sky == "one":
        observing = tuple(about_transit(one, seen, site) for one in observing)
    return draw_plan(
        rng, name, site, rows, observing, one_axis=one_axis, dwell=dwell, catalogue=seen
    )


def _seen(rng: np.random.Generator, sky: str, site: Site) -> tuple[Sources, tuple[int, int]]:
    """Draw what is observed in a kind of sky, and for how many rows in turn."""
    count, dwell = {"grid": (1500, (1, 1)), "clustered": (12, (5, 40)), "one": (1, (1, 1))}[sky]
    latitude = float(site.latitude)
    if sky == "one":
        # it culminates so far from the zenith on either side
        dec = np.array([latitude + rng.choice([-1, 1]) * rng.uniform(8, 45) * DEG])
        dec = np.where(np.abs(dec) > 80 * DEG, latitude - np.sign(latitude) * 20 * DEG, dec)
    else:
        dec = np.arcsin(rng.uniform(-1, 1, 40 * count))
        dec = dec[np.abs(dec - latitude) < 70 * DEG][:count]
    # a star by the pole is always up
    dec[0] = np.copysign(84 * DEG, latitude) if sky == "clustered" else dec[0]
    name = np.array([f"{sky[0].upper()}{n:04d}" for n in range(len(dec))])
    return Sources(name, rng.uniform(0, 2 * np.pi, len(dec)), dec), dwell


def gappy_campaign(
    rng: np.random.Generator, rows: int, site_name: str | None = None, sky: str = "radio"
) -> Plan:
    """Draw a campaign of which stretches were lost, so that `rows` are left."""
    plan = campaign(rng, rows * 3 // 2, site_name, sky)
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
    return noise if kind in ("white", "gappy") else replace(noise, kind=kind)
