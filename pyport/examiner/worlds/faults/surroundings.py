"""Sun, wind, temperature, receivers and feeds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import numpy as np

from pyport.angles import ARCSEC, DEG, Array
from pyport.examiner.worlds.world import World


@dataclass(frozen=True)
class Fault:
    """One hidden cause, its shape drawn, its size still open."""

    effect: str  #: its name in the catalogue of effects, or "unknown" where it is in none
    apply: Callable[[World, float], World]  #: (world, size) -> the world with it
    unit: str = "arcsec"  #: what a size of 1 is
    pilot: float = 30.0  #: a size at which its offsets are of the order of half a minute of arc
    #: True where nature gives the size (1), so that the noise has to be scaled instead.
    fixed: bool = False
    #: Names that no recordings of this plan can distinguish from it, besides its own.
    same: tuple[str, ...] = ()
    #: Names that may rightly be spoken as well, because they are part of it.
    beside: tuple[str, ...] = ()
    or_unknown: bool = False  #: whether it may rightly be left without a name
    #: Where it shows, as a report would say it: axes, subset, region, curve, since.
    where: dict[str, Any] = field(default_factory=dict)
    facts: dict[str, Any] = field(default_factory=dict)  #: what was drawn
    #: Coefficients as the catalogue names them, for each unit of size.
    parameters: dict[str, float] = field(default_factory=dict)


Draw = Callable[[World, np.random.Generator], Fault]


def on_mount(effect: str, axes: tuple[str, ...], parts: dict[str, Any], **more: Any) -> Fault:  # noqa: ANN401 - the rest of a Fault
    """Return a fault that adds `parts` (per arcsecond of size) to fields of the mount."""

    def apply(world: World, size: float) -> World:
        return world.with_mount(**{name: size * ARCSEC * value for name, value in parts.items()})

    where = {"axes": list(axes), **more.pop("where", {})}
    return Fault(effect, apply, where=where, **more)


def phase(rng: np.random.Generator) -> tuple[float, float, float]:
    """Return a random angle [rad], its sine and its cosine."""
    angle = rng.uniform(0, 2 * np.pi)
    return angle, float(np.sin(angle)), float(np.cos(angle))


def scan_direction(world: World, rng: np.random.Generator) -> Fault:  # noqa: ARG001 - world unused
    """Draw play that makes forward and reverse scans differ, in both axes."""
    az, el = rng.uniform(0.4, 1.0, 2) * rng.choice([-1, 1], 2)

    def apply(world: World, size: float) -> World:
        return world.with_drive(hysteresis_az=size * ARCSEC * az, hysteresis_el=size * ARCSEC * el)

    return Fault("scan_direction", apply, where={"axes": ["xel", "el"]})


def scan_timing(world: World, rng: np.random.Generator) -> Fault:  # noqa: ARG001
    """Draw time tags that are late, in every scan alike."""
    return Fault(
        "scan_timing",
        lambda world, size: world.with_drive(tag_s=size),
        unit="s",
        pilot=1.0,
        where={"axes": ["xel", "el"]},
        parameters={"time_tag": 1.0},
    )


def _drive(effect: str, part: str, axis: str, unit: str, pilot: float) -> Draw:
    scale = ARCSEC if unit == "arcsec" else 1.0

    def draw(world: World, rng: np.random.Generator) -> Fault:  # noqa: ARG001
        return Fault(
            effect,
            lambda world, size: world.with_drive(**{part: size * scale}),
            unit=unit,
            pilot=pilot,
            where={"axes": [axis]},
        )

    return draw


MOVING: dict[str, Draw] = {
    "scan_direction": scan_direction,
    "scan_timing": scan_timing,
    "backlash_azimuth": _drive("backlash_azimuth", "slack_az", "xel", "arcsec", 30.0),
    "backlash_elevation": _drive("backlash_elevation", "slack_el", "el", "arcsec", 30.0),
    "servo_lag_azimuth": _drive("servo_lag_azimuth", "lag_az_s", "xel", "s", 2.0),
    "servo_lag_elevation": _drive("servo_lag_elevation", "lag_el_s", "el", "s", 2.0),
}


def thermal_tilt(world: World, rng: np.random.Generator) -> Fault:
    """Draw a tower that leans away from the Sun by day: always as much, or as the Sun is high."""
    sun_az = world.plan.weather["sun_az_deg"] * DEG
    height = np.sin(world.plan.weather["sun_el_deg"] * DEG)
    weight = str(rng.choice(["by day", "as the Sun is high"]))
    warm = np.where(height > 0, 1.0 if weight == "by day" else height, 0.0)
    parts = {"tilt_north": -warm * np.cos(sun_az), "tilt_east": -warm * np.sin(sun_az)}
    return on_mount("thermal_tilt", ("xel", "el"), parts, facts={"weight": weight})


def wind_tilt(world: World, rng: np.random.Generator) -> Fault:  # noqa: ARG001
    """Draw a tower that leans downwind with the square of the wind's speed."""
    to_az = world.plan.weather["wind_az_deg"] * DEG + np.pi
    pressure = (world.plan.weather["wind_speed_m_s"] / 10) ** 2
    parts = {"tilt_north": pressure * np.cos(to_az), "tilt_east": pressure * np.sin(to_az)}
    return on_mount("wind_tilt", ("xel", "el"), parts)


def temperature(world: World, rng: np.random.Generator) -> Fault:
    """Draw a structure that bends as it warms: across, along, or by the droop of the dish."""
    warm = (world.plan.weather["temperature_c"] - 10.0) / 10
    part, axis = [("beam_left", "xel"), ("elevation_zero", "el"), ("sag_cosine", "el")][
        int(rng.integers(3))
    ]
    return on_mount("temperature", (axis,), {part: warm}, facts={"part": part})


def receiver_offset(world: World, rng: np.random.Generator) -> Fault:
    """Draw one receiver that is bolted in askew."""
    receiver = world.plan.labels["receiver"]
    moved = str(rng.choice(np.unique(receiver)))
    _, sin, cos = phase(rng)
    there = np.where(receiver == moved, 1.0, 0.0)
    return on_mount(
        "receiver_offset",
        ("xel", "el"),
        {"beam_left": sin * there, "beam_down": cos * there},
        where={"subset": {"receiver": [moved]}},
    )


def beam_squint(world: World, rng: np.random.Generator) -> Fault:
    """Draw two polarisations that look past each other."""
    hand = np.where(world.plan.labels["polarisation"] == "RCP", 1.0, -1.0)
    _, sin, cos = phase(rng)
    return on_mount(
        "beam_squint", ("xel", "el"), {"beam_left": sin * hand, "beam_down": cos * hand}
    )


FAULTS: dict[str, Draw] = {
    "thermal_tilt": thermal_tilt,
    "wind_tilt": wind_tilt,
    "temperature": temperature,
    "receiver_offset": receiver_offset,
    "beam_squint": beam_squint,
}


_DAY_S = 86400.0


def _since(world: World, rng: np.random.Generator) -> tuple[Array, str]:
    """Draw a moment between two sessions; return after (1) or before (0), and its ISO time."""
    plan = world.plan
    first = np.unique(plan.labels["session"], return_index=True)[1]
    middle = np.sort(first[1:])
    row = int(rng.choice(middle[(middle > len(plan) / 6) & (middle < 5 * len(plan) / 6)]))
    moment = (plan.time_s[row - 1] + plan.time_s[row]) / 2
    text = datetime.fromtimestamp(round(moment), UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return np.where(plan.time_s >= moment, 1.0, 0.0), text


#: What may change on a day, or come and go at a moment, by the effect that it is then.
CHANGES = {
    "epoch_offset": ("beam_left", "elevation_zero"),
    "epoch_tilt": ("tilt_east", "tilt_north"),
    "epoch_sag": ("sag_cosine",),
}


def _epoch(effect: str) -> Draw:
    """Return what draws a day on which zeros moved, the azimuth axis leaned, a weight was added."""

    def draw(world: World, rng: np.random.Generator) -> Fault:
        after, text = _since(world, rng)
        names = CHANGES[effect]
        sizes = phase(rng)[1:] if len(names) > 1 else (1.0,)
        parts = {name: size * after for name, size in zip(names, sizes, strict=True)}
        axes = ("xel", "el")[-len(names) :]
        return on_mount(effect, axes, parts, where={"since": text})

    return draw


def drift(world: World, rng: np.random.Generator) -> Fault:
    """Draw a structure that creeps, ever more slowly, through the whole campaign."""
    time_s = world.plan.time_s
    run = (time_s - time_s[0]) / max(time_s[-1] - time_s[0], _DAY_S)
    crept = (1 - np.exp(-run * 1.2)) / (1 - np.exp(-1.2))
    _, sin, cos = phase(rng)
    parts = {"beam_left": sin * crept, "elevation_zero": cos * crept}
    return on_mount("drift", ("xel", "el"), parts)


#: Shortest period of an oscillation [s], and in median steps from reading to reading.
_SHORTEST_S, _STEPS = 1800.0, 3.0
#: Quality factor of an oscillation whose phase wanders.
_QUALITY = 10.0


def _period_s(world: World, rng: np.random.Generator) -> float:
    """Draw a period from half an hour to a session, evenly in its logarithm."""
    time_s, session = world.plan.time_s, world.plan.labels["session"]
    longest = float(np.median([np.ptp(time_s[session == one]) for one in np.unique(session)]))
    shortest = max(_SHORTEST_S, _STEPS * float(np.median(np.diff(time_s))))
    return float(np.exp(rng.uniform(np.log(shortest), np.log(max(longest, 2 * shortest)))))


def _swinging(period_s: float, rng: np.random.Generator, swing: Array) -> Fault:
    _, sin, cos = phase(rng)
    parts = {"beam_left": sin * swing, "elevation_zero": cos * swing}
    return on_mount("oscillation", ("xel", "el"), parts, facts={"period_s": period_s})


def oscillation(world: World, rng: np.random.Generator) -> Fault:
    """Draw zeros that swing with one period from the first session to the last."""
    period_s = _period_s(world, rng)
    start, _, _ = phase(rng)
    return _swinging(
        period_s, rng, np.sin(2 * np.pi * (world.plan.time_s % period_s) / period_s + start)
    )


def wandering_oscillation(world: World, rng: np.random.Generator) -> Fault:
    """Draw zeros that swing as a damped pendulum that is kicked: its phase is soon another.

    From one reading to the next the hand of a clock turns and shrinks, and every kick moves its
    end; the shadow of the hand is the swing.
    """
    period_s = _period_s(world, rng)
    step_s = np.diff(world.plan.time_s, prepend=world.plan.time_s[0])
    left = np.exp(-np.pi * step_s / (_QUALITY * period_s))
    left[0] = 0.0
    turn = 2 * np.pi * step_s / period_s
    along = across = 0.0
    swing = np.empty(len(step_s))
    for n, kick in enumerate(rng.standard_normal((len(step_s), 2))):
        sin, cos = np.sin(turn[n]), np.cos(turn[n])
        fresh = np.sqrt(1 - left[n] ** 2) * kick
        along, across = (
            left[n] * (cos * along - sin * across) + fresh[0],
            left[n] * (sin * along + cos * across) + fresh[1],
        )
        swing[n] = along
    return _swinging(period_s, rng, swing)


TIMES: dict[str, Draw] = {
    **{effect: _epoch(effect) for effect in CHANGES},
    "drift": drift,
    "oscillation": oscillation,
    "wandering_oscillation": wandering_oscillation,
}
