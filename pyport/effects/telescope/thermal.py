"""Weather on the structure: the Sun's heat, the air's temperature, the wind."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pyport.angles import Array
from pyport.effects.base import (
    AXES,
    SKY,
    THE_HOUR,
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    stack,
)
from pyport.effects.sky.site import sun
from pyport.effects.telescope.geometry import tilt

_GREVE = "Greve & Bremer 2010, Thermal Design and Thermal Behaviour of Radio Telescopes"
_WIND = "Mangum et al. 2006, PASP 118, 1257: wind on antennas in the open"

#: A structure may follow the Sun so many hours late.
LAGS_H = (1, 2, 3)
#: Wind speed that the coefficient of `wind_tilt` is stated for [m/s].
REFERENCE_WIND_M_S = 10.0


def lean(at: Circumstances, toward: Array, size: Array | float = 1.0) -> tuple[Array, Array]:
    """Return (x, y) of an azimuth axis that leans by `size` toward an azimuth [rad]."""
    north, east = size * np.cos(toward), size * np.sin(toward)
    x, y = tilt(at)
    return x[:, 0] * north + x[:, 1] * east, y[:, 0] * north + y[:, 1] * east


def _sun(at: Circumstances, lag_h: int) -> tuple[Array, Array | None]:
    """Return azimuth and elevation of the Sun, as recorded where they were, else by ERFA."""
    if lag_h == 0 and "sun_az" in at:
        return at.numbers("sun_az"), at.numbers("sun_el") if "sun_el" in at else None
    if lag_h == 0 and "time" not in at:
        raise MissingColumn("sun_az_deg or time_utc")
    return sun(at, lag_h * 3600.0)


#: How strongly the Sun heats, by its elevation [rad]: what a variant says, and how.
_HEATS: dict[str, Callable[[Array], Array]] = {
    "day and night": np.ones_like,
    "while the Sun is up": lambda el: np.where(el > 0, 1.0, 0.0),
    "as the Sun is high": lambda el: np.maximum(np.sin(el), 0.0),
}
_ALWAYS, _BY_DAY, _AS_HIGH = _HEATS


def _thermal_tilt(heating: str = _ALWAYS, lag_h: int = 0) -> Effect:
    """Return a lean away from where the Sun was some hours ago, at all times or by day."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        sun_az, sun_el = _sun(at, lag_h)
        heat = 1.0 if sun_el is None else _HEATS[heating](sun_el)
        return stack(at, lean(at, sun_az + np.pi, heat))

    late = f", {lag_h} h late" if lag_h else ""
    return Effect(
        "thermal_tilt",
        "the side that the Sun heats grows",
        _GREVE,
        (Coefficient("thermal_tilt"),),
        basis,
        variant=f"{heating}{late}",
        profile=_thermal_tilts,
        acts_in=SKY,
        pattern="a lean away from the Sun",
        needs=("sun_az_deg or time_utc with latitude_deg and longitude_deg",),
        formula=("t sin E sin(A - A0)", "t cos(A - A0), A0 = A_sun + 180 deg"),
        parameter=lag_h * 3600.0,
        driver=THE_HOUR,
        member={"heating": heating, "lag_h": lag_h},
        make=_thermal_tilt,
    )


def _thermal_tilts(at: Circumstances) -> tuple[Effect, ...]:
    """Return a lean at all times and, where day is known from night, by day: at once and late."""
    _, sun_el = _sun(at, 0)
    always = _thermal_tilt()
    by_day: tuple[Effect, ...] = (_thermal_tilt(_BY_DAY), _thermal_tilt(_AS_HIGH))
    if sun_el is None or np.all(sun_el > 0):
        by_day = () if sun_el is None else by_day[1:]
    if "time" not in at or at.site is None or at.site.longitude is None:
        return always, *by_day
    return always, *by_day, *(_thermal_tilt(_BY_DAY, lag) for lag in LAGS_H)


#: Through which term a temperature acts: its name, and what it looks like across and along.
_THROUGH: dict[str, Callable[[Circumstances], Array | float]] = {
    "the same everywhere": lambda _: 1.0,
    "as cos E": lambda at: np.cos(at.el),
    "as sin E": lambda at: np.sin(at.el),
}


def _temperature(through: str, reference_c: float | None = None) -> Effect:
    """Return offsets proportional to the temperature above a reference, the mean by default."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        celsius = at.numbers("temperature_c")
        excess = celsius - (np.nanmean(celsius) if reference_c is None else reference_c)
        size = excess * _THROUGH[through](at)
        return stack(at, (size, 0), (0, size))

    return Effect(
        "temperature",
        "the structure bends as the air warms and cools",
        _GREVE,
        (Coefficient("temperature_xel", "arcsec/K"), Coefficient("temperature_el", "arcsec/K")),
        basis,
        variant=through,
        profile=_temperatures,
        acts_in=AXES,
        pattern="in proportion to the air temperature",
        needs=("temperature_c",),
        formula=("c (T - T0), times 1, cos E or sin E", "the same with a coefficient of its own"),
        driver="temperature_c",
        member={"through": through} | ({} if reference_c is None else {"reference_c": reference_c}),
        make=_temperature,
    )


def _temperatures(at: Circumstances) -> tuple[Effect, ...]:
    """Return every way that a temperature may act, above the mean of these recordings."""
    reference_c = float(np.nanmean(at.numbers("temperature_c")))
    return tuple(_temperature(through, reference_c) for through in _THROUGH)


def wind_tilt(at: Circumstances) -> tuple[Array, Array]:
    """Return a lean downwind that grows as the square of the wind, from where `wind_az` says."""
    pressure = (at.numbers("wind_speed_m_s") / REFERENCE_WIND_M_S) ** 2
    return stack(at, lean(at, at.numbers("wind_az") + np.pi, pressure))


EFFECTS = (
    _thermal_tilt(),
    _temperature("the same everywhere"),
    Effect(
        "wind_tilt",
        "the wind pushes the telescope over",
        _WIND,
        (Coefficient("wind_tilt_at_10_m_s"),),
        wind_tilt,
        acts_in=SKY,
        pattern="a lean downwind that grows as the square of the wind",
        needs=("wind_speed_m_s", "wind_az_deg"),
        formula=("t v^2 sin E sin(A - A0)", "t v^2 cos(A - A0), A0 away from where the wind blows"),
        driver="wind_speed_m_s",
    ),
)
