"""Targets to observe next, in an order that saves slewing, within limits and the time left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pyport.angles import DEG, Array, separation, wrap
from pyport.effects.base import Circumstances, Site
from pyport.effects.sky.frame import sun
from pyport.errors import BadInput
from pyport.models.model import Model
from pyport.planning.look import busiest, thinned
from pyport.planning.separate import separate
from pyport.planning.suggest import (
    Direction,
    Targets,
    directions,
    on_axes,
    suggest,
    within_reach,
)
from pyport.recordings.schema import Recordings
from pyport.runs.workers import one_thread

#: Catalogued sources are offered where they stand so often within the time left [s].
STEP_S = 1800.0
#: The Sun is up from this elevation on, its refraction and half of its disc counted [rad].
SUNRISE = -0.833 * DEG
#: The longest night that is looked through for a sunrise [s].
LONGEST_S = 86400.0


@dataclass(frozen=True)
class Source:
    """A catalogued place, ICRS [rad]."""

    name: str
    ra: float
    dec: float


@dataclass(frozen=True)
class Limits:
    """What the telescope can do, and when."""

    #: `lowest_deg`, `highest_deg`: elevations.
    lowest_deg: float
    highest_deg: float
    #: `start_s`, `end_s`: the time left [s since 1970].
    start_s: float
    end_s: float
    dwell_s: float = 180.0  #: a pointing takes so long, slewing apart
    #: `az_rate`, `el_rate`: of slewing [deg/s].
    az_rate: float = 0.5
    el_rate: float = 0.5
    sun_deg: float = 0.0  #: no nearer to the Sun


@dataclass(frozen=True)
class Target:
    """A pointing: when [s since 1970], where [deg], ICRS [deg], and what it helps to decide."""

    time_s: float
    source: str
    az_deg: float
    el_deg: float
    ra_deg: float
    dec_deg: float
    decides: tuple[str, str] | None
    #: The angles of a mount's axes by their columns, {} where they are those of azimuth and
    #: elevation.
    axes: Mapping[str, float] = field(default_factory=dict)


def seen_from(site: Site, ra: Array, dec: Array, time_s: Array) -> tuple[Array, Array]:
    """Return true azimuth and elevation [rad] of ICRS places, without refraction. ERFA's `atco13`.

    Raises `BadInput`: the site's longitude is not known.
    """
    import erfa

    az, zd, *_ = erfa.atco13(ra, dec, 0, 0, 0, 0, *_place(site, time_s))
    return wrap(az), np.pi / 2 - zd


def to_icrs(site: Site, az: Array, el: Array, time_s: Array) -> tuple[Array, Array]:
    """Return the ICRS place [rad] at a true azimuth and elevation. ERFA's `atoc13`."""
    import erfa

    return erfa.atoc13("A", az, np.pi / 2 - np.asarray(el), *_place(site, time_s))[:2]


def _place(site: Site, time_s: Array) -> tuple[Array | float, ...]:
    """Return what ERFA asks of time and place, UT1 and pole as if they were UTC and zero."""
    longitude = _longitude(site)
    days = np.asarray(time_s) / 86400.0
    weather = 0.0, 0.0, 0.0, 1.0
    moment = 2440587.5, days, 0.0
    return *moment, longitude, site.latitude, site.height_m, 0.0, 0.0, *weather


def _longitude(site: Site) -> float:
    if site.longitude is None:
        raise BadInput("no longitude_deg, expected one for targets at a time: --set longitude_deg=")
    return site.longitude


def sunrise(site: Site, start_s: float) -> float:
    """Return when the Sun next rises [s since 1970], within a day; the day's end if it does not."""
    time = start_s + np.arange(0, LONGEST_S, 60.0)
    up = _sun(site, time)[1] > SUNRISE
    rises = np.flatnonzero(up[1:] & ~up[:-1])
    return float(time[rises[0] + 1]) if len(rises) else start_s + LONGEST_S


@one_thread
def targets(
    recordings: Recordings,
    model: Model,
    limits: Limits,
    count: int,
    catalogue: Sequence[Source] = (),
) -> list[Target]:
    """Return what to observe next, in its order.

    What decides most between effects that the recordings cannot distinguish, or tells most of the
    model where there are none (`suggest`); from there always the nearest by slewing time. Sources
    are observed when they stand where they were chosen for, or soon after.

    `catalogue`: sources to choose from; without, directions all over the sky.
    Raises `BadInput`: no site is known, or nothing is within the limits and the mount's reach.
    """
    site = recordings.at.site or model.site
    if site is None:
        raise BadInput("no latitude_deg, expected one: --set latitude_deg=...", recordings.file)
    own = recordings.take(recordings.label("antenna").astype(str) == busiest(recordings)[0])
    at = replace(own.at, site=site)
    made = thinned(own, model.on(at.mount), None)
    offered = within_reach(at, _offered(site, limits, catalogue))
    if not len(offered.az):
        raise BadInput(f"nothing is within the limits and the reach of {at.mount.sentence}")
    chosen, _ = suggest(made, separate(made).pairs, offered, count)
    by_name = {one.name: one for one in catalogue}
    left = list(chosen)
    now, found = limits.start_s, []
    az, el = None, None
    while left:
        due = max(now, min(_moment(limits, one) for one in left))
        nearest = min(
            (one for one in left if _moment(limits, one) <= due),
            key=lambda one: _slew_s(limits, az, el, one.az_deg, one.el_deg),
        )
        left.remove(nearest)
        slew = _slew_s(limits, az, el, nearest.az_deg, nearest.el_deg)
        arrival = max(now + slew, _moment(limits, nearest))
        if arrival + limits.dwell_s > limits.end_s:
            break
        target = _at(site, limits, arrival, nearest.source, by_name, nearest.az_deg, nearest.el_deg)
        if target is None:
            continue
        axes = on_axes(at, *target[:2])
        if axes is None:
            continue
        found.append(Target(arrival, nearest.source, *target, nearest.decides, axes))
        now, az, el = arrival + limits.dwell_s, target[0], target[1]
    return found


def _moment(limits: Limits, one: Direction) -> float:
    """Return from when on a direction is to be observed [s since 1970]."""
    return limits.start_s if one.time_s is None else one.time_s


def _offered(site: Site, limits: Limits, catalogue: Sequence[Source]) -> Targets:
    """Return directions that could be observed in the time left."""
    if not catalogue:
        sky = directions(limits.lowest_deg, limits.highest_deg)
        now = np.array([limits.start_s])
        away = _from_sun(site, now, sky.az, sky.el) >= limits.sun_deg * DEG
        some = Targets(sky.az[away], sky.el[away], tuple("" for _ in range(int(away.sum()))))
    else:
        moments = np.arange(limits.start_s, limits.end_s, STEP_S)
        which = np.repeat(np.arange(len(catalogue)), len(moments))
        time = np.tile(moments, len(catalogue))
        ra, dec = (np.array([getattr(one, name) for one in catalogue]) for name in ("ra", "dec"))
        az, el = seen_from(site, ra[which], dec[which], time)
        up = (el >= limits.lowest_deg * DEG) & (el <= limits.highest_deg * DEG)
        if limits.sun_deg:
            up &= _from_sun(site, time, az, el) >= limits.sun_deg * DEG
        some = Targets(az[up], el[up], tuple(catalogue[n].name for n in which[up]), time[up])
    if not len(some.az):
        raise BadInput("nothing is within the limits in the time left")
    return some


def _sun(site: Site, time_s: Array) -> tuple[Array, Array]:
    """Return azimuth and elevation of the Sun [rad]."""
    _longitude(site)  # refused where there is none
    none = np.zeros(len(time_s))
    return sun(Circumstances(none, none, site, {"time": time_s}))


def _from_sun(site: Site, time_s: Array, az: Array, el: Array) -> Array:
    """Return how far directions (n,) are from the Sun [rad], each at its time, or all at one."""
    return separation(*_sun(site, time_s), az, el)


def _slew_s(
    limits: Limits, az: float | None, el: float | None, to_az: float, to_el: float
) -> float:
    """Return how long a slew takes, both axes at once, the shorter way round [s]."""
    if az is None or el is None:
        return 0.0
    turn = abs((to_az - az + 180) % 360 - 180)
    return max(turn / limits.az_rate, abs(to_el - el) / limits.el_rate)


def _at(
    site: Site,
    limits: Limits,
    time_s: float,
    name: str,
    by_name: dict[str, Source],
    az_deg: float,
    el_deg: float,
) -> tuple[float, float, float, float] | None:
    """Return azimuth, elevation, RA and Dec [deg] at a time, None where it is out of bounds then.

    By then a source may have set, and the Sun may have come near.
    """
    when = np.array([time_s])
    if name:
        ra, dec = np.array([by_name[name].ra]), np.array([by_name[name].dec])
        az, el = seen_from(site, ra, dec, when)
    else:
        az, el = np.array([az_deg * DEG]), np.array([el_deg * DEG])
        ra, dec = to_icrs(site, az, el, when)
    if limits.sun_deg and _from_sun(site, when, az, el)[0] < limits.sun_deg * DEG:
        return None
    place = [float(one[0] / DEG) for one in (az, el, ra, dec)]
    if name and not limits.lowest_deg <= place[1] <= limits.highest_deg:
        return None
    return place[0] % 360, place[1], place[2], place[3]
