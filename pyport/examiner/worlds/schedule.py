"""A night at the telescope: sessions, sources that are up, scans forward and back, labels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import erfa
import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCMIN, DEG, Array
from pyport.errors import BadInput
from pyport.examiner.worlds import sky
from pyport.examiner.worlds.earth import Site, julian_date, weather
from pyport.examiner.worlds.mount import direction
from pyport.examiner.worlds.sky import Sources, sources

#: Planets that campaigns visit, with ERFA's numbers for them.
_PLANETS = {"Venus": 2, "Mars": 4, "Jupiter": 5}
_RATES_ARCMIN_PER_MIN = (10.0, 20.0, 30.0)
_FREQUENCY_MHZ = {"L": 1420.0, "C": 4990.0, "X": 8400.0}


@dataclass(frozen=True)
class Plan:
    """n measurements as they were scheduled; shape (n,) each.

    `site`, `site_name`: where each antenna really stands.
    `reference`: the one place that the steering program computes for.
    `time_s`: UTC, seconds since 1970, ascending.
    `ra`, `dec`: where the sources are, ICRS [rad].
    `labels`: `source`, `antenna`, `session`, `receiver`, `channel`, `polarisation`, and `scan_axis`
      ("az", "el") where a row measures one axis.
    `scan_direction`, `scan_rate`: +1 or -1, and the speed of the scanned axis [rad/s].
    `weather`: the weather columns, the sun's position and `frequency_mhz`, as the contract names
      them.
    `cable_middle`: azimuth [rad] in which the cable hangs free.
    """

    site: Site
    reference: Site
    site_name: str
    time_s: Array
    ra: Array
    dec: Array
    labels: dict[str, NDArray[Any]]
    scan_direction: Array
    scan_rate: Array
    weather: dict[str, Array]
    cable_middle: float = 0.0

    def __len__(self) -> int:
        """Return n."""
        return len(self.time_s)

    def measures(self, axis: str) -> NDArray[np.bool_]:
        """Return which rows measure "az" (or "el")."""
        scanned = self.labels.get("scan_axis")
        return np.ones(len(self), bool) if scanned is None else scanned == axis

    def on_planet(self) -> NDArray[np.bool_]:
        """Return which rows look at a planet."""
        return np.isin(self.labels["source"], list(_PLANETS))

    def air(self) -> sky.Air:
        """Return the air that the weather makes."""
        return sky.Air(
            self.weather["pressure_hpa"],
            self.weather["temperature_c"],
            self.weather["humidity_pct"] / 100,
        )


@dataclass(frozen=True)
class Session:
    """A stretch of observing: its name, start [s since 1970] and length [s]."""

    name: str
    start_s: float
    length_s: float


def rough_place(ra: Array, dec: Array, time_s: Array, site: Site) -> tuple[Array, Array]:
    """Return azimuth and elevation [rad] to a degree, good enough to plan with."""
    date = julian_date(time_s)
    return erfa.hd2ae(erfa.gmst00(*date, *date) + site.longitude - ra, dec, site.latitude)[:2]


def sessions(
    rng: np.random.Generator, count: int, first_s: float, span_s: float, hours: tuple[float, float]
) -> tuple[Session, ...]:
    """Return `count` sessions of `hours` (least, most) over `span_s` that do not overlap."""
    slot = span_s / count
    drawn = []
    for i in range(count):
        length = min(rng.uniform(*hours) * 3600, 0.9 * slot)
        start = first_s + i * slot + rng.uniform(0, slot - length)
        drawn.append(Session(f"S{i + 1:02d}", start, length))
    return tuple(drawn)


def follow(
    rng: np.random.Generator,
    rows: int,
    session: Session,
    site: Site,
    elevations: tuple[float, float],
    dwell: tuple[int, int],
    catalogue: Sources,
) -> tuple[Array, NDArray[np.intp]]:
    """Return times [s] and source numbers of one session, shape (rows,) each.

    The telescope goes to the source that is nearest to a random place in the
    sky, so that the sky is covered evenly, and stays for `dwell` rows.
    """
    cadence = session.length_s / rows
    times = session.start_s + cadence * (np.arange(rows) + rng.uniform(0, 0.6, rows))
    chosen = np.empty(rows, np.intp)
    low, high = elevations
    row = 0
    while row < rows:
        now = np.full(len(catalogue.ra), times[row])
        az, el = rough_place(catalogue.ra, catalogue.dec, now, site)
        wish_az = rng.uniform(-np.pi, np.pi)
        wish_el = np.arcsin(rng.uniform(np.sin(low), np.sin(high)))
        cosine = np.sum(direction(az, el) * direction(wish_az, wish_el), axis=-1)
        up = (el > low) & (el < high)
        if not up.any():
            raise BadInput(f"no source is up in session {session.name}: expected wider elevations")
        source = int(np.argmax(np.where(up, cosine, -2)))
        stay = times[row : row + int(rng.integers(dwell[0], dwell[1] + 1))]
        ra, dec = (np.full(len(stay), v[source]) for v in (catalogue.ra, catalogue.dec))
        _, path = rough_place(ra, dec, stay, site)
        gone = np.flatnonzero((path < low) | (path > high))
        count = int(gone[0]) if len(gone) else len(stay)
        chosen[row : row + count] = source
        row += count
    return times, chosen


def about_transit(session: Session, seen: Sources, site: Site) -> Session:
    """Return the stretch of a session's day in which the first of some sources is well up."""
    minutes = session.start_s + np.arange(0, 86400, 60.0)
    ra, dec = (np.full(len(minutes), v[0]) for v in (seen.ra, seen.dec))
    _, el = rough_place(ra, dec, minutes, site)
    middle = minutes[np.argmax(el)]
    up = np.abs(minutes - middle)[el < 12 * DEG]
    half = min(4.5 * 3600, float(up.min(initial=86400.0)) - 600)
    return replace(session, start_s=middle - half, length_s=2 * half)


def draw_plan(
    rng: np.random.Generator,
    site_name: str,
    site: Site,
    rows: int,
    observing: tuple[Session, ...],
    *,
    one_axis: bool,
    elevations_deg: tuple[float, float] = (8.0, 84.0),
    dwell: tuple[int, int] = (2, 8),
    catalogue: Sources | None = None,
) -> Plan:
    """Return a plan for one antenna, all covariates of the contract drawn.

    `rng`: where the randomness comes from.
    `site_name`, `site`: the telescope's.
    `rows`: how many measurements in all.
    `observing`: the sessions, which share the rows evenly.
    `one_axis`: whether a row measures one axis, in turn, rather than both.
    `elevations_deg`: least and greatest elevation.
    `dwell`: fewest and most rows in a row on one source.
    `catalogue`: what is observed, the radio sources when not given.
    """
    catalogue = catalogue or sources()
    share = np.diff(np.linspace(0, rows, len(observing) + 1).astype(int))
    limits = (elevations_deg[0] * DEG, elevations_deg[1] * DEG)
    parts = [
        follow(rng, int(n), one, site, limits, dwell, catalogue)
        for n, one in zip(share, observing, strict=True)
    ]
    time_s = np.concatenate([part[0] for part in parts])
    number = np.concatenate([part[1] for part in parts])
    session = np.repeat([one.name for one in observing], share)
    plan = dressed(rng, site_name, site, time_s, number, session, catalogue)
    if not one_axis:
        return plan
    scan_axis = np.where(np.arange(rows) % 2 == 0, "az", "el")
    return replace(plan, labels={**plan.labels, "scan_axis": scan_axis})


def dressed(
    rng: np.random.Generator,
    site_name: str,
    site: Site,
    time_s: Array,
    number: NDArray[np.intp],
    session: NDArray[np.str_],
    catalogue: Sources,
) -> Plan:
    """Return a plan for given times, source numbers and session names, everything else drawn."""
    rows = len(time_s)
    receiver = _runs(rng, rows, tuple(_FREQUENCY_MHZ), (rows // 30 + 1, rows // 8 + 2))
    frequency = np.vectorize(_FREQUENCY_MHZ.get)(receiver)
    channel = rng.choice(["1", "2"], rows)
    labels: dict[str, NDArray[Any]] = {
        "source": catalogue.name[number],
        "antenna": np.full(rows, site_name.upper()),
        "session": session,
        "receiver": receiver,
        "channel": channel,
        "polarisation": rng.choice(["LCP", "RCP"], rows),
    }
    names, which = np.unique(session, return_inverse=True)
    rate = rng.choice(_RATES_ARCMIN_PER_MIN, len(names))[which] * ARCMIN / 60
    air = weather(
        rng, time_s, float(site.longitude), float(site.height_m), north=bool(site.latitude > 0)
    )
    plan = Plan(
        site=site,
        reference=site,
        site_name=site_name,
        time_s=time_s,
        ra=catalogue.ra[number],
        dec=catalogue.dec[number],
        labels=labels,
        scan_direction=rng.choice([-1.0, 1.0], rows),
        scan_rate=rate,
        weather=air,
    )
    sun = sky.observed(*sky.sun(time_s), time_s, site, plan.air(), sky.STEPS - {"refraction"})
    around = {
        "sun_az_deg": np.degrees(sun.az),
        "sun_el_deg": np.degrees(sun.el),
        "frequency_mhz": frequency + np.where(channel == "1", -40.0, 40.0),
    }
    return replace(plan, weather={**air, **around})


def with_planet(rng: np.random.Generator, plan: Plan) -> Plan:
    """Return a plan in which a planet takes the place of some targets while it is up."""
    name = str(rng.choice(list(_PLANETS)))
    ra, dec = sky.planet(_PLANETS[name], plan.time_s)
    place = sky.observed(ra, dec, plan.time_s, plan.site, plan.air())
    up = (place.el > 8 * DEG) & (place.el < 84 * DEG) & (rng.random(len(plan)) < 0.5)
    labels = {**plan.labels, "source": np.where(up, name, plan.labels["source"])}
    return replace(
        plan, ra=np.where(up, ra, plan.ra), dec=np.where(up, dec, plan.dec), labels=labels
    )


def for_antennas(plan: Plan, names: list[str], site: Site) -> Plan:
    """Return a plan in which several antennas do everything that one did, at the same time.

    `site` holds one place for each name; the steering computes for the old one.
    """
    count = len(names)
    rows = take(plan, np.repeat(np.arange(len(plan)), count))
    one_by_one = np.tile(np.arange(count), len(plan))
    there = (
        np.asarray(part)[one_by_one] for part in (site.latitude, site.longitude, site.height_m)
    )
    labels = {**rows.labels, "antenna": np.array(names)[one_by_one]}
    return replace(rows, site=Site(*there), labels=labels)


def _runs(
    rng: np.random.Generator, rows: int, names: tuple[str, ...], length: tuple[int, int]
) -> NDArray[Any]:
    """Return labels that stay the same for a while."""
    drawn: list[str] = []
    while len(drawn) < rows:
        drawn += [str(rng.choice(names))] * int(rng.integers(*length))
    return np.array(drawn[:rows])


def take(plan: Plan, index: NDArray[Any]) -> Plan:
    """Return the rows of a plan that a mask or list selects."""

    def chosen(values: Any) -> Any:  # noqa: ANN401 - a scalar stays one for all rows
        return values[index] if np.ndim(values) else values

    return replace(
        plan,
        site=Site(
            *(chosen(v) for v in (plan.site.latitude, plan.site.longitude, plan.site.height_m))
        ),
        time_s=plan.time_s[index],
        ra=plan.ra[index],
        dec=plan.dec[index],
        labels={name: values[index] for name, values in plan.labels.items()},
        scan_direction=plan.scan_direction[index],
        scan_rate=plan.scan_rate[index],
        weather={name: values[index] for name, values in plan.weather.items()},
    )
