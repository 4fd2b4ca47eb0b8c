"""Weather on the structure: the Sun's heat, the air's temperature, the wind."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
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
from pyport.effects.circumstances import DAY_S, NIGHT_GAP_S
from pyport.effects.sky.frame import sun
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
        reversed="no heat does that: an offset, or the Sun's direction, may have the wrong sign",
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

#: On other mounts than an alt-azimuth one, where that is "as cos E" of an axis, the tube sags
#: along elevation as ever.
_SAGS = "as the tube sags"

#: Time constants of steel that are tried [h], thin to thick. What steel of any between three
#: quarters of an hour and six hours draws in a night, one of these draws to a cosine of 0.97.
STEEL_H = (1, 2, 4)
#: Variance of the weather within a night over that of the daily wave: where a night hardly bends
#: the wave, it is the weather that bends the night. Of more nights it is less in the mean.
WEATHER = 0.1
#: What bends the structure: the air's temperature, that of steel which comes late, and the
#: difference between thin parts, which are as warm as the air, and thick ones.
AIR, STEEL, BETWEEN = "air", "steel", "thin less thick"
#: What a member is called, and what the offsets show.
ACTS = {
    AIR: ("", "in proportion to the air temperature"),
    STEEL: (", {} h late", "in proportion to the air temperature, some hours late"),
    BETWEEN: (
        ", thin parts against thick ones {} h late",
        "in proportion to how fast the air warms and cools",
    ),
}


def acting_c(at: Circumstances, way: str, lag_h: float) -> Array:
    """Return the temperature, or difference of two, that bends the structure [deg C], (n,)."""
    air = at.numbers("temperature_c")
    if way == AIR:
        return air
    steel = steel_c(at, lag_h)
    return steel if way == STEEL else air - steel


def steel_c(at: Circumstances, lag_h: float) -> Array:
    """Return the temperature [deg C] of steel that follows the air, shape (n,).

    It is dT/dt = (T_air - T) / tau, exactly, for air that changes evenly from one recording of an
    antenna to the next. What the air was before a night is not known, nor over any gap as long as
    that between two nights: there the steel starts as if the air had always gone through its day
    as it does in these recordings. NaN where the air's temperature or the time is unknown.

    Raises `MissingColumn`: the recordings are of one moment, which tells no past.
    """
    air, time = at.numbers("temperature_c"), at.numbers("time")
    known = np.isfinite(air) & np.isfinite(time)
    if not known.any() or np.ptp(time[known]) == 0:
        raise MissingColumn("temperature_c of the hours before")
    antenna = at.columns["antenna"].astype(str) if "antenna" in at else np.full(len(at), "")
    found = np.full(len(at), np.nan)
    for name in np.unique(antenna):
        rows = np.flatnonzero(known & (antenna == name))
        rows = rows[np.argsort(time[rows], kind="stable")]
        step_s = np.diff(time[rows])
        goes_on = step_s <= NIGHT_GAP_S
        night = np.concatenate([[0], np.cumsum(~goes_on)])
        begins = air[rows] + _above_air(air[rows], time[rows], night, lag_h * 3600.0)
        found[rows] = _low_pass(air[rows], begins, step_s, goes_on, lag_h * 3600.0)
    return found


def _above_air(air: Array, time: Array, night: Codes, constant_s: float) -> Array:
    """Return how much warmer than the air [K] steel is if it was always as in these nights, (n,).

    Day by day the air goes as a wave, of which each night shows a part about a mean of its own.
    """
    angle = 2 * np.pi * (time / DAY_S % 1)
    wave = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    columns = np.column_stack([wave, air])
    means = np.stack([np.bincount(night, one) for one in columns.T], axis=1)
    columns = columns - (means / np.bincount(night)[:, None])[night]
    products = columns.T @ columns / len(air)
    doubt = WEATHER / (1 + night[-1]) * np.eye(2)
    cosine, sine = np.linalg.solve(products[:2, :2] + doubt, products[:2, 2])
    # A low pass turns the wave back by an angle whose tangent this is, and makes it smaller.
    late = 2 * np.pi * constant_s / DAY_S
    lost = late / (1 + late**2) * np.array([late * cosine + sine, late * sine - cosine])
    return np.asarray(-wave @ lost)


def _low_pass(
    air: Array, begins: Array, step_s: Array, goes_on: NDArray[np.bool_], constant_s: float
) -> list[float]:
    """Return what a low pass of the first order makes of temperatures in order of time.

    Where one recording does not go on from the last it `begins` anew.
    """
    # Two rows of one moment: the quotient is one in the limit.
    span = np.maximum(step_s / constant_s, 1e-12)
    kept = np.where(goes_on, np.exp(-span), 0.0)
    late = -np.expm1(-span) / span
    drawn = np.where(goes_on, air[:-1] * (late - kept) + air[1:] * (1 - late), begins[1:])
    found = begins[:1].tolist()
    for share, toward in zip(kept.tolist(), drawn.tolist(), strict=True):
        found.append(found[-1] * share + toward)
    return found


def ways(at: Circumstances) -> list[tuple[str, float]]:
    """Return how the temperature may act, and how many hours late.

    Steel itself is tried where there is more than one night, or day: in one its temperature is a
    slow curve, and where that began is not known.
    """
    found: list[tuple[str, float]] = [(AIR, 0)]
    if "time" in at and np.isfinite(time := at.numbers("time")).all() and np.ptp(time) > 0:
        found += [(BETWEEN, hours) for hours in STEEL_H]
        if np.ptp(time) > DAY_S or np.diff(np.sort(time)).max() > NIGHT_GAP_S:
            found += [(STEEL, hours) for hours in STEEL_H]
    return found


def _temperature(
    through: str, reference_c: float | None = None, way: str = AIR, lag_h: float = 0
) -> Effect:
    """Return offsets proportional to a temperature above a reference, the mean by default."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        excess = acting_c(at, way, lag_h)
        if way != BETWEEN:
            air = at.numbers("temperature_c")
            excess = excess - (np.nanmean(air) if reference_c is None else reference_c)
        if sags:
            return stack(at, (0, excess * np.cos(at.el)))
        size = excess * _THROUGH[through](at)
        return stack(at, (size, 0), (0, size))

    sags = through == _SAGS
    of_axes = Coefficient("temperature_xel", "arcsec/K"), Coefficient("temperature_el", "arcsec/K")
    late, pattern = ACTS[way]
    return Effect(
        "temperature",
        "the structure bends as the air warms and cools",
        _GREVE,
        (Coefficient("temperature_sag", "arcsec/K"),) if sags else of_axes,
        basis,
        variant=through + late.format(lag_h),
        profile=_temperatures,
        acts_in=SKY if sags else AXES,
        pattern=pattern,
        needs=("temperature_c",),
        formula=(
            "c (T - T0), c (Ts - T0) or c (T - Ts), tau dTs/dt = T - Ts; times 1, cos E or sin E",
            "the same with a coefficient of its own",
        ),
        driver="temperature_c",
        looks_back=way != AIR,
        member={"through": through}
        | ({} if reference_c is None else {"reference_c": reference_c})
        | ({} if way == AIR else {"way": way, "lag_h": lag_h}),
        make=_temperature,
    )


def _temperatures(at: Circumstances) -> tuple[Effect, ...]:
    """Return every way that a temperature may act, above the mean of these recordings."""
    reference_c = float(np.nanmean(at.numbers("temperature_c")))
    through = tuple(_THROUGH) if at.sky is None else (*_THROUGH, _SAGS)
    return tuple(_temperature(one, reference_c, *way) for way in ways(at) for one in through)


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
        reversed="no wind does that: its direction may be where it blows to, not where it is from",
        needs=("wind_speed_m_s", "wind_az_deg"),
        formula=("t v^2 sin E sin(A - A0)", "t v^2 cos(A - A0), A0 away from where the wind blows"),
        driver="wind_speed_m_s",
    ),
)
