"""Misfits that stand in no catalogue: the right answer to them is that it is unknown, and where."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from pyport.angles import ARCSEC, DEG, Array, wrap
from pyport.examiner.worlds.earth import wander
from pyport.examiner.worlds.faults.surroundings import Draw, Fault, phase
from pyport.examiner.worlds.world import World, believed

_DAY_S = 86400.0

#: A column that no effect knows, on which one of them depends; every case carries it.
UNKNOWN_COLUMN = "hydraulic_bar"


def _uncatalogued(across: Array | float, up: Array | float, **more: Any) -> Fault:  # noqa: ANN401
    def apply(world: World, size: float) -> World:
        unit = size * ARCSEC
        return replace(world, across=world.across + unit * across, up=world.up + unit * up)

    axes = [name for name, part in (("xel", across), ("el", up)) if np.any(part)]
    where = {"axes": axes, **more.pop("where", {})}
    return Fault("unknown", apply, where=where, **more)


def dip(world: World, rng: np.random.Generator) -> Fault:
    """Draw a dent in the rail: a dip in elevation at one azimuth."""
    centre = rng.uniform(0, 2 * np.pi)
    width = rng.uniform(6, 14) * DEG
    depth = np.exp(-0.5 * (wrap(believed(world).az - centre) / width) ** 2)
    low, high = np.degrees(centre - 2 * width) % 360, np.degrees(centre + 2 * width) % 360
    return _uncatalogued(
        0.0,
        depth,
        where={"region": [{"column": "az_deg", "low": low, "high": high}]},
        facts={"shape": "dip", "az_deg": float(np.degrees(centre)), "width_deg": width / DEG},
    )


def mixed_wave(world: World, rng: np.random.Generator) -> Fault:
    """Draw a wave in azimuth and elevation together, sin(3A + 2E)."""
    place = believed(world)
    start, sin, cos = phase(rng)
    wave = np.sin(3 * place.az + 2 * place.el + start)
    return _uncatalogued(
        sin * wave, cos * wave, facts={"shape": "sin(3A + 2E)", "phase_rad": start}
    )


def smooth_field(world: World, rng: np.random.Generator) -> Fault:
    """Draw a smooth random field over the sky, a sum of bumps 25 deg wide."""
    place = believed(world)
    fields = []
    for _ in range(2):
        total = np.zeros(len(place.az))
        for _ in range(12):
            az, el = rng.uniform(-np.pi, np.pi), np.arcsin(rng.uniform(0.1, 1))
            cos = np.sin(place.el) * np.sin(el) + np.cos(place.el) * np.cos(el) * np.cos(
                place.az - az
            )
            total += rng.standard_normal() * np.exp((cos - 1) / (25 * DEG) ** 2)
        fields.append(total)
    return _uncatalogued(*fields, facts={"shape": "smooth field"})


def long_oscillation(world: World, rng: np.random.Generator) -> Fault:
    """Draw an oscillation of some days, whose period is nothing of nature's."""
    period_s = rng.uniform(1.7, 6.3) * _DAY_S
    start, sin, cos = phase(rng)
    swing = np.sin(2 * np.pi * world.plan.time_s / period_s + start)
    return _uncatalogued(
        sin * swing, cos * swing, facts={"shape": "oscillation", "period_s": float(period_s)}
    )


def strange_column(world: World, rng: np.random.Generator) -> Fault:
    """Draw an offset that depends on a recorded quantity that no effect knows."""
    pressure = 100 + 10 * wander(rng, world.plan.time_s, 4 * 3600.0)
    bent = np.tanh((pressure - 100) / 8)
    _, sin, cos = phase(rng)
    fault = _uncatalogued(
        sin * bent, cos * bent, facts={"shape": "depends on a column", "column": UNKNOWN_COLUMN}
    )
    spoil = fault.apply

    def apply(world: World, size: float) -> World:
        plan = world.plan
        logged = replace(plan, weather={**plan.weather, UNKNOWN_COLUMN: pressure})
        return spoil(replace(world, plan=logged), size)

    return replace(fault, apply=apply)


def region(world: World, rng: np.random.Generator) -> Fault:
    """Draw a patch of the sky, bounded in azimuth and elevation, in which elevation is off."""
    place = believed(world)
    while True:
        low = rng.uniform(10, 50)
        high = low + rng.uniform(15, 30)
        left = rng.uniform(0, 240)
        right = left + rng.uniform(60, 120)
        az, el = np.degrees(place.az), np.degrees(place.el)
        inside = (az >= left) & (az <= right) & (el >= low) & (el <= high)
        if inside.mean() > 0.05:
            break
    bounds = [
        {"column": "az_deg", "low": left, "high": right},
        {"column": "el_deg", "low": low, "high": high},
    ]
    sign = float(rng.choice([-1, 1]))
    return _uncatalogued(
        0.0, np.where(inside, sign, 0.0), where={"region": bounds}, facts={"shape": "patch"}
    )


FAULTS: dict[str, Draw] = {
    "dip": dip,
    "mixed_wave": mixed_wave,
    "smooth_field": smooth_field,
    "long_oscillation": long_oscillation,
    "strange_column": strange_column,
    "region": region,
}
