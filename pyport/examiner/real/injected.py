"""Causes put into the noise of real recordings: nature's scatter, outliers and drifts, our truth.

The rows are those of a real set. What its model and everything that was found in it leave is taken
for its noise; the noise of whole nights is dealt out anew among them, each turned over or not, so
that what is still in it no longer goes with the sky.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.errors import BadInput
from pyport.examiner import program
from pyport.examiner.real import sets
from pyport.examiner.real.huber import scatter
from pyport.examiner.real.sets import Recordings
from pyport.examiner.worlds.case import Case
from pyport.examiner.worlds.mount import Base, Encoder, Mount, Stand, Wave
from pyport.examiner.worlds.sky import Air, bending

#: Sets that are parts or copies of others, are simulated or hold a handful of rows.
_LEFT = ("together, ", "2021-06-09", "2020", "JCMT", "MeerKAT", "simulated", "2022")
#: Causes are put into sets of so many rows: in fewer none of half the noise can be seen.
FEWEST = 200
#: Coefficients of the model that everything lies on [arcsec].
_TERM_ARCSEC = 40.0
#: Blocks that one night is cut into, where there is no other.
_BLOCKS = 8
#: Skewness, in its standard errors, up to which noise may be turned over.
_EVEN = 2.0
#: Nights are dealt among those of up to twice or half their length: in powers of two.
_ALIKE = 1.0
_OFFSETS = ("d_xel", "d_el", "d_az", "sigma_xel", "sigma_el", "d_zd")


def names(data: str | None) -> list[str]:
    """Return the sets whose noise can be had; without a folder of data the shipped ones."""
    folder = None if data is None else Path(data)
    return [
        entry["name"]
        for entry in sets.catalogue()
        if not any(part in entry["name"] for part in _LEFT)
        and (entry["format"] == "shipped" or (folder is not None and folder.is_dir()))
    ]


@functools.cache
def _read(name: str, data: str | None) -> Recordings:
    entry = next((one for one in sets.catalogue() if one["name"] == name), None)
    found = None if entry is None else sets.read(entry, None if data is None else Path(data))
    if not isinstance(found, Recordings):
        raise BadInput(f"no set of recordings {name!r}: {found or 'expected one of real/'}")
    return found


@functools.cache
def _noise(name: str, data: str | None) -> Array:
    """Return what model and findings leave of a set [arcsec], shape (n, 2), NaN for none."""
    found = _read(name, data)
    left = program.residuals(found.table, found.header, found.model)
    if isinstance(left, program.Refused):
        raise BadInput(f"{name}: {left.why}")
    noise = np.full((len(found), 2), np.nan)
    for (row, axis), value in left.items():
        noise[row, ("xel", "el").index(axis)] = value
    return noise


def causes_of(name: str, data: str | None) -> list[str]:
    """Return what can be hidden in a set and found again."""
    found = _read(name, data)
    if len(found) < FEWEST:
        return []
    if found.hour_angle is not None:
        return ["scan_direction"]
    timed = "time_utc" in found.table
    return [one for one in CAUSES if one != "scan_direction" and (timed or one != "epoch_offset")]


_Shape = Callable[[np.random.Generator, Recordings], tuple[Array, Array]]


def _mounted(draw: Callable[[np.random.Generator], Mount]) -> _Shape:
    def shape(rng: np.random.Generator, found: Recordings) -> tuple[Array, Array]:
        return Stand().shown(draw(rng), found.az, found.el)

    return shape


def _wave(on: Encoder, of: Encoder) -> _Shape:
    def draw(rng: np.random.Generator) -> Mount:
        angle = rng.uniform(0, 2 * np.pi)
        sine, cosine = ARCSEC * np.sin(angle), ARCSEC * np.cos(angle)
        return Mount(waves=(Wave(on, of, int(rng.integers(2, 5)), sine, cosine),))

    return _mounted(draw)


def _off_centre(rng: np.random.Generator) -> Mount:
    angle = rng.uniform(0, 2 * np.pi)
    return Mount(centre_right=ARCSEC * np.sin(angle), centre_ahead=ARCSEC * np.cos(angle))


def _air(_: np.random.Generator, found: Recordings) -> tuple[Array, Array]:
    return np.zeros(len(found)), bending(found.el, Air(800.0, 5.0, 0.3)) / 60


def _moved(rng: np.random.Generator, found: Recordings) -> tuple[Array, Array]:
    time = found.table["time_utc"].astype("datetime64[ms]").astype(float)
    since = np.quantile(time, rng.uniform(0.2, 0.8))
    angle, after = rng.uniform(0, 2 * np.pi), np.where(time >= since, ARCSEC, 0.0)
    return np.sin(angle) * after, np.cos(angle) * after


def _play(_: np.random.Generator, found: Recordings) -> tuple[Array, Array]:
    turned = ARCSEC * found.table["scan_direction"].astype(float)
    return np.zeros(len(found)), turned


#: What is hidden, by its name in the catalogue.
CAUSES: dict[str, _Shape] = {
    "sag_sine": _mounted(lambda _: Mount(sag_sine=ARCSEC)),
    "azimuth_eccentricity": _mounted(_off_centre),
    "azimuth_harmonics": _wave("az", "az"),
    "elevation_harmonics": _wave("el", "az"),
    "elevation_encoder_harmonics": _wave("el", "el"),
    "refraction": _air,
    "epoch_offset": _moved,
    "scan_direction": _play,
}


def injected(seed: int, name: str, effect: str | None, rho: float, data: str | None) -> Case:
    """Make a case of a real set's rows and noise, with one cause in it or none."""
    found, noise = _read(name, data), _noise(name, data)
    rng = np.random.default_rng(seed)
    fresh = _dealt(rng, found, noise)
    measured = np.isfinite(fresh)
    sigma = tuple(scatter(one[np.isfinite(one)]) * ARCSEC for one in noise.T)
    columns = found.columns()
    groups = np.unique(found.group, return_inverse=True)[1]
    size = _TERM_ARCSEC * rng.standard_normal((groups.max() + 1, columns.shape[2]))
    clean = ARCSEC * np.einsum("nak,nk->na", columns, size[groups])
    base = Base(
        (columns[:, 0], columns[:, 1]),
        found.group.astype(str),
        (measured[:, 0], measured[:, 1]),
        (sigma[0], sigma[1]),
    )
    effects: list[dict[str, Any]] = []
    signature = np.zeros_like(clean)
    if effect is not None:
        shape = CAUSES[effect](rng, found)
        factor = rho / max(base.rho(*shape))
        signature = factor * np.stack(shape, axis=1)
        left = base.rho(*signature.T)
        effects = [_told(effect, factor, left)]
    offset = clean + signature + ARCSEC * fresh
    table: dict[str, Any] = {
        key: cells
        for key, cells in found.table.items()
        if not key.startswith(_OFFSETS) and np.asarray(cells).ndim == 1
    }
    for axis, column in enumerate(("d_xel_arcsec", "d_el_arcsec")):
        if measured[:, axis].any():
            table[column] = offset[:, axis] / ARCSEC
    arguments = () if found.model == "altaz" else ("--model", found.model)
    truth = {
        "schema": "pyport.truth/1",
        "kind": "real",
        "seed": seed,
        "asked": effect or "",
        "rho": rho,
        "real": name,
        "rows": len(found),
        "effects": effects,
        "noise": {"xel_arcsec": sigma[0] / ARCSEC, "el_arcsec": sigma[1] / ARCSEC},
        "arguments": list(arguments),
    }
    header = {key: str(value) for key, value in found.header.items()}
    both = clean + signature
    return Case(
        table,
        header,
        truth,
        (signature[:, 0], signature[:, 1]),
        (both[:, 0], both[:, 1]),
        (columns[:, 0], columns[:, 1]),
        arguments,
    )


def _told(effect: str, factor: float, rho: tuple[float, float]) -> dict[str, Any]:
    """Return what the truth says of the cause."""
    return {
        "effect": effect,
        "class": [effect],
        "beside": ["refraction_curvature"] if effect == "refraction" else [],
        "or_unknown": False,
        "size": factor,
        "rho_xel": rho[0],
        "rho_el": rho[1],
        "where": {},
        "facts": {},
        "parameters": {},
    }


def _dealt(rng: np.random.Generator, found: Recordings, noise: Array) -> Array:
    """Return noise whose nights are dealt out anew among those of about their length.

    Axis by axis, each night turned over or not; one that is shorter than where it goes is played
    backward from its end on, so that nothing jumps where nature did not.
    """
    unit = found.group if len(np.unique(found.group)) > 1 else found.night
    time = found.table.get("time_utc")
    order = np.arange(len(found)) if time is None else np.argsort(time, kind="stable")
    parts = [order[unit[order] == one] for one in np.unique(unit)]
    if len(parts) == 1:
        parts = np.array_split(parts[0], _BLOCKS)
    parts.sort(key=len)
    length = np.array([len(part) for part in parts])
    hand = np.argsort(length * 2 ** rng.uniform(-_ALIKE, _ALIKE, len(parts)))
    fresh = np.full_like(noise, np.nan)
    for axis, values in enumerate(noise.T):
        nights = [part[np.isfinite(values[part])] for part in parts]
        known = np.concatenate([values[night] for night in nights])
        even = not len(known) or _is_even(known)
        for there, one in zip(nights, hand, strict=True):
            night = values[nights[one]]
            if not len(night):
                night = rng.choice(known, len(there))
            sign = rng.choice([-1, 1]) if even else 1
            fresh[there, axis] = sign * np.resize([*night, *night[::-1]], len(there))
    return fresh


def _is_even(known: Array) -> bool:
    """Tell whether noise may be turned over: no skewness is seen in it."""
    return bool(abs(np.mean((known / known.std()) ** 3)) < _EVEN * np.sqrt(6 / len(known)))
