"""Where and when a drawn telescope points: nights, a catalogue of sources, weather.

Angles are radians, times seconds from the first midnight (UTC) of the campaign.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DAY_S = 86400.0
#: The first midnight of every campaign.
START = np.datetime64("2024-03-01T00:00:00", "ms")
#: The Earth turns so much in a second of UTC. [rad]
SIDEREAL_RAD_PER_S = np.radians(360.98564736629) / DAY_S
#: Enough sources that some are in every part of the sky; so few that they come back.
SOURCES = 300
#: A handful, followed from rising to setting.
FEWEST_TRACKED, MOST_TRACKED = 10, 16


@dataclass(frozen=True)
class Pointings:
    """n pointings of one telescope, ordered by time.

    `time_s`, `az`, `el`, `ra`, `dec` and every column of `weather` have shape (n,); `night`
    counts sessions from 0; `source` is a number of the catalogue.
    """

    latitude: float
    longitude: float
    time_s: Array
    night: NDArray[np.int64]
    source: NDArray[np.int64]
    az: Array
    el: Array
    ra: Array
    dec: Array
    weather: dict[str, Array]

    def __len__(self) -> int:
        """Return n."""
        return len(self.time_s)

    @property
    def sessions(self) -> int:
        """Return the number of nights."""
        return int(self.night.max()) + 1

    def moved(self, east: Array, north: Array) -> tuple[Array, Array]:
        """Return (x, y) of moving places by `east` and `north` on the sky, same unit as theirs."""
        step = 1e-6
        x, y = np.zeros(len(self)), np.zeros(len(self))
        for size, ra, dec in (
            (east, self.ra + step / np.cos(self.dec), self.dec),
            (north, self.ra, self.dec + step),
        ):
            az, el = horizontal(ra, dec, self.time_s, self.latitude, self.longitude)
            turn = (az - self.az + np.pi) % (2 * np.pi) - np.pi
            x = x + size * turn * np.cos(self.el) / step
            y = y + size * (el - self.el) / step
        return x, y


def horizontal(
    ra: Array, dec: Array, time_s: Array, latitude: float, longitude: float
) -> tuple[Array, Array]:
    """Return azimuth (from north through east) and elevation of places at times."""
    days = (START - np.datetime64("2000-01-01T12:00:00", "ms")) / np.timedelta64(1, "D")
    at_start = np.radians(280.46061837) + SIDEREAL_RAD_PER_S * DAY_S * days
    hour = at_start + SIDEREAL_RAD_PER_S * time_s + longitude - ra
    up = np.sin(latitude) * np.sin(dec) + np.cos(latitude) * np.cos(dec) * np.cos(hour)
    north = np.cos(latitude) * np.sin(dec) - np.sin(latitude) * np.cos(dec) * np.cos(hour)
    east = -np.cos(dec) * np.sin(hour)
    return np.arctan2(east, north) % (2 * np.pi), np.arcsin(np.clip(up, -1, 1))


#: Azimuth, elevation -> whether a place may be observed.
Region = Callable[[Array, Array], NDArray[np.bool_]]


def _half_above(_: np.random.Generator) -> Region:
    return lambda _az, el: (el > np.radians(30)) & (el < np.radians(87))


def _half_around(rng: np.random.Generator) -> Region:
    middle = rng.uniform(0, 2 * np.pi)
    return lambda az, el: (np.cos(az - middle) > 0) & (el > np.radians(10)) & (el < np.radians(87))


def _wide(_: np.random.Generator) -> Region:
    return lambda _az, el: (el > np.radians(10)) & (el < np.radians(87))


def _band(rng: np.random.Generator) -> Region:
    low = np.radians(rng.uniform(20, 50))
    high = low + np.radians(rng.uniform(18, 28))
    return lambda _, el: (el > low) & (el < high)


def _low(_: np.random.Generator) -> Region:
    return lambda _az, el: (el > np.radians(6)) & (el < np.radians(32))


#: Kinds of sky: half of it (above 30 deg, or half of the circle of azimuths), ...
SKIES = {
    "half": lambda rng: (_half_above, _half_around)[rng.integers(2)](rng),
    "half-around": _half_around,
    "wide": _wide,
    "band": _band,
    "low": _low,
    "tracked": _wide,
}


def draw(rng: np.random.Generator, rows: int, sessions: int, sky: str) -> Pointings:
    """Draw pointings of a campaign."""
    time_s, night = _nights(rng, rows, sessions)
    latitude = float(np.radians(rng.uniform(25, 55)) * rng.choice([-1, 1]))
    longitude = float(np.radians(rng.uniform(-180, 180)))
    region = SKIES[sky](rng)
    for _ in range(1000):
        count = int(rng.integers(FEWEST_TRACKED, MOST_TRACKED + 1)) if sky == "tracked" else SOURCES
        ra = rng.uniform(0, 2 * np.pi, count)
        dec = np.arcsin(rng.uniform(-1, 1, count))
        az, el = horizontal(ra, dec, time_s[:, None], latitude, longitude)
        there = region(az, el)
        if there.any(axis=1).all():
            break
    else:
        raise RuntimeError(f"no catalogue fills the sky {sky!r}")
    # Whichever of those that are up has the highest lot is observed.
    source = np.argmax(np.where(there, rng.uniform(size=there.shape), -1.0), axis=1)
    row = np.arange(rows)
    return Pointings(
        latitude,
        longitude,
        time_s,
        night,
        source,
        az[row, source],
        el[row, source],
        ra[source],
        dec[source],
        _weather(rng, time_s),
    )


def _nights(rng: np.random.Generator, rows: int, sessions: int) -> tuple[Array, NDArray[np.int64]]:
    """Return times and nights: some hours on days that follow each other, or days apart."""
    share = rng.uniform(0.5, 1.5, sessions)
    count = np.maximum(np.round(rows * share / share.sum()).astype(int), 2)
    count[np.argmax(count)] += rows - count.sum()
    apart = 1 if rng.uniform() < 0.5 else 8
    day = np.concatenate([[0], np.cumsum(rng.integers(1, apart + 1, sessions - 1))])
    begin = day * DAY_S + rng.uniform(0, DAY_S / 3) + rng.uniform(-3600, 3600, sessions)
    length = rng.uniform(5, 11, sessions) * 3600
    night = np.repeat(np.arange(sessions), count)
    phase = np.concatenate([np.sort(rng.uniform(size=n)) for n in count])
    return begin[night] + length[night] * phase, night


def _weather(rng: np.random.Generator, time_s: Array) -> dict[str, Array]:
    """Return weather that changes through the day and from day to day, and moves nothing."""

    def series(mean: float, daily: float, fast: float, slow: float) -> Array:
        phase = 2 * np.pi * (time_s / DAY_S + rng.uniform())
        return (
            mean
            + daily * np.sin(phase)
            + fast * ou(rng, time_s, 3 * 3600.0)
            + slow * ou(rng, time_s, 3 * DAY_S)
        )

    temperature = series(rng.uniform(-5, 15), rng.uniform(2, 6), 0.7, 3)
    wind = series(0, 0.2, 0.3, 0.4)
    return {
        "temperature_c": np.round(temperature, 1),
        "pressure_hpa": np.round(series(rng.uniform(700, 1000), 0.5, 0.3, 4), 1),
        "humidity_pct": np.round(np.clip(series(50, 8, 4, 12), 3.0, 100.0), 0).astype(float),
        "wind_speed_m_s": np.round(4 * np.exp(wind), 1),
        "wind_az_deg": np.round(np.degrees(series(3, 0.3, 0.4, 1.5)) % 360, 0),
    }


def ou(rng: np.random.Generator, time_s: Array, memory_s: float) -> Array:
    """Return a stationary Ornstein-Uhlenbeck series of unit variance at ascending times."""
    kept = np.exp(-np.diff(time_s) / memory_s)
    kick = rng.standard_normal(len(time_s))
    value = np.empty(len(time_s))
    value[0] = kick[0]
    fresh = np.sqrt(1 - kept**2)
    for n in range(1, len(value)):
        value[n] = kept[n - 1] * value[n - 1] + fresh[n - 1] * kick[n]
    return value
