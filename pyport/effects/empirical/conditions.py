"""Conditions that a term of the mount may follow: recorded, or computed from time and place."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.columns import COLUMNS
from pyport.effects.base import Circumstances, MissingColumn
from pyport.effects.circumstances import mostly_known
from pyport.effects.empirical.drivers import (
    BEYOND_TEMPERATURE,
    OF_MOUNT,
    TIME_OF_DAY,
    Driver,
    about,
    above_sun,
    late,
    settling,
    sun_height,
)
from pyport.effects.sessions import spans_of
from pyport.effects.telescope.rotation import (
    LEAST_ARC,
    OFFSETS_AND_SIZES,
    PLACES,
    angle_columns,
    arc,
)
from pyport.effects.telescope.thermal import AIR, ways

#: So many conditions are tried: those of the contract, the hour, the Sun, and four columns of any
#: name. With each the price of a choice and the time of a search grow.
MOST_DRIVERS = 10
#: A condition must have taken more values than this: a cubic, or a step, passes through fewer.
FEW_VALUES = 4
#: A column of which so much of the variance is drawn by the direction is a name for it.
BY_DIRECTION = 0.9
#: In what time what changes when a session begins, as the dome opens or drives warm up, dies away
#: [h]. In a night, what any time between twenty minutes and four hours draws, one of these draws to
#: a cosine of 0.97.
SETTLES_H = (0.5, 1.0, 2.0)
#: Of refraction alone it is known what changes it: the density of the air.
OF_AIR = "refraction"
#: The term that a condition may drive of which nothing is known but the name. An offset that is
#: the same all over the sky, or nearly so as a sag is, and follows such a column names no part
#: of the telescope: it stays a curve in that column, without a name.
_BY_ANYTHING = ("tilt",)
_BY_AIR = {
    "temperature_c": (*BEYOND_TEMPERATURE, OF_AIR),
    "pressure_hpa": (*OF_MOUNT, OF_AIR),
}

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


def tried(at: Circumstances) -> list[Driver]:
    """Return the conditions worth trying, how the air acts late, and what settles in a session."""
    found = drivers(at)
    spans = spans_of(at) if _varies(at, "time") else {}
    begun = [settling(hours, spans) for hours in SETTLES_H if len(spans) > 1]
    air = [one.stated["centre"] for one in found if one.follows == "temperature_c"]
    return found + [late(*way, air[0]) for way in ways(at) if air and way[0] != AIR] + begun


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
        TIME_OF_DAY if _varies(at, "time") else None,
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
    terms = _BY_AIR.get(name, OF_MOUNT if moves else _BY_ANYTHING)
    return about(name, float(np.nanmedian(at.numbers(name))), terms)


#: The contract's conditions of the weather.
OF_WEATHER = frozenset(one.name for one in COLUMNS if one.weather)


def _sun(at: Circumstances) -> Driver | None:
    """Return the elevation of the Sun, as recorded or computed [deg], less its median here."""
    try:
        return above_sun(float(np.nanmedian(sun_height(at))))
    except MissingColumn:
        return None


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
