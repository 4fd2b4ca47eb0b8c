"""One case: recordings that anyone may see, and the truth about them that nobody may."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array
from pyport.examiner.worlds import campaign as noises
from pyport.examiner.worlds.campaign import Noise
from pyport.examiner.worlds.earth import wander
from pyport.examiner.worlds.faults import Fault
from pyport.examiner.worlds.faults.uncatalogued import UNKNOWN_COLUMN
from pyport.examiner.worlds.mount import Base
from pyport.examiner.worlds.schedule import Plan
from pyport.examiner.worlds.world import Observation, World, assumed_site, observe, unwrapped

_DAY_S = 86400.0
_OPERATORS = ("Ada", "Bolesław", "Chandra", "Dorota")


@dataclass(frozen=True)
class Case:
    """What `trials` writes: columns and header of a recordings file, and the truth apart."""

    #: The contract's columns, shape (n,) each; degrees, labels as text, times as ISO 8601.
    columns: dict[str, NDArray[Any]]
    header: dict[str, str]  #: what stands before them in the file
    truth: dict[str, Any]  #: what was hidden; plain numbers, text, lists and dicts
    #: Offsets without noise that the hidden causes add [rad], (x, y), shape (n,) each.
    signature: tuple[Array, Array]
    clean: tuple[Array, Array]  #: offsets without noise [rad], (x, y), shape (n,) each
    base: tuple[Array, Array]  #: columns of the base, (x, y), shape (n, k) each
    arguments: tuple[str, ...] = ()  #: what the solver is to be called with besides the file


@dataclass(frozen=True)
class Streams:
    """Independent randomness for each part of a case, so that one can change without the others."""

    plan: np.random.Generator
    mount: np.random.Generator
    fault: np.random.Generator
    noise: np.random.Generator
    decoy: np.random.Generator

    @classmethod
    def of(cls, seed: int) -> Streams:
        """Return the streams of one seed."""
        return cls(*map(np.random.default_rng, np.random.SeedSequence(seed).spawn(5)))


@dataclass(frozen=True)
class Hidden:
    """A world with its causes in it, and what they do to its recordings."""

    world: World
    observation: Observation
    noise: Noise
    signature: tuple[Array, Array]
    effects: list[dict[str, Any]]


def hide(
    world: World, faults: list[Fault], rho: float | None, noise: Noise, *, projected: bool = True
) -> Hidden:
    """Put causes into a world, each scaled to `rho`, or at its own size where that is None.

    With `projected` rho is measured after the world's base took its share,
    without it before.
    """
    effects: list[dict[str, Any]] = []
    for fault in faults:
        # A cause may bring targets of its own, so all of them are scheduled before anything else.
        world = replace(world, plan=fault.apply(world, 0.0).plan)
    clean = observe(world)
    before = clean
    base = _base(world, clean, noise)
    loud = 1.0

    def greater_rho(spoilt: World, before: Observation) -> float:
        return max(base.rho(*_difference(before, observe(spoilt)), projected=projected))

    # Where nature gives a size the noise is what gives way, so those come first.
    for fault in sorted(faults, key=lambda fault: not fault.fixed):
        size = 1.0 if fault.fixed else fault.pilot

        if rho == 0:
            size = 0.0
        elif rho is not None and fault.fixed:
            loud = greater_rho(fault.apply(world, size), before) / rho
        elif rho is not None:
            # Refraction near the horizon is not quite linear in its coefficients.
            for _ in range(2):
                size *= rho * loud / greater_rho(fault.apply(world, size), before)
        world = fault.apply(world, size)
        after = observe(world)
        added = _difference(before, after)
        left = base.rho(*added, projected=projected)
        effects.append(_described(fault, size, (left[0] / loud, left[1] / loud), added))
        before = after
    return Hidden(world, before, noise.louder(loud), _difference(clean, before), effects)


def _difference(before: Observation, after: Observation) -> tuple[Array, Array]:
    return after.x - before.x, after.y - before.y


def _base(world: World, seen: Observation, noise: Noise) -> Base:
    plan = world.plan
    return Base(
        world.stand.columns(seen.az, seen.el, world.base),
        plan.labels["antenna"],
        (plan.measures("az"), plan.measures("el")),
        (noise.sigma_x, noise.sigma_y),
    )


def _described(
    fault: Fault, size: float, rho: tuple[float, float], added: tuple[Array, Array]
) -> dict[str, Any]:
    """Return what the truth file says of one cause."""
    rms = [float(np.sqrt(np.mean(part**2)) / ARCSEC) for part in added]
    return {
        "effect": fault.effect,
        "class": sorted({fault.effect, *fault.same}),
        "beside": list(fault.beside),
        "or_unknown": fault.or_unknown,
        "size": size,
        "unit": fault.unit,
        "fixed_by_nature": fault.fixed,
        "rho_xel": rho[0],
        "rho_el": rho[1],
        "rms_xel_arcsec": rms[0],
        "rms_el_arcsec": rms[1],
        "where": fault.where,
        "facts": fault.facts,
        "parameters": {name: size * value for name, value in fault.parameters.items()},
    }


#: What files with little in them have: the place, and the time too.
LITTLE = {
    "place": ("scan_axis", "az_deg", "el_deg", "d_az_deg", "d_el_deg"),
    "time": ("time_utc", "scan_axis", "az_deg", "el_deg", "d_az_deg", "d_el_deg"),
}
#: What a mount's angles and offsets across and along its axes are called.
_AXES = {
    "altaz": ("az_deg", "el_deg", "d_az_deg", "d_el_deg"),
    "xy": ("x_deg", "y_deg", "d_x_deg", "d_y_deg"),
    "polar": ("ha_deg", "dec_deg", "d_ha_deg", "d_dec_deg"),
}


def axes_of(kind: str) -> tuple[str, ...]:
    """Return what the angles and offsets of a kind of mount are called."""
    return _AXES["xy" if kind.startswith("xy") else "altaz" if kind == "altaz" else "polar"]


def finish(
    hidden: Hidden,
    streams: Streams,
    about: dict[str, Any],
    *,
    azimuth_zero: str = "north",
    arguments: tuple[str, ...] = (),
    little: str | None = None,
) -> Case:
    """Add noise, write everything as an observer would, and set the truth apart.

    `little`: which of `LITTLE` the file has, where it has not all columns.
    """
    world, seen, noise = hidden.world, hidden.observation, hidden.noise
    plan, kind = world.plan, world.stand.kind
    noise_x, noise_y = noises.draw(streams.noise, noise, plan)
    x = np.where(plan.measures("az"), seen.x + noise_x, np.nan)
    y = np.where(plan.measures("el"), seen.y + noise_y, np.nan)
    first = seen.first
    if kind == "altaz":
        first = unwrapped(plan, first) - (np.pi if azimuth_zero == "south" else 0.0)
    recorded_s = plan.time_s + world.steering.clock_s
    angles = axes_of(kind)
    columns: dict[str, NDArray[Any]] = {
        "time_utc": np.array([_iso(t) for t in recorded_s]),
        **plan.labels,
        "hour_angle_h": seen.hour_angle * 12 / np.pi,
        "ra_deg": (plan.ra + world.steering.ra) / DEG,
        "dec_deg": (plan.dec + world.steering.dec) / DEG,
        angles[0]: first / DEG,
        angles[1]: seen.second / DEG,
        # The encoders are what is rounded, azimuth as a coordinate.
        angles[2]: noises.rounded(x / np.cos(seen.second), noise.step) / DEG,
        angles[3]: noises.rounded(y, noise.step) / DEG,
        "scan_direction": plan.scan_direction.astype(int),
        "scan_rate_arcmin_per_min": plan.scan_rate / ARCSEC,
        **decoys(streams.decoy, plan),
        **plan.weather,
    }
    if kind != "altaz":
        for name in ("hour_angle_h", "ra_deg", "scan_axis"):
            columns.pop(name, None)
    if kind == "german":
        columns["pier_side"] = np.where(np.asarray(world.stand.side) < 0, "west", "east")
    wanted = LITTLE[little] if little else tuple(columns)
    columns = {
        name: values for name, values in columns.items() if name in wanted and not _empty(values)
    }
    site = assumed_site(world)
    header = {
        "telescope": plan.site_name,
        "latitude_deg": f"{float(site.latitude) / DEG:.7f}",
        "longitude_deg": f"{float(site.longitude) / DEG:.7f}",
        "height_m": f"{float(site.height_m):.1f}",
        **({"azimuth_zero": azimuth_zero} if kind == "altaz" else {"mount": kind}),
    }
    truth = {
        "schema": "pyport.truth/1",
        **about,
        "rows": len(plan),
        "site": plan.site_name,
        "effects": hidden.effects,
        "noise": {
            "xel_arcsec": noise.sigma_x / ARCSEC,
            "el_arcsec": noise.sigma_y / ARCSEC,
            "drift_share": noise.drift_share,
            "memory_s": noise.memory_s,
            "outlier_share": noise.outlier_share,
        },
        "arguments": list(arguments),
    }
    base = world.stand.columns(seen.az, seen.el, world.base)
    clean = seen.x, seen.y
    return Case(columns, header, truth, hidden.signature, clean, base, arguments)


def _empty(values: NDArray[Any]) -> bool:
    return values.dtype.kind == "f" and bool(np.isnan(values).all())


def decoys(rng: np.random.Generator, plan: Plan) -> dict[str, NDArray[Any]]:
    """Return columns that nothing depends on (one of them may be given a meaning later)."""
    watch = np.floor(plan.time_s / (8 * 3600)).astype(int)
    return {
        "operator": np.array(_OPERATORS)[(watch + int(rng.integers(4))) % 4],
        "tsys_k": 30 + 4 * wander(rng, plan.time_s, 5 * 3600.0),
        "focus_mm": 2 * wander(rng, plan.time_s, _DAY_S),
        UNKNOWN_COLUMN: 100 + 10 * wander(rng, plan.time_s, 4 * 3600.0),
    }


def _iso(time_s: float) -> str:
    text = datetime.fromtimestamp(round(time_s, 1), UTC).isoformat(timespec="milliseconds")
    return text.replace("+00:00", "Z")
