"""Recordings in which nothing is hidden, or one cause, in every kind of noise: drawn and examined.

A case is determined by its kind, number, part and the seed; its rows, sessions and sky follow
from its number alone, so that every run of as many cases has the same mixture.
"""

from __future__ import annotations

import dataclasses
import math
import time
import zlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pyport.errors import BadInput
from pyport.examiner import program, scores
from pyport.examiner.nulls import causes, noises, schedule
from pyport.examiner.nulls.schedule import Array

#: Rows of a case, in turn.
ROWS = (60, 100, 200, 600, 1200)
#: The white sigma of a case [arcsec], and how visible a cause is in units of it.
SIGMA_ARCSEC, VISIBLE = (3.0, 10.0), (0.5, 1.0)
#: A drift that remembers for more than this share of the campaign moves the constants.
LONG_MEMORY = 0.2
NULL, CAUSE = "null", "cause"


@dataclass(frozen=True)
class Case:
    """Which case is meant: its kind of noise, number, part (null or cause) and the seed of all."""

    kind: str
    number: int
    part: str
    seed: int

    @property
    def rows(self) -> int:
        """Return the number of recordings."""
        return ROWS[self.number % len(ROWS)]

    @property
    def sessions(self) -> int:
        """Return the number of nights."""
        some = noises.KINDS[self.kind].sessions
        return some[self.number % len(some)]

    @property
    def sky(self) -> str:
        """Return the part of the sky; it changes once the numbers of nights are through."""
        kind = noises.KINDS[self.kind]
        return kind.skies[self.number // len(kind.sessions) % len(kind.skies)]


@dataclass(frozen=True)
class World:
    """What was drawn for a case."""

    #: `table`, `header`: the recordings as the program is given them.
    table: dict[str, Any]
    header: dict[str, float | str]
    truth: dict[str, float]  #: coefficients of the hidden model [arcsec]
    #: Those of them that the noise itself moves, so that they have no truth.
    uncertain: tuple[str, ...]
    cause: causes.Cause | None  #: the one cause, None where nothing is hidden
    sigma: float  #: the white sigma [arcsec]


def draw(case: Case) -> World:
    """Draw the recordings of a case."""
    kind = noises.KINDS[case.kind]
    part = (NULL, CAUSE).index(case.part)
    rng = np.random.default_rng([case.seed, zlib.crc32(case.kind.encode()), case.number, part])
    at = schedule.draw(rng, case.rows, case.sessions, case.sky)
    sigma = float(rng.uniform(*SIGMA_ARCSEC))
    truth = causes.TERM_ARCSEC * rng.standard_normal(len(scores.ALTAZ))
    drawn = kind.draw(rng, at)
    offset = causes.columns(at) @ truth + sigma * drawn.value
    cause = None
    if case.part == CAUSE:
        visible = float(rng.uniform(*VISIBLE)) * sigma
        # Rows go by fives as causes do: shifted by one each time, every pair of them is drawn.
        cause = causes.draw(rng, at, case.number + case.number // len(ROWS), visible)
        offset = offset + cause.offset
    memory_s = kind.memory_s or 0.0
    moved = not kind.centred or memory_s > LONG_MEMORY * np.ptp(at.time_s)
    return World(
        *recorded(case.kind, at, offset, sigma, drawn),
        dict(zip(scores.ALTAZ, truth.tolist(), strict=True)),
        causes.CONSTANTS if moved else (),
        cause,
        sigma,
    )


def recorded(
    kind: str, at: schedule.Pointings, offset: Array, sigma: float, drawn: noises.Drawn
) -> tuple[dict[str, Any], dict[str, float | str]]:
    """Return recordings as columns, and their header, as a kind of noise has them.

    `offset`, `sigma`: (n, 2) and the white sigma [arcsec].
    """
    if kind == noises.ROUNDED:
        step = noises.ROUNDED_TO * sigma
        offset = step * np.round(offset / step)
    stamp = schedule.START + np.round(at.time_s * 1000).astype("timedelta64[ms]")
    table: dict[str, Any] = {
        "time_utc": stamp,
        "session": np.array([f"night {n:02d}" for n in at.night]),
        "source": np.array([f"S{n:03d}" for n in at.source]),
        "az_deg": np.degrees(at.az),
        "el_deg": np.degrees(at.el),
        "d_xel_arcsec": offset[:, 0],
        "d_el_arcsec": offset[:, 1],
    }
    if kind == noises.SIGMA_GIVEN and drawn.sigma is not None:
        across, along = (drawn.sigma * sigma).T
        table |= {"sigma_xel_arcsec": across, "sigma_el_arcsec": along}
    header: dict[str, float | str] = {
        "latitude_deg": math.degrees(at.latitude),
        "longitude_deg": math.degrees(at.longitude),
        "height_m": 500.0,
    }
    return table | at.weather, header


def examine(case: Case) -> dict[str, Any]:
    """Draw a case, put it to the program, and return what came out beside the truth."""
    world = draw(case)
    begun = time.monotonic()
    report = program.diagnosed(world.table, world.header)
    outcome = {
        **dataclasses.asdict(case),
        "program": program.version(),
        "rows": case.rows,
        "sessions": case.sessions,
        "sky": case.sky,
        "sigma_arcsec": world.sigma,
        "cause": world.cause.effect if world.cause else None,
        "seconds": time.monotonic() - begun,
    }
    if isinstance(report, program.Refused):
        return outcome | {"refused": report.why}
    outcome |= {
        "claimed": claimed(report),
        "p_value": report["p_value"],
        "findings": [
            {key: one.get(key) for key in ("effect", "variant", "verdict")}
            for one in report["findings"]
        ],
    }
    if world.cause is not None:
        return outcome | {"z": of_cause(report, world.cause)}
    try:
        return outcome | {"z": of_fit(world)}
    except BadInput as refused:
        return outcome | {"refused": str(refused)}


def of_fit(world: World) -> dict[str, float]:
    """Return how many sigmas the fitted coefficients of a world are from the truth.

    Raises `BadInput`: the program refused the recordings.
    """
    fit = program.fitted(world.table, world.header)
    if isinstance(fit, program.Refused):
        raise BadInput(fit.why)
    known = {name: one for name, one in world.truth.items() if name not in world.uncertain}
    return _z(fit["parameters"], known.get)


def claimed(report: dict[str, Any]) -> bool:
    """Tell whether a report claims that something is missing; scatter it reports is no claim."""
    return bool(report["mismatch"]) and len(report["findings"]) > 0


def of_cause(report: dict[str, Any], cause: causes.Cause) -> dict[str, float]:
    """Return how many sigmas the coefficients of the right finding are from the truth.

    Another member of the family has coefficients that mean something else: they are not scored.
    """
    drawn = causes.VARIANTS.get(cause.effect)
    for one in report["findings"]:
        if one["effect"] == cause.effect and drawn in {None, one.get("variant") or drawn}:
            return _z(one["parameters"], cause.expected)
    return {}


def _z(
    parameters: Iterable[dict[str, Any]], truth: Callable[[str], float | None]
) -> dict[str, float]:
    """Return value minus truth over sigma; what has no truth or no value is left out."""
    found = {}
    for one in parameters:
        true, value, sigma = truth(one["name"]), one["value"], one["sigma"]
        if true is None or value is None or sigma is None:
            continue
        found[one["name"]] = (value - true) / sigma if sigma > 0 else math.copysign(1e9, value)
    return found


def cases(kinds: Iterable[str], count: int, seed: int, parts: Iterable[str]) -> list[Case]:
    """Return `count` cases of each kind and part, the kinds by turns: all grow together."""
    kinds, parts = list(kinds), list(parts)
    return [
        Case(kind, number, part, seed)
        for number in range(count)
        for part in parts
        for kind in kinds
    ]
