"""Directions that contradict the hour angle, or right ascension and time, of the same rows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from pyport.angles import DEG, Array
from pyport.columns import angle_of
from pyport.effects.base import Circumstances, MissingColumn
from pyport.effects.circumstances import Site
from pyport.effects.sky.frame import from_sky
from pyport.recordings.raw import Raw
from pyport.recordings.schema import Recordings
from pyport.recordings.sky import horizon

#: Places of 1950 are a degree off today, refraction at the horizon half of one.
ELSEWHERE_DEG = 1.5
#: So few directions may well be near each other, north and low.
FEWEST_OF_RADIANS = 3
#: So many rows, evenly chosen, show where most of them point.
MOST_ROWS = 1000
#: Zones of civil time [h]: whole hours, and the half ones of India and Australia.
ZONES_H = (*range(-12, 15), 5.5, 9.5)

#: What a direction would be if something was read otherwise: words, azimuth and elevation [rad].
Otherwise: TypeAlias = tuple[str, Array, Array]


def note(recordings: Recordings, raw: Raw) -> str:
    """Return how far directions are from those of the same rows' other coordinates, if they are."""
    angles = {angle[0] for name in raw.columns if (angle := angle_of(name)) is not None}
    at, places = recordings.at, {"az", "el", "dec"}
    said = ""
    if at.site is not None and places | {"hour_angle"} <= angles:
        said = _compared(
            recordings, "hour angle, declination", ("hour_angle", "dec"), _by_hour_angle
        )
    timed = "time" in at and at.site is not None and at.site.longitude is not None
    if not said and timed and places | {"ra"} <= angles:
        what = "right ascension, declination, time"
        said = _compared(recordings, what, ("ra", "dec", "time"), _by_time, _elsewhere)
    return said


def radians(recordings: Recordings) -> str:
    """Return that directions in degrees are so small that they may be radians, if they are."""
    az, el = np.abs(recordings.at.az) / DEG, np.abs(recordings.at.el) / DEG
    if len(az) < FEWEST_OF_RADIANS or az.max() > 2 * np.pi or el.max() > np.pi / 2:
        return ""
    return (
        f"azimuths up to {az.max():.3g} deg and elevations up to {el.max():.3g} deg: if they are "
        "radians, read them as az_rad and el_rad, and look at the unit of the offsets"
    )


def below(recordings: Recordings) -> str:
    """Return how many rows point below the horizon, and which is the lowest, if any do."""
    el = recordings.at.el / DEG
    if not (rows := int(np.count_nonzero(el < 0))):
        return ""
    lowest = int(np.nanargmin(el))
    point = "row points" if rows == 1 else "rows point"
    return (
        f"{rows} {point} below the horizon, where nothing is seen, the lowest at elevation "
        f"{el[lowest]:.3g} deg (line {recordings.line[lowest]})"
    )


def _compared(
    recordings: Recordings,
    what: str,
    names: tuple[str, ...],
    readings: Callable[[Circumstances], Iterator[Otherwise]],
    at_last: Callable[[Circumstances], Iterator[Otherwise]] = lambda _: iter(()),
) -> str:
    """Return how far directions are from those that columns say, and what would explain it.

    `at_last` is asked where none of the `readings` explains it.
    """
    columns = np.array([recordings.at.az, recordings.at.el, *map(recordings.at.column, names)])
    rows = np.flatnonzero(np.isfinite(columns).all(axis=0))
    if not len(rows):
        return ""
    at = recordings.at.take(rows[:: len(rows) // MOST_ROWS + 1])
    places = readings(at)
    try:
        _, *there = next(places)
        distance = _distance_deg(at.az, at.el, *there)
        if distance < ELSEWHERE_DEG:
            return ""
        found = [(_distance_deg(at.az, at.el, *place), words) for words, *place in places]
    except MissingColumn:  # no date of these centuries
        return ""
    south = recordings.meta.get("azimuth_zero", "").lower() == "south"
    found += [(_distance_deg(*place, *there), words) for words, *place in _turned(at, south=south)]
    less = _explaining(found) or _explaining(
        [(_distance_deg(at.az, at.el, *place), words) for words, *place in at_last(at)]
    )
    return (
        f"azimuth and elevation are {distance:.3g} deg (median of {len(at)} rows) from where "
        f"{what} and site say" + f", but {', or '.join(less)}" * bool(less)
    )


def _explaining(found: list[tuple[float, str]]) -> list[str]:
    return [f"{left:.1f} deg if {words}" for left, words in sorted(found) if left < ELSEWHERE_DEG]


def _distance_deg(az: Array, el: Array, other_az: Array, other_el: Array) -> float:
    """Return the median distance of directions."""
    import erfa

    return float(np.median(erfa.seps(az, el, other_az, other_el))) / DEG


def _by_hour_angle(at: Circumstances) -> Iterator[Otherwise]:
    """Yield where hour angle and declination are, as they stand and otherwise."""
    hour_angle, dec, latitude = at.numbers("hour_angle"), at.numbers("dec"), at.latitude()
    yield "", *horizon(hour_angle, dec, latitude)
    yield "the hour angle has the opposite sign", *horizon(-hour_angle, dec, latitude)
    yield "the latitude has the opposite sign", *horizon(hour_angle, dec, -latitude)


def _by_time(at: Circumstances) -> Iterator[Otherwise]:
    """Yield where right ascension and declination are at these times, and otherwise.

    Raises `MissingColumn`: the times are of no year whose sky is known.
    """
    yield "", *_seen(at)
    for hours in filter(None, ZONES_H):
        way = "ahead of" if hours > 0 else "behind"
        yield f"the times are {abs(hours):g} h {way} UTC", *_seen(at, -3600 * hours)
    for name in ("latitude", "longitude"):
        site = replace(at.site, **{name: -getattr(at.site, name)})  # type: ignore[type-var]
        yield f"the {name} has the opposite sign", *_seen(replace(at, site=site))


def _elsewhere(at: Circumstances) -> Iterator[Otherwise]:
    """Yield where right ascension and declination are at these times from where they are so high.

    The sine of an elevation is the component of a direction, on axes of the Earth, along the
    zenith, which is that of one place.
    """
    pole = replace(at, site=Site(np.pi / 2, 0.0))
    north, east, up = from_sky(pole, _vector(at)).T
    zenith, _, rank, _ = np.linalg.lstsq(np.stack([-north, east, up], axis=1), np.sin(at.el))
    if rank < len(zenith):
        return
    latitude = float(np.arctan2(zenith[2], np.hypot(*zenith[:2])))
    longitude = float(np.arctan2(zenith[1], zenith[0]))
    given = at.site.longitude if at.site is not None and at.site.longitude is not None else 0.0
    early_min = 4 * (longitude - given) / DEG
    words = f"the site is at latitude {latitude / DEG:.1f} and longitude {longitude / DEG:.1f} deg"
    if abs(latitude - at.latitude()) < ELSEWHERE_DEG * DEG:
        way = "behind" if early_min > 0 else "ahead of"
        words += f", or the times are {abs(early_min):.0f} min {way} UTC"
    yield words, *_seen(replace(at, site=Site(latitude, longitude)))


def _vector(at: Circumstances) -> Array:
    """Return where right ascension and declination are, shape (n, 3)."""
    import erfa

    return np.asarray(erfa.s2c(at.numbers("ra"), at.numbers("dec")))


def _seen(at: Circumstances, later_s: float = 0.0) -> tuple[Array, Array]:
    """Return where right ascension and declination are seen, some time later."""
    north, east, up = from_sky(at, _vector(at), later_s).T
    return np.arctan2(east, north), np.arctan2(up, np.hypot(north, east))


def _turned(at: Circumstances, *, south: bool) -> Iterator[Otherwise]:
    """Yield where azimuth and elevation are if azimuths count otherwise."""
    zero = "north" if south else "south"
    yield f"azimuth counts from {zero} ('# azimuth_zero: {zero}')", at.az + np.pi, at.el
    yield "azimuth counts in the opposite sense", -at.az, at.el
