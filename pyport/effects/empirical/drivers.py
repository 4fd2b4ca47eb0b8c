"""Drivers: the conditions that a term of the mount may follow, and how its unit is said."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pyport.angles import DEG, Array
from pyport.effects.base import THE_HOUR, Circumstances
from pyport.effects.circumstances import DAY_S
from pyport.effects.sessions import since_begun
from pyport.effects.telescope.thermal import ACTS, AIR, BETWEEN, acting_c, sun

#: Terms of the mount that a condition may drive.
OF_MOUNT = ("tilt", "sag_cosine", "elevation_zero", "collimation")
#: What the temperature of the air does to zeros and sag, at once or late, is the effect
#: `temperature`.
BEYOND_TEMPERATURE = ("tilt",)
_BEGINNING = "the beginning of the session"

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
    terms: tuple[str, ...] = OF_MOUNT  #: which of the terms may follow it
    follows: str = THE_HOUR  #: the `driver` of the effects
    changes: str = ""  #: when it changes, where that is more than that it does
    #: What a file states of it besides its name: what is taken off the values, how late it acts.
    #: See `driver_of`.
    stated: Mapping[str, Any] = field(default_factory=dict)
    looks_back: bool = False  #: whether its values depend on the rows before


def _hours(at: Circumstances) -> tuple[Array, ...]:
    """Return once a day, as cosine and sine of UTC: what any local time is a mixture of."""
    angle = at.numbers("time") / DAY_S % 1 * 2 * np.pi
    return np.cos(angle), np.sin(angle)


TIME_OF_DAY = Driver("the time of day", "", _hours, ("_cosine_of_utc", "_sine_of_utc"))
_SUN = "sun_el_deg"


def about(name: str, centre: float, terms: tuple[str, ...] = OF_MOUNT) -> Driver:
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


def late(way: str, lag_h: float, centre: float) -> Driver:
    """Return what follows the air's temperature late, or how far that is behind."""
    offset = 0.0 if way == BETWEEN else centre
    return Driver(
        f"temperature_c{ACTS[way][0].format(lag_h)}",
        "K",
        lambda at: (acting_c(at, way, lag_h) - offset,),
        terms=BEYOND_TEMPERATURE,
        follows="temperature_c",
        stated={"follows": "temperature_c", "centre": centre, "way": way, "lag_h": lag_h},
        looks_back=True,
    )


def settling(hours: float, spans: Mapping[str, Sequence[float]]) -> Driver:
    """Return what is one when a session begins and dies away in some hours.

    `spans` are those of the sessions that were recorded: see `since_begun`.
    """
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


def sun_height(at: Circumstances) -> Array:
    """Return the elevation of the Sun, as recorded or computed [deg], shape (n,)."""
    return (at.numbers("sun_el") if "sun_el" in at else sun(at)[1]) / DEG


def above_sun(centre: float) -> Driver:
    """Return the elevation of the Sun less a number."""
    stated = {"centre": centre}
    return Driver(_SUN, "deg", lambda at: (sun_height(at) - centre,), stated=stated)


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
        return late(way, lag_h, centre or 0.0)
    if settles_h is not None:
        return settling(settles_h, dict(zip(sessions, map(list, spans_s), strict=True)))
    if follows == TIME_OF_DAY.name:
        return TIME_OF_DAY
    if follows == _SUN:
        return above_sun(centre or 0.0)
    return OF_TEMPERATURE if centre is None else about(follows, centre)


#: The temperature of the air less its median in the recordings at hand.
OF_TEMPERATURE = Driver(
    "temperature_c",
    "K",
    lambda at: (at.numbers("temperature_c") - float(np.nanmedian(at.numbers("temperature_c"))),),
    terms=BEYOND_TEMPERATURE,
    follows="temperature_c",
)
