"""Misfits that stand in no catalogue: the right answer to them is that it is unknown, and where.

Twenty forms, meant to be no wave, bell, box or step as the program fits them: `pyport dev
cosines` measures how much of each its best term can take.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pyport.angles import ARCSEC, DEG, Array, wrap
from pyport.examiner.worlds.earth import wander
from pyport.examiner.worlds.faults.surroundings import Draw, Fault, phase
from pyport.examiner.worlds.mount import direction
from pyport.examiner.worlds.sky import Place
from pyport.examiner.worlds.world import World, believed

_DAY_S = 86400.0

#: A column that no effect knows, on which one of them depends; every case carries it.
UNKNOWN_COLUMN = "hydraulic_bar"


@dataclass(frozen=True)
class At:
    """Where and when: what a form is drawn over."""

    place: Place
    world: World
    rng: np.random.Generator

    @property
    def ahead(self) -> Array:
        """Return where the telescope looks, (n, 3)."""
        return direction(self.place.az, self.place.el)

    def anywhere(self) -> Array:
        """Draw a direction above 20 deg."""
        el = np.arcsin(self.rng.uniform(np.sin(20 * DEG), 1))
        return direction(self.rng.uniform(0, 2 * np.pi), el)

    def standard(self, column: str) -> Array:
        """Return a recorded quantity less its mean, over its rms."""
        value = self.world.plan.weather[column]
        return np.asarray((value - value.mean()) / max(float(value.std()), 1e-9))


#: What a form is like, shape (n,): of the order of one, its zero anywhere.
Form = Callable[[At], Array]


def _sawtooth(value: Array, at: At, least: float, most: float) -> Array:
    period = at.rng.uniform(least, most)
    return 2 * ((value / period + at.rng.random()) % 1) - 1


def _notch(distance: Array, at: At, least: float, most: float) -> Array:
    """Return a notch with straight sides."""
    return np.clip(1 - np.abs(distance) / (at.rng.uniform(least, most) * DEG), 0, None)


def _nearest(at: At) -> Array:
    """Return plates of the sky, each off by an amount of its own."""
    seeds = np.stack([at.anywhere() for _ in range(14)])
    return at.rng.standard_normal(len(seeds))[np.argmax(at.ahead @ seeds.T, axis=1)]


def _bits(at: At) -> Array:
    """Return what a disc with bad tracks reads: the parity of the bits of an azimuth."""
    number = np.floor((at.place.az / (2 * np.pi) + at.rng.random()) % 1 * 64).astype(int)
    parity = np.zeros(len(number), int)
    for bit in range(6):
        parity ^= (number >> bit) & 1
    return 2.0 * parity - 1


def _board(at: At) -> Array:
    columns = np.floor(at.place.az / (at.rng.uniform(20, 35) * DEG) + at.rng.random())
    rows = np.floor(at.place.el / (at.rng.uniform(12, 20) * DEG) + at.rng.random())
    return np.where((columns + rows) % 2 == 0, 1.0, -1.0)


def _apart(at: At) -> Array:
    """Return the distance from a place [rad]."""
    return np.arccos(np.clip(at.ahead @ at.anywhere(), -1, 1))


def _of_the_sun(at: At) -> Array:
    """Return a thin ring about the Sun, whether it is up or not."""
    weather = at.world.plan.weather
    sun = direction(weather["sun_az_deg"] * DEG, weather["sun_el_deg"] * DEG)
    apart = np.arccos(np.clip(np.sum(at.ahead * sun, axis=1), -1, 1))
    return 1 / (1 + ((apart - at.rng.uniform(60, 100) * DEG) / (6 * DEG)) ** 2)


def _ticks(at: At) -> Array:
    """Return short pulses that come again and again."""
    share = at.world.plan.time_s / (at.rng.uniform(2, 5) * 3600) + at.rng.random()
    return np.where(share % 1 < 0.12, 1.0, 0.0)


def _rose(at: At) -> Array:
    """Return petals in azimuth, seven in a turn, that point out low and in high."""
    petals = np.abs(np.cos(3.5 * at.place.az + phase(at.rng)[0])) ** 12
    return np.where(at.place.el < np.median(at.place.el), petals, -petals)


def _days(at: At) -> Array:
    """Return an oscillation of some days, whose period is nothing of nature's."""
    return np.sin(
        2 * np.pi * at.world.plan.time_s / (at.rng.uniform(1.7, 6.3) * _DAY_S) + phase(at.rng)[0]
    )


FORMS: dict[str, Form] = {
    "dip": lambda at: (1 + (wrap(at.place.az - phase(at.rng)[0]) / (14 * DEG)) ** 2) ** -2.0,
    "spiral": lambda at: np.cos(2 * at.place.az + 9 * at.place.el**2 + phase(at.rng)[0]),
    "mosaic": _nearest,
    "long_oscillation": _days,
    "sawtooth_azimuth": lambda at: _sawtooth(at.place.az, at, 25 * DEG, 50 * DEG),
    "sawtooth_elevation": lambda at: _sawtooth(at.place.el, at, 8 * DEG, 20 * DEG),
    "notch_azimuth": lambda at: _notch(wrap(at.place.az - phase(at.rng)[0]), at, 12, 25),
    "notch_elevation": lambda at: _notch(at.place.el - at.rng.uniform(25, 65) * DEG, at, 5, 10),
    "bits": _bits,
    "board": _board,
    "zones": lambda at: np.cos(at.rng.uniform(12, 20) * _apart(at) ** 2),
    "ridge": lambda at: 1 / (1 + ((at.ahead @ at.anywhere() - 0.3) / 0.07) ** 2),
    "chirp": lambda at: np.sin(at.rng.uniform(9, 14) * at.place.el**2 + phase(at.rng)[0]),
    "fold": lambda at: np.sqrt(np.abs(wrap(at.place.hour_angle - at.rng.uniform(-0.5, 0.5)))),
    "sun_ring": _of_the_sun,
    "two_conditions": lambda at: np.tanh(at.standard("humidity_pct") * at.standard("pressure_hpa")),
    "ticks": _ticks,
    "rose": _rose,
    "hinge": lambda at: np.maximum(0.0, _apart(at) - at.rng.uniform(50, 70) * DEG),
}


def _uncatalogued(across: Array | float, up: Array | float, **more: Any) -> Fault:  # noqa: ANN401
    def apply(world: World, size: float) -> World:
        unit = size * ARCSEC
        return replace(world, across=world.across + unit * across, up=world.up + unit * up)

    axes = [name for name, part in (("xel", across), ("el", up)) if np.any(part)]
    where = {"axes": axes, **more.pop("where", {})}
    return Fault("unknown", apply, where=where, **more)


def _of(name: str, form: Form) -> Draw:
    def draw(world: World, rng: np.random.Generator) -> Fault:
        value = form(At(believed(world), world, rng))
        _, sin, cos = phase(rng)
        return _uncatalogued(sin * value, cos * value, facts={"shape": name})

    return draw


def strange_column(world: World, rng: np.random.Generator) -> Fault:
    """Draw an offset that depends on a recorded quantity that no effect knows."""
    pressure = 100 + 10 * wander(rng, world.plan.time_s, 4 * 3600.0)
    beyond = (pressure - 100) / 10
    bent = np.sign(beyond) * np.maximum(np.abs(beyond) - 0.6, 0)
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


#: The twenty forms; a patch is none of them, for the program fits patches.
UNKNOWN: dict[str, Draw] = {
    **{name: _of(name, form) for name, form in FORMS.items()},
    "strange_column": strange_column,
}
FAULTS: dict[str, Draw] = {**UNKNOWN, "region": region}
