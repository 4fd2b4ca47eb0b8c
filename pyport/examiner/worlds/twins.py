"""Twins: causes that a plan of observations makes the same as others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pyport.examiner.worlds.campaign import campaign, unix, usual_mount, usual_noise
from pyport.examiner.worlds.case import Case, Streams, finish, hide
from pyport.examiner.worlds.earth import SITES
from pyport.examiner.worlds.faults import CATALOGUED
from pyport.examiner.worlds.mount import Mount
from pyport.examiner.worlds.schedule import Plan, draw_plan, sessions
from pyport.examiner.worlds.world import World

_DAY_S = 86400.0

Lay = Callable[[np.random.Generator, int], Plan]


@dataclass(frozen=True)
class Twin:
    """What is hidden, what it cannot be distinguished from, the plan that makes it so."""

    effect: str
    same: tuple[str, ...]
    lay: Lay
    held: bool = False


def _at(rng: np.random.Generator) -> str:
    return str(rng.choice(list(SITES)))


def _short(rng: np.random.Generator, rows: int) -> Plan:
    """Lay a campaign of two days in early 2011, when nutation was all in longitude."""
    name = _at(rng)
    observing = sessions(rng, 2, unix(2011, 2, 10), 2 * _DAY_S, (18.0, 22.0))
    return draw_plan(rng, name, SITES[name], rows, observing, one_axis=False)


def _two_visits(rng: np.random.Generator, rows: int) -> Plan:
    """Lay two sessions of a day with months between them."""
    name = _at(rng)
    first = unix(2005, 1, 1) + rng.uniform(0, 3000) * _DAY_S
    gap = rng.uniform(60, 200) * _DAY_S
    observing = (
        *sessions(rng, 1, first, _DAY_S, (18.0, 21.0)),
        replace(sessions(rng, 1, first + gap, _DAY_S, (18.0, 21.0))[0], name="S02"),
    )
    return draw_plan(rng, name, SITES[name], rows, observing, one_axis=False)


def _weather_once(rng: np.random.Generator, rows: int) -> Plan:
    """Lay a campaign whose weather was written down once."""
    plan = campaign(rng, rows)
    constant = {
        name: np.full(rows, np.median(plan.weather[name]))
        for name in ("temperature_c", "pressure_hpa", "humidity_pct")
    }
    return replace(plan, weather={**plan.weather, **constant})


def _temperature_by_visit(rng: np.random.Generator, rows: int) -> Plan:
    """Lay two sessions, each with one temperature."""
    plan = _two_visits(rng, rows)
    season = np.where(plan.labels["session"] == "S01", 2.0, 21.0)
    return replace(plan, weather={**plan.weather, "temperature_c": season})


TWINS: dict[str, Twin] = {
    "latitude": Twin("site_latitude", ("tilt",), campaign, held=True),
    "longitude": Twin("site_longitude", ("clock",), campaign, held=True),
    "clock": Twin("clock", ("site_longitude",), campaign, held=True),
    "precession": Twin("precession", ("nutation",), _short),
    "step": Twin("epoch_offset", ("drift",), _two_visits),
    "wet": Twin("wet_refraction", ("refraction",), _weather_once),
    "season": Twin("temperature", ("epoch_offset", "drift"), _temperature_by_visit),
}


def twins(seed: int, name: str | None = None, rho: float = 0.5, rows: int = 1200) -> Case:
    """Make a case whose cause has a twin.

    `seed`: what everything is drawn from.
    `name`: one of `TWINS`; drawn when not given.
    `rho`: as for every case.
    `rows`: number of recordings.
    """
    streams = Streams.of(seed)
    chosen = str(streams.fault.choice(list(TWINS))) if name is None else name
    twin = TWINS[chosen]
    world = World(
        twin.lay(streams.plan, rows), mount=Mount() if twin.held else usual_mount(streams.mount)
    )
    fault = CATALOGUED[twin.effect](world, streams.fault)
    droops = fault.facts.get("part") == "sag_cosine"
    same = ("epoch_sag",) if droops else twin.same
    fault = replace(fault, same=tuple({*fault.same, *same}))
    hidden = hide(world, [fault], rho, usual_noise(streams.noise), projected=not twin.held)
    about = {"kind": "degenerate", "seed": seed, "asked": chosen, "rho": rho, "noise_kind": "white"}
    arguments = ("--model", "none", "--refit", "none") if twin.held else ()
    return finish(hidden, streams, about, arguments=arguments)
