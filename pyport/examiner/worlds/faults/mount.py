"""Steel: zeros, axes, gravity, encoders, the rail, a loose secondary mirror."""

from __future__ import annotations

from typing import Literal

import numpy as np

from pyport.angles import ARCSEC, DEG, Array, wrap
from pyport.examiner.worlds.faults.surroundings import Draw, Fault, on_mount, phase
from pyport.examiner.worlds.mount import Wave
from pyport.examiner.worlds.world import World, believed


def _part(axis: str, part: str, name: str = "", scale: float = 1.0) -> Draw:
    """Return what draws one part of the mount askew, of which nothing but the size is open.

    `name` is what the catalogue calls it, `part` where it has no name of its own; one of its
    coefficient is `scale` of the part's.
    """
    effect = name or part
    return lambda world, rng: on_mount(  # noqa: ARG005 - nothing to draw
        effect, (axis,), {part: 1.0}, parameters={effect: scale}
    )


def tilt(world: World, rng: np.random.Generator) -> Fault:  # noqa: ARG001
    """Draw an azimuth axis that leans anywhere but north or south."""
    toward = rng.choice([-1, 1]) * rng.uniform(20, 160) * DEG
    parts = {"tilt_north": float(np.cos(toward)), "tilt_east": float(np.sin(toward))}
    return on_mount("tilt", ("xel", "el"), parts, parameters=parts, facts={"toward_rad": toward})


def azimuth_eccentricity(world: World, rng: np.random.Generator) -> Fault:  # noqa: ARG001
    """Draw an azimuth encoder that sits off centre."""
    toward, sin, cos = phase(rng)
    return on_mount(
        "azimuth_eccentricity",
        ("xel",),
        {"centre_right": sin, "centre_ahead": cos},
        facts={"toward_rad": toward},
        parameters={"azimuth_eccentricity_sine": cos, "azimuth_eccentricity_cosine": -sin},
    )


def _harmonic(effect: str, name: str, on: Literal["az", "el"], of: Literal["az", "el"]) -> Draw:
    def draw(world: World, rng: np.random.Generator) -> Fault:  # noqa: ARG001
        k = int(rng.integers(2, 7))
        _, sin, cos = phase(rng)

        def apply(world: World, size: float) -> World:
            return world.with_mount(Wave(on, of, k, size * ARCSEC * sin, size * ARCSEC * cos))

        return Fault(
            effect,
            apply,
            where={"axes": ["xel" if on == "az" else "el"]},
            facts={"k": k},
            parameters={f"{name}_sine": sin, f"{name}_cosine": cos},
        )

    return draw


def elevation_harmonics(world: World, rng: np.random.Generator) -> Fault:
    """Draw a rail that makes the platform nod as it turns."""
    k = int(rng.integers(2, 7))
    angle, sin, cos = phase(rng)
    az, _ = _angles(world)
    return on_mount(
        "elevation_harmonics",
        ("el",),
        {"pitch": np.cos(k * az - angle)},
        facts={"k": k},
        parameters={"elevation_harmonic_sine": sin, "elevation_harmonic_cosine": cos},
    )


def azimuth_track(world: World, rng: np.random.Generator) -> Fault:
    """Draw a rail that tilts the platform both ways, and turns it a little, with one harmonic."""
    k = int(rng.integers(2, 5))
    az = believed(world).az
    pitch, roll, yaw = rng.uniform(0, 2 * np.pi, 3)
    parts = {
        "pitch": np.cos(k * az + pitch),
        "roll": -np.cos(k * az + roll),
        "yaw": 0.4 * np.cos(k * az + yaw),
    }
    return on_mount("azimuth_track", ("xel", "el"), parts, facts={"k": k})


def subreflector_jump(world: World, rng: np.random.Generator) -> Fault:
    """Draw a secondary mirror that drops when the dish rises past a curve in the sky."""
    level = rng.uniform(40, 60) * DEG
    swing = rng.uniform(0, 12) * DEG
    toward = rng.uniform(-np.pi, np.pi)

    def edge(az: Array) -> Array:
        return level + swing * np.cos(az - toward)

    place = believed(world)
    above = place.el >= edge(place.az)
    sign = float(rng.choice([-1.0, 1.0]))
    along = np.arange(0, 360, 10) * DEG
    curve = [
        {"az_deg": float(np.degrees(az)), "el_deg": float(np.degrees(edge(az)))} for az in along
    ]
    return on_mount(
        "subreflector_jump",
        ("el",),
        {"beam_down": np.where(above, sign, 0.0)},
        where={"curve": curve},
        parameters={"jump": sign},
    )


def rt32_edge(az: Array) -> Array:
    """Return the elevation [rad] of the RT32's jump; azimuth from north through east [rad].

    Borkowski 2004, routine Hjump, whose azimuth counts from south through west.
    """
    return rt32_edge_on_the_cable(wrap(az - np.pi))


def rt32_edge_on_the_cable(az_south: Array) -> Array:
    """Return the same for azimuth from south through west [rad], unwrapped as the cable is."""
    from_south = np.degrees(az_south)
    west = 55 + ((from_south - 95) / 90) ** 2 * 15
    east = 65 + 7 * np.cos(from_south * DEG / 2)
    return np.where(from_south <= 0, east, west) * DEG


FAULTS: dict[str, Draw] = {
    "azimuth_zero": _part("xel", "azimuth_zero"),
    "elevation_zero": _part("el", "elevation_zero"),
    "collimation": _part("xel", "beam_left", "collimation"),
    "skew": _part("xel", "skew"),
    "tilt": tilt,
    "sag_cosine": _part("el", "sag_cosine"),
    "sag_sine": _part("el", "sag_sine"),
    "azimuth_eccentricity": azimuth_eccentricity,
    "azimuth_harmonics": _harmonic("azimuth_harmonics", "azimuth_harmonic", "az", "az"),
    "elevation_harmonics": elevation_harmonics,
    "elevation_encoder_harmonics": _harmonic(
        "elevation_encoder_harmonics", "elevation_encoder_harmonic", "el", "el"
    ),
    "azimuth_track": azimuth_track,
    # the catalogue counts per degree
    "azimuth_scale": _part("xel", "azimuth_scale", scale=DEG),
    "elevation_scale": _part("el", "elevation_scale", scale=DEG),
    "subreflector_jump": subreflector_jump,
}


def fork_flexure(world: World, rng: np.random.Generator) -> Fault:  # noqa: ARG001
    """Draw a fork that hangs down, in which the tube looks up."""
    first, _ = _angles(world)
    return on_mount("fork_flexure", ("el",), {"beam_down": -np.cos(first)})


def declination_axis_flexure(world: World, rng: np.random.Generator) -> Fault:  # noqa: ARG001
    """Draw a declination axis whose end with the tube hangs down."""
    hangs = np.sin(believed(world).el)
    return on_mount("declination_axis_flexure", ("xel", "el"), {"beam_left": hangs})


def pier_flip(world: World, rng: np.random.Generator) -> Fault:
    """Draw encoder zeros that are others on the other side of the pier."""
    _, sin, cos = phase(rng)
    side = world.stand.side
    return on_mount(
        "pier_flip", ("xel", "el"), {"azimuth_zero": sin * side, "elevation_zero": cos * side}
    )


def _angles(world: World) -> tuple[Array, Array]:
    """Return the angles at which the axes stand, turned over or not."""
    place = believed(world)
    first, second = world.stand.angles(place.az, place.el)
    over = np.asarray(world.stand.side) < 0
    return np.where(over, first + np.pi, first), np.where(over, np.pi - second, second)


#: Causes of mounts that are not alt-azimuth.
TURNED: dict[str, Draw] = {
    "fork_flexure": fork_flexure,
    "declination_axis_flexure": declination_axis_flexure,
    "pier_flip": pier_flip,
}
