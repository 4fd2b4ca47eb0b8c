"""Kinds of noise that recordings have and that are no cause: each drawn by a function of its own.

A kind is drawn in units of the white sigma, shape (n, 2): across, and along elevation. Drifts,
1/f noise, random walks and offsets of nights and sources come on top of white noise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pyport.examiner.nulls.schedule import DAY_S, Array, Pointings, ou

_HOUR_S = 3600.0
#: Share of readings that are outliers, and the least and the mean further size of one. [sigma]
OUTLIERS, OUTLIER_LEAST, OUTLIER_MORE = 0.05, 5.0, 5.0
#: Step of the grid on which 1/f noise is made. [s]
_FLICKER_STEP_S = 120.0
#: Recordings are rounded to so many sigmas in the kind that is.
ROUNDED_TO = 2.0


@dataclass(frozen=True)
class Drawn:
    """Noise of n pointings [sigma], and what is known of it."""

    value: Array  #: shape (n, 2)
    #: The scatter of each reading, where it differs between them; shape (n, 2).
    sigma: Array | None = None


@dataclass(frozen=True)
class Kind:
    """A kind of noise."""

    #: Random numbers, pointings -> the noise.
    draw: Callable[[np.random.Generator, Pointings], Drawn]
    #: Where it is drawn; the common ones by default.
    skies: tuple[str, ...] = ("half", "band", "low")
    sessions: tuple[int, ...] = (1, 4, 12)  #: of how many nights
    #: How long its drift remembers; None where it has none, infinite for one that never forgets.
    memory_s: float | None = None
    #: Whether the mean of its noise is what a constant term should come out as.
    centred: bool = True


def _white(rng: np.random.Generator, at: Pointings) -> Drawn:
    return Drawn(rng.standard_normal((len(at), 2)))


def _student(rng: np.random.Generator, at: Pointings) -> Drawn:
    return Drawn(rng.standard_t(3, (len(at), 2)))


def _outliers(rng: np.random.Generator, at: Pointings, signs: tuple[int, ...]) -> Drawn:
    value = rng.standard_normal((len(at), 2))
    hit = rng.uniform(size=value.shape) < OUTLIERS
    size = OUTLIER_LEAST + rng.exponential(OUTLIER_MORE, value.shape)
    return Drawn(value + hit * size * rng.choice(signs, value.shape))


def _skewed(rng: np.random.Generator, at: Pointings) -> Drawn:
    """Return gamma noise of shape 2, mean 0, variance 1, its tail to one side of each axis."""
    value = (rng.gamma(2.0, 1.0, (len(at), 2)) - 2.0) / np.sqrt(2.0)
    return Drawn(value * rng.choice([-1, 1], 2))


def _scattered(rng: np.random.Generator, scale: Array) -> Drawn:
    """Return noise whose scatter goes as `scale` (n,) and has the median 1."""
    scale = (scale / np.median(scale))[:, None]
    return Drawn(scale * rng.standard_normal((len(scale), 2)), np.repeat(scale, 2, axis=1))


def _factor(rng: np.random.Generator) -> float:
    """Return by how much the largest scatter exceeds the least."""
    return float(rng.uniform(3, 6))


def _by_elevation(rng: np.random.Generator, at: Pointings) -> Drawn:
    return _scattered(rng, 1 / np.sin(at.el))


def _by_azimuth(rng: np.random.Generator, at: Pointings) -> Drawn:
    toward = rng.uniform(0, 2 * np.pi)
    return _scattered(rng, _factor(rng) ** (np.cos(at.az - toward) / 2))


def _by_session(rng: np.random.Generator, at: Pointings) -> Drawn:
    power = rng.permutation(np.linspace(-0.5, 0.5, at.sessions))
    return _scattered(rng, (_factor(rng) ** power)[at.night])


def _wandering(rng: np.random.Generator, at: Pointings) -> Drawn:
    """Return noise whose scatter itself wanders within hours, by a factor of 3 to 6."""
    wander = ou(rng, at.time_s, rng.uniform(1, 6) * _HOUR_S)
    return _scattered(rng, _factor(rng) ** (np.clip(wander, -2, 2) / 4))


def _correlated(rng: np.random.Generator, at: Pointings) -> Drawn:
    value = rng.standard_normal((len(at), 2))
    rho = rng.uniform(0.6, 0.9) * rng.choice([-1, 1])
    value[:, 1] = rho * value[:, 0] + np.sqrt(1 - rho**2) * value[:, 1]
    return Drawn(value)


def _drifting(memory_s: float) -> Kind:
    def draw(rng: np.random.Generator, at: Pointings) -> Drawn:
        drift = np.stack([ou(rng, at.time_s, memory_s) for _ in range(2)], axis=1)
        return Drawn(rng.standard_normal((len(at), 2)) + rng.uniform(0.5, 1.5, 2) * drift)

    return Kind(draw, memory_s=memory_s)


def _flicker(rng: np.random.Generator, at: Pointings) -> Drawn:
    """Return white noise and as much noise of power 1/f, from the campaign's length on."""
    steps = int(np.ptp(at.time_s) / _FLICKER_STEP_S) + 2
    frequency = np.fft.rfftfreq(2 * steps, _FLICKER_STEP_S)
    series = []
    for _ in range(2):
        shape = (rng.standard_normal((2, len(frequency))) * [[1], [1j]]).sum(axis=0)
        shape[0] = 0
        shape[1:] /= np.sqrt(frequency[1:])
        value = np.fft.irfft(shape)[:steps]
        seen = np.interp(at.time_s - at.time_s[0], np.arange(steps) * _FLICKER_STEP_S, value)
        series.append(rng.uniform(0.5, 1.5) * seen / np.std(seen))
    return Drawn(rng.standard_normal((len(at), 2)) + np.stack(series, axis=1))


def _walking(rng: np.random.Generator, at: Pointings) -> Drawn:
    """Return white noise and a walk that goes on through nights and days, 0.3 to 1 sigma in 8 h."""
    step = np.sqrt(np.diff(at.time_s, prepend=at.time_s[0]) / (8 * _HOUR_S))
    walk = np.cumsum(step[:, None] * rng.standard_normal((len(at), 2)), axis=0)
    return Drawn(rng.standard_normal((len(at), 2)) + rng.uniform(0.3, 1.0, 2) * walk)


def _source_offsets(rng: np.random.Generator, at: Pointings) -> Drawn:
    """Return white noise and places of the catalogue that are off by half a sigma to one."""
    places = int(at.source.max()) + 1
    size = rng.uniform(0.5, 1.0)
    east, north = (size * rng.standard_normal(places)[at.source] for _ in range(2))
    return Drawn(rng.standard_normal((len(at), 2)) + np.stack(at.moved(east, north), axis=1))


def _nights(rng: np.random.Generator, at: Pointings) -> Drawn:
    """Return white noise and zeros and tilts that differ from night to night by 0.3 to 1 sigma."""
    azimuth, elevation, north, east = (
        rng.uniform(0.3, 1.0) * rng.standard_normal(at.sessions)[at.night] for _ in range(4)
    )
    sin_e, cos_e = np.sin(at.el), np.cos(at.el)
    across = azimuth * cos_e + sin_e * (north * np.sin(at.az) - east * np.cos(at.az))
    along = elevation + north * np.cos(at.az) + east * np.sin(at.az)
    return Drawn(rng.standard_normal((len(at), 2)) + np.stack([across, along], axis=1))


#: Scatter that grows toward the horizon is drawn where elevations show it.
_DEEP = ("wide", "half-around", "low")
#: What differs between nights needs several of them.
_SEVERAL = (4, 12)

KINDS: dict[str, Kind] = {
    "white": Kind(_white),
    "student-3": Kind(_student),
    "outliers-both-ways": Kind(lambda rng, at: _outliers(rng, at, (-1, 1))),
    "outliers-one-sided": Kind(lambda rng, at: _outliers(rng, at, (1,))),
    # Where the noise leans to one side, what a constant should be is a matter of taste.
    "skewed": Kind(_skewed, centred=False),
    "scatter-elevation": Kind(_by_elevation, skies=_DEEP),
    "scatter-azimuth": Kind(_by_azimuth),
    "scatter-session": Kind(_by_session, sessions=_SEVERAL),
    "scatter-wandering": Kind(_wandering),
    "axes-correlated": Kind(_correlated),
    "rounded": Kind(_white),
    "drift-20min": _drifting(1200.0),
    "drift-2h": _drifting(2 * _HOUR_S),
    "drift-12h": _drifting(12 * _HOUR_S),
    "drift-3d": _drifting(3 * DAY_S),
    "flicker": Kind(_flicker, memory_s=np.inf),
    "random-walk": Kind(_walking, memory_s=np.inf),
    "source-offsets": Kind(_source_offsets, skies=("tracked",)),
    "nights-differ": Kind(_nights, sessions=_SEVERAL),
    "sigma-given": Kind(_by_elevation, skies=_DEEP),
}
#: The kinds whose recordings are rounded, and whose recordings say their errors.
ROUNDED, SIGMA_GIVEN = "rounded", "sigma-given"
