"""Rehearsals: made nights of a telescope that is known, predicted where nobody observed.

A telescope is taken to be exactly what a contender says of it. Nights are made at
the directions that were observed, with the noise that was found; everyone is fitted
to them as to the real one. Then the truth is known everywhere: what each claims by leaving
pointings out stands beside what it would leave of fresh pointings.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import ARCSEC, Array
from pyport.effects.base import Circumstances
from pyport.models.model import Model
from pyport.prediction.contenders import Contender, Night, OwnChoice, Picked, Refitted
from pyport.prediction.unseen import left_out, on_the_sky, schemes
from pyport.recordings.schema import Recordings
from pyport.runs.workers import one_thread

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
