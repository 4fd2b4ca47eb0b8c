"""Nights put to the watch: without any change, in every kind of noise, and with a step.

A case is determined by its kind, number and the seed. Half of its nights are the past, the other
half are watched.
"""

from __future__ import annotations

import dataclasses
import math
import time
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.examiner import scores
from pyport.examiner.nulls import causes, noises, nulls, schedule
from pyport.examiner.nulls.schedule import Array

#: Nights of a case, and pointings of a night in turn.
NIGHTS, POINTINGS = 10, (30, 60, 90)
#: The white sigma [arcsec].
SIGMA_ARCSEC = (3.0, 10.0)
#: A step comes within this share of the watched pointings.
STEP_WITHIN = (0.1, 0.3)
#: Sizes of steps in turn [white sigmas, rms over the axes that it acts on].
SIZES = (1.0, 2.0, 3.0, 4.0, 5.0)
#: Kinds of noise whose drifts are larger in nights that are watched, and how many times.
DRIFTS, WILDER = ("drift-20min", "drift-2h", "drift-12h", "drift-3d"), (2.0, 4.0)
#: Pointings after the alarm of a step that are still watched: until then it is named.
NAMING = 40
#: The overshoot of a random walk over a boundary, in its standard deviations: Siegmund 1985,
#: Sequential Analysis, eq. 10.17 and example 10.18.
OVERSHOOT = 1.166


@dataclass(frozen=True)
class Case:
    """Which nights: their kind of noise, number, the seed, and whether there is a step.

    The drifts of the watched nights are `wilder` times those of the past.
    """

    kind: str
    number: int
    seed: int
    step: bool = False
    wilder: float = 1.0


@dataclass(frozen=True)
class Step:
    """A step: the effect, the first watched pointing that has it, size [sigma] and delta.

    `offset` (n, 2) is what it does [arcsec], `signal` (n,) its length in sigmas.
    """

    effect: str
    first: int
    size: float
    offset: Array
    signal: Array
    truth: dict[str, float]


def _tilt(at: schedule.Pointings) -> Array:
    north, east = (
        scores.both(*scores.lean(at.az, at.el, toward), len(at)) for toward in (0.0, math.pi / 2)
    )
    return np.stack([north, east], axis=2)


#: The steps: the ids that a watch may call each by, and its columns, (n, 2, k).
STEPS = {
    "elevation zero": ("elevation_zero", lambda at: scores.altaz(at.az, at.el)[:, :, 1:2]),
    "both zeros": ("epoch_offset", lambda at: np.repeat(np.eye(2)[None], len(at), axis=0)),
    "tilt": ("tilt", _tilt),
    "sag": ("sag_cosine", lambda at: scores.both(0.0, np.cos(at.el), len(at))[:, :, None]),
}


@dataclass(frozen=True)
class World:
    """What was drawn: past and watched recordings, the white sigma, noise [sigma], the step."""

    past: dict[str, Any]
    watched: dict[str, Any]
    header: dict[str, float | str]
    sigma: float
    noise: Array
    step: Step | None


def draw(case: Case) -> World:
    """Draw the nights of a case."""
    kind = noises.KINDS[case.kind]
    rng = np.random.default_rng(
        [case.seed, zlib.crc32(case.kind.encode()), case.number, int(case.step)]
    )
    rows = NIGHTS * POINTINGS[case.number % len(POINTINGS)]
    sky = kind.skies[case.number // len(POINTINGS) % len(kind.skies)]
    at = schedule.draw(rng, rows, NIGHTS, sky)
    sigma = float(rng.uniform(*SIGMA_ARCSEC))
    truth = causes.TERM_ARCSEC * rng.standard_normal(len(scores.ALTAZ))
    drawn = kind.draw(rng, at) if case.wilder == 1 else _wilder(rng, at, kind, case.wilder)
    offset = causes.columns(at) @ truth + sigma * drawn.value
    watched = at.night >= NIGHTS // 2
    step = None
    if case.step:
        step = _step(rng, case, at, np.flatnonzero(watched), sigma)
        offset = offset + step.offset
    table, header = nulls.recorded(case.kind, at, offset, sigma, drawn)
    return World(
        {name: cells[~watched] for name, cells in table.items()},
        {name: cells[watched] for name, cells in table.items()},
        header,
        sigma,
        drawn.value[watched],
        step if step is None else _of_watched(step, watched),
    )


def _wilder(
    rng: np.random.Generator, at: schedule.Pointings, kind: noises.Kind, factor: float
) -> noises.Drawn:
    """Return white noise and the drift of a kind, so many times larger once it is watched."""
    if kind.memory_s is None or not math.isfinite(kind.memory_s):
        raise ValueError("this kind of noise has no drift of one memory")
    drift = np.stack([schedule.ou(rng, at.time_s, kind.memory_s) for _ in range(2)], axis=1)
    larger = np.where(at.night < NIGHTS // 2, 1.0, factor)[:, None] * rng.uniform(0.5, 1.5, 2)
    return noises.Drawn(rng.standard_normal((len(at), 2)) + larger * drift)


def _step(
    rng: np.random.Generator,
    case: Case,
    at: schedule.Pointings,
    watched: NDArray[np.intp],
    sigma: float,
) -> Step:
    name = list(STEPS)[case.number // len(SIZES) % len(STEPS)]
    effect, shape = STEPS[name]
    columns = shape(at)
    first = watched[int(rng.uniform(*STEP_WITHIN) * len(watched))]
    direction = rng.standard_normal(columns.shape[2])
    unit = columns @ direction
    acts = np.any(columns[watched] != 0, axis=(0, 2)).sum()
    rms = float(np.sqrt((unit[watched] ** 2).sum() / (len(watched) * acts)))
    size = SIZES[case.number % len(SIZES)]
    offset = unit * (size * sigma / rms) * (np.arange(len(at)) >= first)[:, None]
    truth = dict(enumerate((direction * size * sigma / rms).tolist()))
    return Step(
        effect,
        int(first),
        size,
        offset,
        np.linalg.norm(offset, axis=1) / sigma,
        {str(key): value for key, value in truth.items()},
    )


def _of_watched(step: Step, watched: NDArray[np.bool_]) -> Step:
    first = step.first - int(np.argmax(watched))
    return dataclasses.replace(
        step, first=first, offset=step.offset[watched], signal=step.signal[watched]
    )


def examine(case: Case, pointings_per_false_alarm: float) -> dict[str, Any]:
    """Draw a case, put it to the watch, and return what it raised."""
    import pyport

    world = draw(case)
    begun = time.monotonic()
    watch = pyport.Watch(
        world.past, header=world.header, pointings_per_false_alarm=pointings_per_false_alarm
    )
    prepared = time.monotonic()
    raised: list[dict[str, Any]] = []
    worst = 0.0
    last = time.monotonic()
    ends = len(world.noise)
    for seen in watch.replay(world.watched):
        if seen.row > ends:
            break
        now = time.monotonic()
        worst, last = max(worst, now - last), now
        raised += [
            {"row": seen.row - 1, "alarm": one.alarm["number"]}
            for one in seen.events
            if one.event == "raised"
        ]
        if world.step is not None and raised and raised[-1]["row"] >= world.step.first:
            ends = min(ends, raised[-1]["row"] + NAMING)
    alarms = {number: one.as_json(timed=True) for number, one in watch.alarms.items()}
    found = {
        **dataclasses.asdict(case),
        "pointings": len(world.noise),
        "raised": [one | {"is": alarms.get(one["alarm"])} for one in raised],
        "prepared_s": prepared - begun,
        "slowest_s": worst,
        "watched_s": time.monotonic() - prepared,
    }
    if world.step is not None:
        found |= _scored(world.step, world.noise, found["raised"], pointings_per_false_alarm)
    return found


def _scored(
    step: Step, noise: Array, raised: list[dict[str, Any]], pointings_per_false_alarm: float
) -> dict[str, Any]:
    """Return the delay of the first alarm after a step, and of the best possible one."""
    before = [one for one in raised if one["row"] < step.first]
    after = [one for one in raised if one["row"] >= step.first]
    first = after[0] if after else None
    return {
        "effect": step.effect,
        "size": step.size,
        "first": step.first,
        "false": len(before),
        "delay": None if first is None else first["row"] - step.first + 1,
        "best": best_delay(step, noise, pointings_per_false_alarm),
        "right": first is not None and step.effect in first["is"]["class"],
        "since_off": None if first is None else first["is"]["since_row"] - 1 - step.first,
        "stands": first is not None and first["is"]["state"] in ("raised", "confirmed"),
    }


def best_delay(step: Step, noise: Array, pointings_per_false_alarm: float) -> int | None:
    """Return the delay of a CUSUM that knows the step's shape and size, the noise and the model.

    No rule with as few false alarms reacts earlier on average (Moustakides 1986, Annals of
    Statistics 14, 1379).
    """
    after = np.arange(len(noise)) >= step.first
    usual = float(np.sqrt(np.mean(step.signal[after] ** 2)))
    threshold = usual * _boundary(usual, pointings_per_false_alarm)
    # before the step it would look for the same shape, there at its usual size
    total = 0.0
    for n in range(step.first, len(noise)):
        unit = step.offset[n] / max(float(np.linalg.norm(step.offset[n])), 1e-300)
        signal = step.signal[n]
        total = max(0.0, total + signal * (unit @ noise[n] + signal / 2))
        if total >= threshold:
            return n - step.first + 1
    return None


def _boundary(shift: float, run_length: float) -> float:
    """Return the boundary of a CUSUM for a shift [sigma], for a mean run length without it.

    Siegmund's approximation, solved by bisection; in standard deviations.
    """
    low, high = 0.0, 2 * math.log(run_length * shift**2 + 10) / shift + 10
    for _ in range(80):
        middle = (low + high) / 2
        x = shift * (middle + OVERSHOOT)
        if (math.expm1(x) - x) / (shift**2 / 2) < run_length:
            low = middle
        else:
            high = middle
    return high


def null_cases(nights: int, seed: int) -> list[Case]:
    """Return cases without change that have so many watched nights together."""
    count = math.ceil(nights / (NIGHTS - NIGHTS // 2))
    kinds = list(noises.KINDS)
    return [Case(kinds[n % len(kinds)], n // len(kinds), seed) for n in range(count)]


def wilder_cases(nights: int, seed: int) -> list[Case]:
    """Return cases without change whose watched nights drift twice and four times as far."""
    count = math.ceil(nights / (NIGHTS - NIGHTS // 2))
    kinds = [(kind, factor) for kind in DRIFTS for factor in WILDER]
    some = [(*kinds[n % len(kinds)], n // len(kinds)) for n in range(count)]
    return [Case(kind, number, seed, wilder=factor) for kind, factor, number in some]


def step_cases(count: int, seed: int) -> list[Case]:
    """Return nights with a step in white noise."""
    return [Case("white", n, seed, step=True) for n in range(count)]
