"""Causes that act at times, in places and on conditions: since a moment, in some antennas, ..."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np

from pyport.angles import DEG, Array
from pyport.examiner.worlds.faults import mount, surroundings
from pyport.examiner.worlds.faults.surroundings import Draw, Fault, on_mount, phase
from pyport.examiner.worlds.mount import direction
from pyport.examiner.worlds.world import World, believed, observe


def within(fault: Fault, weight: Array, **where: object) -> Fault:
    """Return a cause of which each recording has a share; `where` says which, as a report would."""

    def apply(world: World, size: float) -> World:
        quiet, loud = observe(world), observe(fault.apply(world, size))
        x, y = weight * (loud.x - quiet.x), weight * (loud.y - quiet.y)
        return replace(world, across=world.across + x, up=world.up + y)

    return replace(fault, apply=apply, where={**fault.where, **where})


def _moment(world: World, rng: np.random.Generator) -> tuple[float, str]:
    """Draw a moment between two recordings, in the midst of a session or not; and its ISO time."""
    time_s = world.plan.time_s
    row = int(rng.integers(len(time_s) // 6, 5 * len(time_s) // 6))
    moment = (time_s[row - 1] + time_s[row]) / 2
    return moment, datetime.fromtimestamp(round(moment), UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def _change(world: World, rng: np.random.Generator, *, stops: bool, grows: bool) -> Fault:
    effect = str(rng.choice(["epoch_offset"] if grows else list(surroundings.CHANGES)))
    moment, text = _moment(world, rng)
    time_s = world.plan.time_s
    after = np.where(time_s >= moment, 1.0, 0.0)
    weight = after * (time_s - moment) / (time_s[-1] - moment) if grows else after
    _, *sizes = phase(rng)
    parts = dict(zip(surroundings.CHANGES[effect], sizes, strict=False))
    return on_mount(
        "drift" if grows else effect,
        ("xel", "el"),
        {name: size * ((1 - weight) if stops else weight) for name, size in parts.items()},
        # what creeps after a moment may be called by either
        same=("epoch_offset",) if grows else (),
        or_unknown=grows,
        where={} if grows else {"since": text},
        facts={"moment": text},
    )


def starting(world: World, rng: np.random.Generator) -> Fault:
    """Draw zeros, a lean or a sag that are otherwise since a moment anywhere."""
    return _change(world, rng, stops=False, grows=False)


def stopping(world: World, rng: np.random.Generator) -> Fault:
    """Draw one of these that was there until a moment."""
    return _change(world, rng, stops=True, grows=False)


def growing(world: World, rng: np.random.Generator) -> Fault:
    """Draw zeros that creep from a moment on."""
    return _change(world, rng, stops=False, grows=True)


#: Causes that an antenna of an array may have alone.
_OF_ONE: dict[str, Draw] = {
    **{
        name: mount.FAULTS[name]
        for name in (
            *("sag_sine", "azimuth_eccentricity", "azimuth_harmonics"),
            *("elevation_harmonics", "elevation_scale"),
        )
    },
    "epoch_offset": surroundings.TIMES["epoch_offset"],
}


def some_antennas(world: World, rng: np.random.Generator) -> Fault:
    """Draw a cause that some antennas of an array have and the others do not."""
    antenna = world.plan.labels["antenna"]
    names = np.unique(antenna)
    count = int(rng.integers(1, max(len(names) // 2, 2)))
    has = sorted(rng.choice(names, count, replace=False).tolist())
    fault = _OF_ONE[str(rng.choice(list(_OF_ONE)))](world, rng)
    return within(fault, np.isin(antenna, has).astype(float), subset={"antenna": has})


def driven(world: World, rng: np.random.Generator) -> Fault:
    """Draw a lean or a sag that follows a condition which is written down."""
    condition = str(rng.choice(["humidity_pct", "pressure_hpa"]))
    value = world.plan.weather[condition]
    strength = (value - value.mean()) / max(float(value.std()), 1e-9)
    _, sin, cos = phase(rng)
    leans = bool(rng.random() < 0.5)
    parts = {"tilt_north": sin, "tilt_east": cos} if leans else {"sag_cosine": 1.0}
    return on_mount(
        "driven_term",
        ("xel", "el"),
        {name: size * strength for name, size in parts.items()},
        or_unknown=True,
        facts={"condition": condition, "part": "tilt" if leans else "sag_cosine"},
    )


def rotator_circle(world: World, rng: np.random.Generator) -> Fault:
    """Draw a feed off the axis of what turns with the field of view, one way or the other."""
    place = believed(world)
    ahead = direction(place.az, place.el)
    right = direction(place.az + np.pi / 2, np.zeros_like(place.el))
    up = np.cross(right, ahead)
    pole = direction(0.0, float(world.plan.reference.latitude))
    turned = np.arctan2(right @ pole, up @ pole) * rng.choice([-1, 1])
    start, _, _ = phase(rng)
    parts = {"beam_left": np.cos(turned + start), "beam_down": np.sin(turned + start)}
    return on_mount("rotator_circle", ("xel", "el"), parts)


def quarter_day(world: World, rng: np.random.Generator) -> Fault:
    """Draw zeros that swing four times a day, as an air conditioner's schedule may have it."""
    start, sin, cos = phase(rng)
    swing = np.sin(2 * np.pi * world.plan.time_s / 21600 + start)
    return on_mount(
        "oscillation",
        ("xel", "el"),
        {"beam_left": sin * swing, "elevation_zero": cos * swing},
        same=("driven_term",),
        or_unknown=True,
        facts={"period_s": 21600.0},
    )


def slew_hysteresis(world: World, rng: np.random.Generator) -> Fault:
    """Draw a structure that comes to rest slowly after every slew, from where it came from."""
    plan, el = world.plan, believed(world).el
    rests_s = rng.uniform(0.2, 0.6) * 3600
    strain = np.zeros(len(plan))
    for row in range(1, len(plan)):
        waited = np.exp(-(plan.time_s[row] - plan.time_s[row - 1]) / rests_s)
        moved = np.clip((el[row] - el[row - 1]) / (20 * DEG), -1, 1)
        strain[row] = np.clip(strain[row - 1] * waited + moved, -1.5, 1.5)
    return on_mount(
        "unknown", ("el",), {"elevation_zero": strain}, facts={"shape": "after slews", "s": rests_s}
    )


FAULTS: dict[str, Draw] = {
    "starting": starting,
    "stopping": stopping,
    "growing": growing,
    "some_antennas": some_antennas,
    "driven": driven,
    "rotator_circle": rotator_circle,
    "quarter_day": quarter_day,
    "slew_hysteresis": slew_hysteresis,
}
