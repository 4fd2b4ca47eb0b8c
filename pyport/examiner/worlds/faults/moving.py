"""Drives and scans: lag, play, time tags."""

from __future__ import annotations

import numpy as np

from pyport.angles import ARCSEC
from pyport.examiner.worlds.faults.base import Draw, Fault
from pyport.examiner.worlds.world import World


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


FAULTS: dict[str, Draw] = {
    "scan_direction": scan_direction,
    "scan_timing": scan_timing,
    "backlash_azimuth": _drive("backlash_azimuth", "slack_az", "xel", "arcsec", 30.0),
    "backlash_elevation": _drive("backlash_elevation", "slack_el", "el", "arcsec", 30.0),
    "servo_lag_azimuth": _drive("servo_lag_azimuth", "lag_az_s", "xel", "s", 2.0),
    "servo_lag_elevation": _drive("servo_lag_elevation", "lag_el_s", "el", "s", 2.0),
}
