"""Rehearsals: made nights of a telescope that is known, predicted where nobody observed.

A telescope is taken to be exactly what a contender says of it. Nights are made at
the directions that were observed, with the noise that was found; everyone is fitted
to them as to the real one. Then the truth is known everywhere: what each claims by leaving
pointings out stands beside what it would leave of fresh pointings.

Single pointings have neighbours in the fit, and bend with them; a whole band or sector
has none, as any direction has that was not observed.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pyport.angles import ARCSEC, DEG, Array, Codes
from pyport.effects import CATALOGUE
from pyport.effects.base import Circumstances, MissingColumn
from pyport.effects.telescope.geometry import NIGHTLY
from pyport.errors import BadInput
from pyport.files import write_whole
from pyport.models.model import Model
from pyport.mounts import ALTAZ
from pyport.prediction import shrunk
from pyport.prediction.contenders import Contender, Night, OwnChoice, Picked, Refitted, Rows, solved
from pyport.recordings.schema import Recordings
from pyport.runs.workers import one_thread

#: Steps of the grid.
AZIMUTH_DEG, ELEVATION_DEG = 10, 5
_NAMES = ("az_deg", "el_deg", "d_xel_arcsec", "sigma_xel_arcsec", "d_el_arcsec", "sigma_el_arcsec")


def write_grid(recordings: Recordings, model: Model, path: Path) -> None:
    """Write the model with waves over the elevations that were observed, and its errors.

    The file is one of recordings as any other. An axis that was not measured is left blank.
    Errors are those of the prediction; the scatter of a single pointing comes on top.

    Raises `BadInput`: there are several antennas, the mount is no alt-azimuth one, or a term asks
    for more than a direction.
    """
    if recordings.at.mount is not ALTAZ:
        wrong = f"a mount of {recordings.at.mount.id}, expected an alt-azimuth one for a grid"
        raise BadInput(wrong, recordings.file)
    night = Night.of(recordings)
    found = OwnChoice(night, model).whole
    low, high = recordings.at.el.min() / DEG, recordings.at.el.max() / DEG
    steps = np.arange(np.ceil(low / ELEVATION_DEG), np.floor(high / ELEVATION_DEG) + 1)
    heights = steps * ELEVATION_DEG if len(steps) else np.unique([low, high])
    around = np.arange(0, 360, AZIMUTH_DEG)
    az, el = (one.ravel() * DEG for one in np.meshgrid(around, heights))
    at = Circumstances(az, el, recordings.at.site, mount=recordings.at.mount)
    given = model.offsets(at)
    try:
        columns = [term.effect.columns(at) for term in model.fitted()]
    except MissingColumn as lack:
        raise BadInput(f"{model.name} {lack}: a grid of directions has none") from None
    shapes = shrunk.columns(at)
    told = []
    for axis in (0, 1):
        own = np.concatenate([np.zeros((len(at), 0)), *(both[axis] for both in columns)], axis=1)
        there = shrunk.Known(own, shapes, np.full(len(at), axis == 1), given[axis])
        value = found.predict(there) + given[axis]
        wide = there.columns()
        sigma = np.sqrt(np.einsum("mk,mk->m", wide @ found.covariance, wide))
        measured = bool(axis) in found.noise
        told += [
            [f"{one / ARCSEC:.3f}" if measured else "" for one in both] for both in (value, sigma)
        ]
    with write_whole(path) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(_NAMES)
        places = [[f"{one / DEG:g}" for one in both] for both in (az.round(9), el.round(9))]
        writer.writerows(zip(*places, *told, strict=True))


#: Parts that pointings are dealt to, and that elevation and azimuth are cut into.
DEALT, BANDS, SECTORS = 10, 10, 8
#: Pointings are dealt so often: what terms are picked hangs on who is left out with whom.
DEALS = 5


@dataclass(frozen=True)
class Scheme:
    """A way to leave readings out: its name, and each time the part of each reading, (m,)."""

    name: str
    parts: tuple[Codes, ...]


def schemes(night: Night, seed: int) -> Iterator[Scheme]:
    """Yield the ways to leave readings of a night out."""
    first, number = night.pointings
    az, el = (one[first] for one in (night.recordings.at.az, night.recordings.at.el))
    rng = np.random.default_rng(seed)
    deals = tuple((rng.permutation(len(first)) % DEALT)[number] for _ in range(DEALS))
    yield Scheme("pointings", deals)
    yield Scheme("elevation bands", (_cut(el, BANDS)[number],))
    yield Scheme("azimuth sectors", (_cut(np.mod(az, 2 * np.pi), SECTORS)[number],))


def _cut(values: Array, parts: int) -> Codes:
    """Cut values (n,) into parts of as many each, by rank."""
    rank = np.argsort(np.argsort(values, kind="stable"), kind="stable")
    return rank * min(parts, len(values)) // len(values)


def left_out(contender: Contender, scheme: Scheme) -> Array:
    """Return the rms, over all times, of what is left of each reading unseen, shape (m,)."""
    squares = np.zeros(len(scheme.parts[0]))
    for part in scheme.parts:
        for one in np.unique(part):
            own = part == one
            squares[own] += contender.residual(~own)[own] ** 2
    return np.asarray(np.sqrt(squares / len(scheme.parts)))


def on_another(contender: Contender, own: Night, other: Night) -> Array:
    """Return what is left of another night's readings, its zero points refitted, shape (m,)."""
    left = contender.residual(np.ones(len(own.stack), bool), other)
    zeros = np.concatenate(
        [other.stack.columns(CATALOGUE[one], other.recordings.at) for one in NIGHTLY], axis=1
    )
    everything = np.ones(len(left), bool)
    return np.asarray(left - zeros @ solved(zeros, left, other.stack.is_y, everything)[0])


def on_the_sky(left: Array, is_y: Rows, counted: Rows) -> float:
    """Return the rms on the sky of residuals in both axes; of one axis where there is one."""
    squares = [
        float(np.mean(left[rows] ** 2)) for rows in (counted & ~is_y, counted & is_y) if rows.any()
    ]
    return float(np.sqrt(sum(squares)))


#: Made nights of each truth, and fresh pointings of each.
NIGHTS, FRESH = 6, 300


@dataclass(frozen=True)
class Rehearsal:
    """What contenders come to on made nights of one telescope: rms on the sky [arcsec]."""

    truth: str  #: whose telescope it was
    claimed: dict[str, float]  #: on pointings left out, by contender
    #: On fresh pointings all over the elevations that were observed, with their noise.
    fresh: dict[str, float]


@one_thread
def rehearse(
    recordings: Recordings, model: Model, rival: Model, *, seed: int = 0
) -> tuple[Rehearsal, Rehearsal]:
    """Rehearse on the telescope of a rival model, and on that of the model with waves.

    Raises `BadInput`: there are several antennas, or a term asks for more than a direction, which
      is all that fresh pointings have.
    """
    night = Night.of(recordings)
    rng = np.random.default_rng(seed)
    fresh = Night.of(_elsewhere(recordings, rng))
    published, own = Refitted(night, rival), OwnChoice(night, model)
    scatter = np.where(
        night.stack.is_y, own.whole.noise.get(True, 0.0), own.whole.noise.get(False, 0.0)
    )
    first, second = (
        _rehearsed(one, model, rival, (night, fresh), scatter, rng) for one in (published, own)
    )
    return first, second


def _elsewhere(recordings: Recordings, rng: np.random.Generator) -> Recordings:
    """Return pointings all over the sky between the elevations that were observed."""
    low, high = np.sin(recordings.at.el.min()), np.sin(recordings.at.el.max())
    az, el = rng.uniform(0, 2 * np.pi, FRESH), np.arcsin(rng.uniform(low, high, FRESH))
    nothing = np.full(FRESH, np.nan)
    x, y = (
        np.zeros(FRESH) if np.isfinite(one).any() else nothing
        for one in (recordings.x, recordings.y)
    )
    at = Circumstances(az, el, recordings.at.site, mount=recordings.at.mount)
    return replace(
        recordings, at=at, x=x, y=y, sigma_x=nothing, sigma_y=nothing, line=np.arange(FRESH)
    )


def _rehearsed(
    truth: Refitted | OwnChoice,
    model: Model,
    rival: Model,
    nights: tuple[Night, Night],
    scatter: Array,
    rng: np.random.Generator,
) -> Rehearsal:
    night, fresh = nights
    everything = np.ones(len(night.stack), bool)
    # What a contender leaves of zero, the sign turned, is what it says the telescope does.
    there = -truth.residual(everything, _with(fresh, np.zeros(len(fresh.stack))))
    here = night.stack.value - truth.residual(everything)
    claimed: dict[str, list[float]] = {}
    left: dict[str, list[float]] = {}
    for _ in range(NIGHTS):
        made = _with(night, here + scatter * rng.normal(size=len(here)))
        for one in _contenders(made, model, rival):
            way = next(iter(schemes(made, 0)))
            once = left_out(one, replace(way, parts=way.parts[:1]))
            off = one.residual(everything, _with(fresh, there))
            claimed.setdefault(one.name, []).append(_squared(once, made))
            left.setdefault(one.name, []).append(_squared(off, fresh) + _squared(scatter, night))
    return Rehearsal(truth.name, _pooled(claimed), _pooled(left))


def _contenders(night: Night, model: Model, rival: Model) -> Iterator[Contender]:
    yield Refitted(night, model)
    yield (published := Refitted(night, rival))
    if published.terms > night.columns(model).shape[1]:
        yield Picked(night, model, int(published.terms), anew=False)
    yield OwnChoice(night, model)


def _with(night: Night, value: Array) -> Night:
    return Night(night.recordings, replace(night.stack, value=value))


def _squared(left: Array, night: Night) -> float:
    """Return the mean square on the sky [arcsec^2]."""
    return (on_the_sky(left, night.stack.is_y, np.ones(len(left), bool)) / ARCSEC) ** 2


def _pooled(squares: dict[str, list[float]]) -> dict[str, float]:
    return {name: float(np.sqrt(np.mean(several))) for name, several in squares.items()}
