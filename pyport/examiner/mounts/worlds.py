"""Sessions drawn on mounts of other axes, and what may act on them beside a model of five terms."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, Array
from pyport.examiner.mounts.twins import Flaws, Session, alike, axes_of
from pyport.examiner.nulls import noises, schedule
from pyport.examiner.worlds.mount import Mount, Wave

#: Rows of a case, in turn, its nights, and the kinds of noise with the rms of each, outliers apart.
ROWS, SESSIONS = (200, 400, 800), (1, 4)
NOISES = {"white": 1.0, "student-3": math.sqrt(3.0), "outliers-both-ways": 1.0}
#: The noise's rms [arcsec], of the model's terms, and how visible a cause is in units of it.
SIGMA_ARCSEC, TERM_ARCSEC, VISIBLE = (3.0, 10.0), 60.0, 0.5
#: A German mount is used on both of its sides so far from the meridian [rad].
OVERLAP = math.radians(20)
#: No source is observed so near to the first axis [rad].
KEYHOLE = math.radians(12)
#: A cause of which the model leaves less than this share visible is not drawn.
LEAST_SHARE = 0.1
EMPTY, ONE, TWO, UNKNOWN = "empty", "one", "two", "unknown"

#: A number for each pointing's wave, and what is wrong for an amplitude of one.
Make = Callable[[float, float], Flaws]


def _of(**parts: float) -> Make:
    return lambda size, _: Flaws(Mount().plus(**{k: size * part for k, part in parts.items()}))


#: The terms that all models here have, and the fifth one of each mount.
TERMS: dict[str, Make] = {
    "azimuth_zero": _of(azimuth_zero=1.0),
    "elevation_zero": _of(elevation_zero=1.0),
    "collimation": _of(beam_left=1.0),
    "skew": _of(skew=1.0),
}
FIFTH: dict[str, tuple[str, Make]] = {
    "german": ("declination_axis_flexure", lambda size, _: Flaws(tube_end=size)),
    "fork": ("fork_flexure", lambda size, _: Flaws(fork=size)),
    "xy-ns": ("y_scale", _of(elevation_scale=1.0)),
    "xy-ew": ("y_scale", _of(elevation_scale=1.0)),
}


def _lean(size: float, phase: float) -> Flaws:
    return Flaws(Mount(tilt_north=size * np.cos(phase), tilt_east=size * np.sin(phase)))


def _first_encoder(size: float, phase: float) -> Flaws:
    wave = Wave("az", "az", 2, size * np.cos(phase), size * np.sin(phase))
    return Flaws(Mount(waves=(wave,)))


def _second_encoder(size: float, phase: float) -> Flaws:
    wave = Wave("el", "el", 2, size * np.cos(phase), size * np.sin(phase))
    return Flaws(Mount(waves=(wave,)))


#: Causes, and what the program should call them. X goes through less than half of the circle, in
#: which no harmonic of it can be told from another.
CAUSES: dict[str, tuple[dict[str, str], Make]] = {
    "lean": ({"german": "polar_axis", "fork": "polar_axis", "xy": "x_axis_tilt"}, _lean),
    "droop": (
        {"german": "sag_cosine", "fork": "sag_cosine", "xy": "sag_cosine"},
        lambda size, _: Flaws(droop=size),
    ),
    "pier": (
        {"german": "pier_flip"},
        lambda size, phase: Flaws(pier=(size * np.cos(phase), size * np.sin(phase))),
    ),
    "first encoder": (
        {"german": "hour_angle_harmonics", "fork": "hour_angle_harmonics"},
        _first_encoder,
    ),
    "second encoder": ({"xy": "y_encoder_harmonics"}, _second_encoder),
}


@dataclass(frozen=True)
class Case:
    """Which case is meant: its mount, part, number and the seed of all."""

    mount: str
    part: str
    number: int
    seed: int


@dataclass(frozen=True)
class World:
    """A drawn session: columns, header keys, the model, and the names that are hidden in it.

    `twins` holds for each hidden name those that nobody could tell from it in this session.
    """

    table: dict[str, Any]
    header: dict[str, float | str]
    model: str
    hidden: tuple[str, ...]
    sigma: float
    twins: dict[str, tuple[str, ...]]


def called(name: str, mount: str) -> str | None:
    """Return what the program should call a cause on a mount; None where there is no such."""
    return CAUSES[name][0].get(mount.partition("-")[0])


def model_of(mount: str) -> str:
    """Return the five terms as a model file lists them."""
    first, second = ("x", "y") if mount.startswith("xy") else ("hour_angle", "declination")
    ids = (f"{first}_zero", f"{second}_zero", "collimation", "skew", FIFTH[mount][0])
    return "".join(f'[[term]]\neffect = "{one}"\n' for one in ids)


def draw(case: Case) -> World:
    """Return the session of a case."""
    rng = np.random.default_rng(
        [case.seed, sum(map(ord, case.mount)), case.number, len(case.part), ord(case.part[0])]
    )
    rows = ROWS[case.number % len(ROWS)]
    at = schedule.draw(rng, 3 * rows, int(rng.choice(SESSIONS)), "wide")
    first, second = axes_of(case.mount, at.latitude, at.az, at.el)
    kept = np.flatnonzero(np.cos(second) > np.sin(KEYHOLE))
    kept = np.sort(rng.permutation(kept)[:rows])
    side = _sides(rng, case.mount, first)[kept]
    at = _taken(at, kept)
    kind = list(NOISES)[case.number // len(ROWS) % len(NOISES)]
    noise = noises.KINDS[kind].draw(rng, at).value / NOISES[kind]
    sigma = float(rng.uniform(*SIGMA_ARCSEC))

    session = Session(case.mount, at, side)

    def shown(flaws: Flaws) -> Array:
        """Return what flaws do, (n, 2) [arcsec]."""
        return session.shown(flaws).reshape(-1, 2)

    terms = {**TERMS, FIFTH[case.mount][0]: FIFTH[case.mount][1]}
    base = np.stack([shown(make(ARCSEC, 0.0)).ravel() for make in terms.values()], axis=1)
    total = (base @ (TERM_ARCSEC * rng.standard_normal(base.shape[1]))).reshape(-1, 2)
    hidden: list[str] = []
    traces: dict[str, Array] = {}
    for name in _chosen(rng, case):
        phase = float(rng.uniform(0, 2 * np.pi))
        shape = _bump(rng, at) if name == UNKNOWN else shown(CAUSES[name][1](ARCSEC, phase))
        size = _sized(rng, shape, base, sigma)
        if name == UNKNOWN:
            total, hidden = total + size * shape, [*hidden, UNKNOWN]
            continue
        total = total + shown(CAUSES[name][1](size * ARCSEC, phase))
        hidden.append(called(name, case.mount) or name)
        traces[hidden[-1]] = shape.ravel()
    return World(
        _table(
            case.mount,
            at,
            axes_of(case.mount, at.latitude, at.az, at.el),
            side,
            total + sigma * noise,
        ),
        {
            "latitude_deg": math.degrees(at.latitude),
            "longitude_deg": math.degrees(at.longitude),
            "mount": case.mount,
        },
        model_of(case.mount),
        tuple(hidden),
        sigma,
        {
            name: tuple(
                one for one in alike(trace, _beside(base, traces, name), session) if one != name
            )
            for name, trace in traces.items()
        },
    )


def _beside(base: Array, traces: Mapping[str, Array], name: str) -> Array:
    """Return what is fitted beside one of the hidden traces: the model and the others."""
    return np.column_stack([base, *(one for other, one in traces.items() if other != name)])


def _chosen(rng: np.random.Generator, case: Case) -> list[str]:
    """Return the causes of a case: by turns, so that all are drawn alike."""
    possible = [name for name in CAUSES if called(name, case.mount)]
    if case.part == EMPTY:
        return []
    if case.part == UNKNOWN:
        return [UNKNOWN]
    first = possible[case.number % len(possible)]
    if case.part == ONE:
        return [first]
    others = [name for name in possible if name != first]
    return [first, str(rng.choice(others))]


def _sides(rng: np.random.Generator, mount: str, first: Array) -> Array:
    """Return -1 where the mount has turned over: in the east, and here and there near south."""
    if mount != "german":
        return np.ones(len(first))
    near = np.abs(first) < OVERLAP
    return np.where(near, rng.choice([-1.0, 1.0], len(first)), np.where(first > 0, 1.0, -1.0))


def _bump(rng: np.random.Generator, at: schedule.Pointings) -> Array:
    """Return an offset of one axis in a part of the sky, smooth at its rim: no effect's shape."""
    centre = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(30, 60))
    cosine = np.sin(at.el) * np.sin(centre[1])
    cosine = cosine + np.cos(at.el) * np.cos(centre[1]) * np.cos(at.az - centre[0])
    height = np.exp((cosine - 1) / np.radians(rng.uniform(15, 25)) ** 2)
    return height[:, None] * np.eye(2)[rng.integers(2)]


def _sized(rng: np.random.Generator, shape: Array, base: Array, sigma: float) -> float:
    """Return the size at which a shape shows half of the noise once the model took its share."""
    flat = shape.ravel()
    left = flat - base @ np.linalg.lstsq(base, flat, rcond=None)[0]
    acts = int(np.any(np.abs(shape) > 1e-9, axis=0).sum())
    rms = np.linalg.norm(left) / np.sqrt(len(shape) * acts)
    return float(rng.choice([-1.0, 1.0]) * VISIBLE * sigma / rms)


def _taken(at: schedule.Pointings, rows: NDArray[np.intp]) -> schedule.Pointings:
    parts = ("time_s", "night", "source", "az", "el", "ra", "dec")
    weather = {name: one[rows] for name, one in at.weather.items()}
    return replace(at, weather=weather, **{name: getattr(at, name)[rows] for name in parts})


def _table(
    mount: str,
    at: schedule.Pointings,
    axes: tuple[Array, Array],
    side: Array,
    offset: Array,
) -> dict[str, Any]:
    names: Mapping[str, str] = (
        {"first": "x_deg", "second": "y_deg", "across": "d_xx_arcsec", "along": "d_y_arcsec"}
        if mount.startswith("xy")
        else {
            "first": "ha_deg",
            "second": "dec_deg",
            "across": "d_xha_arcsec",
            "along": "d_dec_arcsec",
        }
    )
    stamp = schedule.START + np.round(at.time_s * 1000).astype("timedelta64[ms]")
    table: dict[str, Any] = {
        "time_utc": stamp,
        "session": np.array([f"night {n:02d}" for n in at.night]),
        "source": np.array([f"S{n:03d}" for n in at.source]),
        names["first"]: np.degrees(axes[0]),
        names["second"]: np.degrees(axes[1]),
        names["across"]: offset[:, 0],
        names["along"]: offset[:, 1],
    }
    if mount == "german":
        table["pier_side"] = np.where(side < 0, "west", "east")
    return table | at.weather
