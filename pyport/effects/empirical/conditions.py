"""Conditions that a term of the mount may follow: recorded, or computed from time and place."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pyport.angles import DEG, Array
from pyport.columns import COLUMNS
from pyport.effects.base import THE_HOUR, Circumstances, MissingColumn
from pyport.effects.circumstances import DAY_S, mostly_known
from pyport.effects.sessions import since_begun, spans_of
from pyport.effects.telescope.rotation import (
    LEAST_ARC,
    OFFSETS_AND_SIZES,
    PLACES,
    angle_columns,
    arc,
)
from pyport.effects.telescope.thermal import ACTS, AIR, BETWEEN, acting_c, sun, ways

#: So many conditions are tried: those of the contract, the hour, the Sun, and four columns of any
#: name. With each the price of a choice and the time of a search grow.
MOST_DRIVERS = 10
#: A condition must have taken more values than this: a cubic, or a step, passes through fewer.
FEW_VALUES = 4
#: A column of which so much of the variance is drawn by the direction is a name for it.
BY_DIRECTION = 0.9
#: Terms of the mount that a condition may drive.
_OF_MOUNT = ("tilt", "sag_cosine", "elevation_zero", "collimation")
#: Of refraction alone it is known what changes it: the density of the air.
OF_AIR = "refraction"
#: The term that a condition may drive of which nothing is known but the name. An offset that is
#: the same all over the sky, or nearly so as a sag is, and follows such a column names no part
#: of the telescope: it stays a curve in that column, without a name.
_BY_ANYTHING = ("tilt",)
#: What the temperature of the air does to zeros and sag, at once or late, is the effect
#: `temperature`.
_BEYOND_TEMPERATURE = ("tilt",)
_BY_AIR = {
    "temperature_c": (*_BEYOND_TEMPERATURE, OF_AIR),
    "pressure_hpa": (*_OF_MOUNT, OF_AIR),
}

#: In what time what changes when a session begins, as the dome opens or drives warm up, dies away
#: [h]. In a night, what any time between twenty minutes and four hours draws, one of these draws to
#: a cosine of 0.97.
SETTLES_H = (0.5, 1.0, 2.0)
_BEGINNING = "the beginning of the session"

#: Columns that are no condition: places, times of a scan, and how it was made.
_NO_CONDITION = frozenset(
    {
        *("time", "order", "hour_angle", "ra", "dec", "sun_az", "sun_el", "wind_az"),
        *("scan_direction", "scan_rate", "frequency_mhz"),
    }
)
#: Parts of a column's name that say that it is a time or how the measurement was made.
_NO_NAME = (
    PLACES
    | OFFSETS_AND_SIZES
    | {
        *("hour", "time", "date", "day", "mjd", "jd", "utc", "ut", "airmass"),
        *("scan", "number", "num", "index", "line", "row", "id", "obsnum", "seq"),
        *("exptime", "duration", "integration", "frequency", "snr", "flux", "peak", "amplitude"),
        *("weight", "quality", "tsys"),
    }
)
#: Parts of a column's name by which it is known what moves: a focus, a temperature.
_KNOWN = frozenset({"focus", "temperature", "temp"})

#: The unit that a column's ending stands for.
_UNITS = {
    "m_s": "(m/s)",
    "c": "K",
    "k": "K",
    "pct": "%",
    "hpa": "hPa",
    "bar": "bar",
    "mm": "mm",
    "um": "um",
    "deg": "deg",
    "arcmin": "arcmin",
    "arcsec": "arcsec",
}
#: What else a coefficient may be counted per: in words it is a unit, and no column's name.
_TIMES = frozenset({"s", "h", "d"})


def unit_in_words(unit: str) -> str:
    """Return a coefficient's unit as it is said: per unit of a column whose own is not known."""
    of, slash, column = unit.partition("/")
    if not slash or column in _TIMES or column in _UNITS.values():
        return unit
    return f"{of} per unit of {column}"


@dataclass(frozen=True)
class Driver:
    """A condition that a term may follow."""

    name: str  #: the column as the contract spells it, or what is computed
    unit: str  #: of its value
    #: Circumstances -> its values, one or more columns of shape (n,), NaN where unknown.
    values: Callable[[Circumstances], tuple[Array, ...]]
    labels: tuple[str, ...] = ("",)  #: what is added to a coefficient's name for each of them
    terms: tuple[str, ...] = _OF_MOUNT  #: which of the terms may follow it
    follows: str = THE_HOUR  #: the `driver` of the effects
    changes: str = ""  #: when it changes, where that is more than that it does
    #: What a file states of it besides its name: what is taken off the values, how late it acts.
    #: See `driver_of`.
    stated: Mapping[str, Any] = field(default_factory=dict)
    looks_back: bool = False  #: whether its values depend on the rows before


def tried(at: Circumstances) -> list[Driver]:
    """Return the conditions worth trying, how the air acts late, and what settles in a session."""
    found = drivers(at)
    settling = [_settling(hours, spans) for spans in _begun(at) for hours in SETTLES_H]
    air = [one.stated["centre"] for one in found if one.follows == "temperature_c"]
    return found + [_late(*way, air[0]) for way in ways(at) if air and way[0] != AIR] + settling


def driver_of(
    follows: str,
    centre: float | None = None,
    way: str = AIR,
    lag_h: float = 0,
    settles_h: float | None = None,
    sessions: Sequence[str] = (),
    spans_s: Sequence[Sequence[float]] = (),
) -> Driver:
    """Return the condition that a file states: see `Effect.member`."""
    if way != AIR:
        return _late(way, lag_h, centre or 0.0)
    if settles_h is not None:
        return _settling(settles_h, dict(zip(sessions, map(list, spans_s), strict=True)))
    if follows == _TIME_OF_DAY.name:
        return _TIME_OF_DAY
    if follows == _SUN:
        return _above_sun(centre or 0.0)
    return OF_TEMPERATURE if centre is None else _about(follows, centre)


def drivers(at: Circumstances) -> list[Driver]:
    """Return the conditions that are tried, at most `MOST_DRIVERS`."""
    return _in_order(at)[:MOST_DRIVERS]


def untried(at: Circumstances) -> list[str]:
    """Return the names of the conditions that are worth trying, too, and one too many."""
    return [one.name for one in _in_order(at)[MOST_DRIVERS:]]


def _in_order(at: Circumstances) -> list[Driver]:
    """Return the conditions worth trying, those first that are the likeliest to drive a term.

    First what is known to move a telescope: the temperature, the time of the day, the height of
    the Sun, the wind, the pressure, the humidity. Then every other column of numbers that is no
    place, time, offset, error or detail of the measurement, by its name; that takes more than a
    few values; that does not only grow or only fall with time (a counter, a clock: `drift`) and is
    not drawn by the direction; those first that the direction draws least.
    """
    known = [
        _recorded(at, "temperature_c"),
        _time_of_day(at),
        _sun(at),
        _recorded(at, "wind_speed_m_s"),
    ]
    others = {name: _free(at, name) for name in at.columns if _may_drive(at, name)}
    ranked = sorted(
        (name for name in others if others[name] > 1 - BY_DIRECTION),
        key=lambda name: (name not in OF_WEATHER, -others[name]),
    )
    found = [*known, *(_recorded(at, name) for name in ranked)]
    return [one for one in found if one is not None]


def _recorded(at: Circumstances, name: str) -> Driver | None:
    """Return a recorded condition less its median here; None where it hardly varies."""
    if not _varies(at, name):
        return None
    moves = name in OF_WEATHER or _KNOWN & set(name.split("_"))
    terms = _BY_AIR.get(name, _OF_MOUNT if moves else _BY_ANYTHING)
    return _about(name, float(np.nanmedian(at.numbers(name))), terms)


def _about(name: str, centre: float, terms: tuple[str, ...] = _OF_MOUNT) -> Driver:
    """Return a recorded condition less a number."""
    unit = next((_UNITS[end] for end in _UNITS if name.endswith(f"_{end}")), name)
    return Driver(
        name,
        unit,
        lambda at: (at.numbers(name) - centre,),
        terms=terms,
        follows=name,
        stated={"centre": centre},
    )


def _late(way: str, lag_h: float, centre: float) -> Driver:
    """Return what follows the air's temperature late, or how far that is behind."""
    offset = 0.0 if way == BETWEEN else centre
    return Driver(
        f"temperature_c{ACTS[way][0].format(lag_h)}",
        "K",
        lambda at: (acting_c(at, way, lag_h) - offset,),
        terms=_BEYOND_TEMPERATURE,
        follows="temperature_c",
        stated={"follows": "temperature_c", "centre": centre, "way": way, "lag_h": lag_h},
        looks_back=True,
    )


def _begun(at: Circumstances) -> list[dict[str, list[float]]]:
    """Return when each session began and ended [s], where there are several."""
    spans = spans_of(at) if _varies(at, "time") else {}
    return [spans] if len(spans) > 1 else []


def _settling(hours: float, spans: Mapping[str, Sequence[float]]) -> Driver:
    """Return what is one when a session begins and dies away in some hours."""
    return Driver(
        f"{_BEGINNING}, settling in {hours:g} h",
        "",
        lambda at: (np.exp(-since_begun(at, spans) / (3600 * hours)),),
        ("_at_the_beginning",),
        changes=f"when a session begins, and settles in {hours:g} h",
        stated={
            "follows": _BEGINNING,
            "settles_h": hours,
            "sessions": list(spans),
            "spans_s": list(spans.values()),
        },
        looks_back=True,
    )


#: The contract's conditions of the weather.
OF_WEATHER = frozenset(one.name for one in COLUMNS if one.weather)


def _time_of_day(at: Circumstances) -> Driver | None:
    """Return once a day, as cosine and sine of UTC: what any local time is a mixture of."""
    return _TIME_OF_DAY if _varies(at, "time") else None


def _hours(at: Circumstances) -> tuple[Array, ...]:
    angle = at.numbers("time") / DAY_S % 1 * 2 * np.pi
    return np.cos(angle), np.sin(angle)


_TIME_OF_DAY = Driver("the time of day", "", _hours, ("_cosine_of_utc", "_sine_of_utc"))
_SUN = "sun_el_deg"


def _sun(at: Circumstances) -> Driver | None:
    """Return the elevation of the Sun, as recorded or computed [deg], less its median here."""
    try:
        return _above_sun(float(np.nanmedian(_height(at))))
    except MissingColumn:
        return None


def _height(at: Circumstances) -> Array:
    return (at.numbers("sun_el") if "sun_el" in at else sun(at)[1]) / DEG


def _above_sun(centre: float) -> Driver:
    stated = {"centre": centre}
    return Driver(_SUN, "deg", lambda at: (_height(at) - centre,), stated=stated)


def _varies(at: Circumstances, name: str) -> bool:
    """Tell whether a column holds numbers, known in half of the rows, of more than a few values."""
    if name not in at or at.columns[name].dtype.kind not in "fiu":
        return False
    values = np.asarray(at.columns[name], float)
    return mostly_known(values) and len(np.unique(values[np.isfinite(values)])) > FEW_VALUES


def _may_drive(at: Circumstances, name: str) -> bool:
    """Tell whether a column other than those known to move a telescope is a condition."""
    if name in _NO_CONDITION | {"temperature_c", "wind_speed_m_s"} or not _varies(at, name):
        return False
    if _NO_NAME & set(name.split("_")):
        return False
    angle = angle_columns(at).get(name)
    if angle is not None and arc(angle) >= LEAST_ARC:
        return False  # an angle that goes round has no middle: see `rotator_circle`
    return not _counts(at, np.asarray(at.columns[name], float))


def _counts(at: Circumstances, values: Array) -> bool:
    """Tell whether a column only grows or only falls with the rows or with time."""
    orders = [np.arange(len(values))]
    if "time" in at:
        orders.append(np.argsort(np.asarray(at.column("time"), float), kind="stable"))
    for order in orders:
        steps = np.diff(values[order][np.isfinite(values[order])])
        if np.all(steps >= 0) or np.all(steps <= 0):
            return True
    return False


def _free(at: Circumstances, name: str) -> float:
    """Return what share of a column's variance low waves of azimuth and elevation leave."""
    values = np.asarray(at.columns[name], float)
    there = np.isfinite(values)
    az, el = at.az[there], at.el[there]
    waves = [np.ones(len(az)), np.cos(az), np.sin(az), np.cos(el), np.sin(el), np.sin(2 * el)]
    columns = np.stack(waves, axis=1)
    left = values[there] - columns @ np.linalg.lstsq(columns, values[there], rcond=1e-9)[0]
    # Each wave draws a share of pure noise as well, which a few rows would take for the direction.
    spare = max(len(left) - columns.shape[1], 1) / max(len(left) - 1, 1)
    return float(min(1.0, left.var() / spare / max(float(values[there].var()), 1e-300)))


#: The temperature of the air less its median in the recordings at hand.
OF_TEMPERATURE = Driver(
    "temperature_c",
    "K",
    lambda at: (at.numbers("temperature_c") - float(np.nanmedian(at.numbers("temperature_c"))),),
    terms=_BEYOND_TEMPERATURE,
    follows="temperature_c",
)
