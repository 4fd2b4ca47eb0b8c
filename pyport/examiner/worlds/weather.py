"""Weather with seasons, days and whims, and random walks that come home."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array

_DAY_S = 86400.0
_YEAR_S = 365.2422 * _DAY_S
_HOTTEST_HOUR = 15.0
_HOTTEST_DAY = 205.0


def wander(rng: np.random.Generator, time_s: Array, memory_s: float) -> Array:
    """Return an Ornstein-Uhlenbeck process of unit rms at ascending times.

    `rng`: where the randomness comes from.
    `time_s`: times [s], ascending, shape (n,).
    `memory_s`: its correlation falls by e in this time [s].
    """
    kick = rng.standard_normal(len(time_s))
    kept = np.exp(-np.diff(time_s, prepend=time_s[:1]) / memory_s)
    value = np.empty(len(time_s))
    state = kick[0]
    for i, (keep, new) in enumerate(zip(kept, kick, strict=True)):
        state = keep * state + np.sqrt(1 - keep**2) * new
        value[i] = state
    return value


def weather(
    rng: np.random.Generator, time_s: Array, longitude: float, height_m: float, *, north: bool
) -> dict[str, Array]:
    """Return the weather columns of the contract for ascending times, shape (n,) each.

    `rng`: where the randomness comes from.
    `time_s`: UTC, seconds since 1970, ascending.
    `longitude`: east positive [rad]: what time of the day it is.
    `height_m`: how thin the air is.
    `north`: which half of the Earth it is, for the seasons.
    """
    local_hour = (time_s / 3600 + longitude * 12 / np.pi) % 24
    year_day = (time_s % _YEAR_S) / _DAY_S
    day = np.cos((local_hour - _HOTTEST_HOUR) * np.pi / 12)
    season = np.cos((year_day - _HOTTEST_DAY) * 2 * np.pi * _DAY_S / _YEAR_S)
    if not north:
        season = -season

    temperature = 12 + 9 * season + 6 * day + 3 * wander(rng, time_s, 2 * _DAY_S)
    humidity = 65 - 15 * day + 15 * wander(rng, time_s, 1.5 * _DAY_S)
    pressure = 1013 * np.exp(-height_m / 8400) + 8 * wander(rng, time_s, 2.5 * _DAY_S)
    gust = 3 * wander(rng, time_s, 6 * 3600.0), 3 * wander(rng, time_s, 6 * 3600.0)
    mean = 4 * rng.standard_normal(2)
    east, north = gust[0] + mean[0], gust[1] + mean[1]
    return {
        "temperature_c": temperature,
        "pressure_hpa": pressure,
        "humidity_pct": np.clip(humidity, 8, 100),
        "wind_speed_m_s": np.hypot(east, north),
        "wind_az_deg": np.degrees(np.arctan2(-east, -north)) % 360,
    }
