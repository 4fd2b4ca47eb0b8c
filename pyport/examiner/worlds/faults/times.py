"""Time: what was moved one day, what differs between campaigns, what creeps."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np

from pyport.angles import Array
from pyport.examiner.worlds.faults.base import Draw, Fault, on_mount, phase
from pyport.examiner.worlds.world import World

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


def epoch_offset(world: World, rng: np.random.Generator) -> Fault:
    """Draw a day on which the zeros moved."""
    after, text = _since(world, rng)
    _, sin, cos = phase(rng)
    return on_mount(
        "epoch_offset",
        ("xel", "el"),
        {"beam_left": sin * after, "elevation_zero": cos * after},
        where={"since": text},
    )


def epoch_tilt(world: World, rng: np.random.Generator) -> Fault:
    """Draw a day on which the lean of the azimuth axis changed."""
    after, text = _since(world, rng)
    _, sin, cos = phase(rng)
    parts = {"tilt_east": sin * after, "tilt_north": cos * after}
    return on_mount("epoch_tilt", ("xel", "el"), parts, where={"since": text})


def epoch_sag(world: World, rng: np.random.Generator) -> Fault:
    """Draw a day on which a weight was added to the dish."""
    after, text = _since(world, rng)
    return on_mount("epoch_sag", ("el",), {"sag_cosine": after}, where={"since": text})


def drift(world: World, rng: np.random.Generator) -> Fault:
    """Draw a structure that creeps, ever more slowly, through the whole campaign."""
    time_s = world.plan.time_s
    run = (time_s - time_s[0]) / max(time_s[-1] - time_s[0], _DAY_S)
    crept = (1 - np.exp(-run * 1.2)) / (1 - np.exp(-1.2))
    _, sin, cos = phase(rng)
    parts = {"beam_left": sin * crept, "elevation_zero": cos * crept}
    return on_mount("drift", ("xel", "el"), parts)


FAULTS: dict[str, Draw] = {
    "epoch_offset": epoch_offset,
    "epoch_tilt": epoch_tilt,
    "epoch_sag": epoch_sag,
    "drift": drift,
}
