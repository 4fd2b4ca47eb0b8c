"""Sun, wind, temperature, receivers and feeds."""

from __future__ import annotations

import numpy as np

from pyport.angles import DEG
from pyport.examiner.worlds.faults.base import Draw, Fault, on_mount, phase
from pyport.examiner.worlds.world import World


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
