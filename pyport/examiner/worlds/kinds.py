"""Every kind of case by its name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pyport.errors import BadInput
from pyport.examiner.worlds import observatories
from pyport.examiner.worlds.campaign import (
    NOISES,
    campaign,
    gappy_campaign,
    unix,
    usual_mount,
    usual_noise,
)
from pyport.examiner.worlds.case import Case, Streams, finish, hide
from pyport.examiner.worlds.earth import SITES
from pyport.examiner.worlds.faults import CATALOGUED, SWALLOWED, TOO_SMALL, UNCATALOGUED, Draw
from pyport.examiner.worlds.mount import Mount
from pyport.examiner.worlds.rt32_campaign import rt32_campaign
from pyport.examiner.worlds.schedule import Plan, draw_plan, sessions
from pyport.examiner.worlds.sky import STEPS
from pyport.examiner.worlds.world import World

#: Causes that can be hidden behind the altaz base, each by its own name.
HIDEABLE = tuple(name for name in CATALOGUED if name not in SWALLOWED + TOO_SMALL)

#: Kinds of cases and what each hides.
KINDS = {
    "null": "nothing",
    "one": "one catalogued cause behind the altaz base",
    "two": "two catalogued causes at once",
    "held": "one catalogued cause, the model held rather than refitted",
    "unknown": "a cause that no catalogue names",
    "degenerate": "a cause that the plan makes the twin of another",
    "ablation": "steps of the reduction that the RT32's steering left out",
    "rt32": "p8 to p12 of the RT32's published model, the jump among them",
    "rt32-campaign": "nothing: all of the RT32's published model, its bad rows, its moved beam",
    "gmrt": "site, scan timing and play of an array whose steering knows one place",
}


def make_case(
    kind: str,
    seed: int,
    *,
    effect: str | None = None,
    rho: float = 0.5,
    rows: int | None = None,
    noise: str | None = None,
    site: str | None = None,
    weeks: float | None = None,
) -> Case:
    """Make a case; the same arguments give the same case.

    `kind`: one of `KINDS`.
    `seed`: what everything is drawn from; plan, mount, cause and noise each from a stream of its
      own, so that cases of one seed differ in what they hide alone.
    `effect`: what is hidden, drawn when not given: a cause by its name, two of them or the steps
      left out of an ablation with plus signs between, a twin for "degenerate".
    `rho`: rms of what the altaz base leaves of the cause over the noise, on the axis where it is
      greater. Where nature gives the size of the cause the noise is scaled to it.
    `rows`: number of recordings, 1200 (the RT32's: 5615) when not given.
    `noise`: one of `NOISES`; drawn for "null", "white" or "drift" for others when not given.
    `site`: one of `earth.SITES`; drawn when not given.
    `weeks`: length of an ablation's campaign; the RT32's own two when not given.
    """
    _check(kind, effect, noise, site)
    some = {} if rows is None else {"rows": rows}
    if kind == "rt32":
        return observatories.rt32(seed, **some)
    if kind == "rt32-campaign":
        return rt32_campaign(seed, **some)
    if kind == "gmrt":
        return observatories.gmrt(seed)
    if kind == "ablation":
        omitted = tuple(effect.split("+")) if effect else observatories.RT32_LEFT_OUT
        return observatories.ablation(seed, omitted, span_weeks=weeks, **some)
    if kind == "degenerate":
        return twins(seed, effect, rho, **some)
    return _hidden(kind, seed, effect, rho, rows or 1200, noise, site)


def _check(kind: str, effect: str | None, noise: str | None, site: str | None) -> None:
    """Raise `BadInput` for a name that is not known."""
    effects = {
        "degenerate": tuple(TWINS),
        "ablation": tuple(sorted(STEPS)),
    }.get(kind, (*CATALOGUED, *UNCATALOGUED))
    asked = [
        ("kind", kind, tuple(KINDS)),
        *(("effect", one, effects) for one in (effect.split("+") if effect else ())),
        ("noise", noise, NOISES),
        ("site", site, tuple(SITES)),
    ]
    for what, name, known in asked:
        if name is not None and name not in known:
            raise BadInput(f"no {what} is called {name!r}: expected one of {', '.join(known)}")


def _hidden(
    kind: str,
    seed: int,
    effect: str | None,
    rho: float,
    rows: int,
    noise: str | None,
    site: str | None,
) -> Case:
    streams = Streams.of(seed)
    noise_kind = noise or str(streams.noise.choice(NOISES if kind == "null" else NOISES[:2]))
    lay = gappy_campaign if noise_kind == "gappy" else campaign
    held = kind == "held"
    mount = Mount() if held else usual_mount(streams.mount)
    world = World(lay(streams.plan, rows, site), mount=mount)
    names = _names(kind, effect, streams.fault)
    faults = [named(name)(world, streams.fault) for name in names]
    hidden = hide(world, faults, rho, usual_noise(streams.noise, noise_kind), projected=not held)
    about = {
        "kind": kind,
        "seed": seed,
        "asked": "+".join(names),
        "rho": rho,
        "noise_kind": noise_kind,
    }
    arguments = ("--model", "none", "--refit", "none") if held else ()
    return finish(hidden, streams, about, arguments=arguments)


def _names(kind: str, effect: str | None, rng: np.random.Generator) -> list[str]:
    if kind == "null":
        return []
    if effect is not None:
        return effect.split("+")
    if kind == "two":
        return [str(name) for name in rng.choice(HIDEABLE, 2, replace=False)]
    choices = {"one": HIDEABLE, "held": SWALLOWED, "unknown": tuple(UNCATALOGUED)}[kind]
    return [str(rng.choice(choices))]


def named(name: str) -> Draw:
    """Return what draws a cause of this name."""
    return CATALOGUED[name] if name in CATALOGUED else UNCATALOGUED[name]


_DAY_S = 86400.0

Lay = Callable[[np.random.Generator, int], Plan]


@dataclass(frozen=True)
class Twin:
    """What is hidden, what it cannot be told from, the plan that makes it so."""

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
    fault = replace(fault, same=tuple({*fault.same, *twin.same}))
    hidden = hide(world, [fault], rho, usual_noise(streams.noise), projected=not twin.held)
    about = {"kind": "degenerate", "seed": seed, "asked": chosen, "rho": rho, "noise_kind": "white"}
    arguments = ("--model", "none", "--refit", "none") if twin.held else ()
    return finish(hidden, streams, about, arguments=arguments)
