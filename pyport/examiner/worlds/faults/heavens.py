"""Sky, clock, site and air: what a steering program believes that is not so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from pyport.angles import ARCSEC
from pyport.examiner.worlds.earth import orientation
from pyport.examiner.worlds.faults.surroundings import Draw, Fault
from pyport.examiner.worlds.schedule import with_planet
from pyport.examiner.worlds.world import World

_BOTH = {"axes": ["xel", "el"]}

#: Steps of the reduction whose want is an effect of the same name, of the size that nature gives.
_FORGOTTEN = ("precession", "nutation", "annual_aberration", "diurnal_aberration", "polar_motion")


def left_out(step: str, world: World) -> Fault:
    """Return the fault of a steering that leaves a step of `sky.STEPS` out, all of it."""
    ut1_s = float(np.mean(orientation(world.plan.time_s)[0]))

    def apply(world: World, size: float) -> World:
        if size == 0:
            return world
        return world.with_steering(steps=world.steering.steps - {step})

    return Fault(
        "clock" if step == "ut1" else step,
        apply,
        unit="of it",
        pilot=1.0,
        fixed=True,
        same=("site_longitude",) if step == "ut1" else (),
        beside=("refraction_curvature",) if step == "refraction" else (),
        where={"axes": ["el"] if step == "refraction" else ["xel", "el"]},
        parameters={"clock_error": ut1_s} if step == "ut1" else {},
    )


def _leaving_out(step: str) -> Draw:
    return lambda world, rng: left_out(step, world)  # noqa: ARG005 - nothing to draw


def _believing(
    effect: str,
    apply: Callable[[World, float], World],
    **more: Any,  # noqa: ANN401 - the rest of a Fault
) -> Draw:
    """Return what draws a belief that is wrong, of which nothing but the size is open."""
    return lambda world, rng: Fault(effect, apply, **more)  # noqa: ARG005 - nothing to draw


def source_position(world: World, rng: np.random.Generator) -> Fault:
    """Draw one to three sources, among those most observed, with wrong catalogue positions."""
    names, count = np.unique(world.plan.labels["source"], return_counts=True)
    often = names[np.argsort(-count)][: max(3, len(names) // 3)]
    wrong = sorted(rng.choice(often, int(rng.integers(1, 4)), replace=False).tolist())
    shift = {name: rng.standard_normal(2) for name in wrong}
    rows = {name: world.plan.labels["source"] == name for name in wrong}
    dec = np.cos(world.plan.dec)

    def apply(world: World, size: float) -> World:
        unit = size * ARCSEC
        ra_shift = sum((rows[name] * shift[name][0] for name in wrong), np.zeros(len(dec)))
        dec_shift = sum((rows[name] * shift[name][1] for name in wrong), np.zeros(len(dec)))
        return world.with_steering(ra=unit * ra_shift / dec, dec=unit * dec_shift)

    return Fault("source_position", apply, where={**_BOTH, "subset": {"source": wrong}})


def parallax(world: World, rng: np.random.Generator) -> Fault:
    """Draw a planet among the targets, computed as seen from the Earth's centre."""
    plan = world.plan
    visited = plan if plan.on_planet().any() else with_planet(rng, plan)
    near = np.where(visited.on_planet(), ARCSEC, 0.0)
    planets = np.unique(visited.labels["source"][visited.on_planet()]).tolist()

    def apply(world: World, size: float) -> World:
        return replace(world, plan=visited, near=size * near)

    where = {"axes": ["el"], "subset": {"source": planets}}
    return Fault("parallax", apply, where=where, parameters={"parallax": 1.0})


_OF_AIR: dict[str, Any] = {"unit": "of it", "where": {"axes": ["el"]}}

FAULTS: dict[str, Draw] = {
    **{step: _leaving_out(step) for step in (*_FORGOTTEN, "ut1")},
    # slow, so that the real hour angles are greater than assumed
    "clock": _believing(
        "clock",
        lambda world, size: world.with_steering(clock_s=-size),
        unit="s",
        pilot=2.0,
        same=("site_longitude",),
        where=_BOTH,
        parameters={"clock_error": 1.0},
    ),
    # too small, and too far west
    "site_latitude": _believing(
        "site_latitude",
        lambda world, size: world.with_steering(north=-size * ARCSEC),
        same=("tilt",),
        where=_BOTH,
        parameters={"latitude_error": 1.0},
    ),
    "site_longitude": _believing(
        "site_longitude",
        lambda world, size: world.with_steering(east=-size * ARCSEC),
        same=("clock",),
        where=_BOTH,
        parameters={"longitude_error": 1.0},
    ),
    "source_position": source_position,
    "parallax": parallax,
    # the constant is that of the air as it was, vapour and all
    "refraction": _believing(
        "refraction",
        lambda world, size: world.with_steering(bent=1 - size),
        pilot=0.1,
        beside=("refraction_curvature", "wet_refraction"),
        **_OF_AIR,
    ),
    "refraction_curvature": _believing(
        "refraction_curvature",
        lambda world, size: world.with_steering(curved=1 - size),
        pilot=1.0,
        **_OF_AIR,
    ),
    # a steering program that takes the air to be dry, to some degree
    "wet_refraction": _believing(
        "wet_refraction",
        lambda world, size: world.with_steering(wet=1 - size),
        pilot=1.0,
        beside=("refraction",),
        **_OF_AIR,
    ),
    "ionosphere": _believing(
        "ionosphere",
        lambda world, size: replace(world, electrons_m2=size * 1e16),
        unit="TECU",
        pilot=1000.0,
        where={"axes": ["el"]},
    ),
}
