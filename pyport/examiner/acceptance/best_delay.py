"""The least delay after a known change of public recordings: of a rule that knows all about it.

It is given the moment, the effect, its size as the recordings since then have it, and the noise of
all recordings with the change taken out; the model it learns as the watch does. Its likelihood
ratio is that of a cumulative sum, whose threshold keeps the watch's promise (Lorden 1971, Annals
of Mathematical Statistics 42, 1897): no rule that must look for what changed, when and how much,
in noise that only the past tells, can be expected to do better.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pyport.effects import CATALOGUE, Circumstances, Effect
from pyport.examiner.scores import Array
from pyport.fitting.fit import fit
from pyport.formats.models import load
from pyport.models.model import Model, Term
from pyport.recordings.from_table import from_table
from pyport.recordings.schema import Recordings
from pyport.recordings.sky import with_nights
from pyport.watch.detection import null
from pyport.watch.detection.baseline import past
from pyport.watch.detection.changes import together
from pyport.watch.detection.prepare import prepare


@dataclass(frozen=True)
class Best:
    """What the best rule makes of a known change.

    `delay` is in pointings, None where it raises nothing; `most` is the largest logarithm to base
    10 of its likelihood ratio since the change.
    """

    delay: int | None
    most: float


def best(
    table: Mapping[str, Any],
    header: Mapping[str, Any],
    model: str,
    known: Sequence[tuple[float, str]],
    pointings_per_false_alarm: float,
) -> list[Best]:
    """Return the best delay for each known change.

    `known`: when each was [s since 1970], and the effect that changed; "" for all terms of the
      model.
    """
    whole = with_nights(from_table(dict(table), dict(header)))
    time = np.asarray(whole.at.column("time"), float)
    order = np.argsort(time, kind="stable")
    gains = _gains(whole.take(order), load(model), known)
    threshold = math.log(pointings_per_false_alarm)
    return [
        _delay(gain[time[order] >= since], threshold)
        for gain, (since, _) in zip(gains, known, strict=True)
    ]


def _delay(gains: Array, threshold: float) -> Best:
    total, most, delay = 0.0, 0.0, None
    for n, gain in enumerate(gains):
        total = max(total + gain, 0.0)
        most = max(most, total)
        if delay is None and total >= threshold:
            delay = n + 1
    return Best(delay, float(most) / math.log(10))


def _gains(some: Recordings, model: Model, known: Sequence[tuple[float, str]]) -> Array:
    """Return what each row adds to the log-ratio of each known change, (K, n)."""
    whole = together([term.effect for term in model.fitted()])
    steps = [Term(_since(CATALOGUE[name] if name else whole, since)) for since, name in known]
    found = fit(some, replace(model, terms=(*model.terms, *steps)))
    offsets = []
    for step in steps:
        size = np.nan_to_num(next(one.value for one in found.coefficients if one.term is step))
        offsets.append(np.stack([part @ size for part in step.effect.columns(some.at)], axis=1))
    gains = np.zeros((len(known), len(some)))
    for k in range(len(known)):
        others = sum((one for j, one in enumerate(offsets) if j != k), np.zeros((len(some), 2)))
        seen = replace(some, x=some.x - others[:, 0], y=some.y - others[:, 1])
        without = replace(seen, x=seen.x - offsets[k][:, 0], y=seen.y - offsets[k][:, 1])
        gains[k] = _of_one(seen, without, model)
    return gains


def _since(effect: Effect, since: float) -> Effect:
    def basis(at: Circumstances) -> tuple[Array, Array]:
        later = (np.asarray(at.column("time"), float) >= since)[:, None]
        x, y = effect.columns(at)
        return x * later, y * later

    return replace(effect, id=f"{effect.id}_since_{since:.0f}", basis=basis)


def _of_one(seen: Recordings, without: Recordings, model: Model) -> Array:
    """Return the log-density of each row less its change, over that of the row, filtered alike."""
    baseline = past(without, model).baseline
    known = null.states(baseline)
    gains = np.zeros(len(seen))
    filters = null.begin(known), null.begin(known)
    rows = prepare(baseline, seen), prepare(baseline, without)
    for n in range(len(seen)):
        densities = []
        for own, each in zip(filters, rows, strict=True):
            null.advance(own, known, each, n)
            density = 0.0
            for axis in np.flatnonzero(np.isfinite(each.value[n])):
                before = null.predictive(own, int(axis))
                reading, variance = float(each.value[n, axis]), float(each.variance[n, axis])
                one = null.take(own, int(axis), reading, each.nuisance[n, axis], variance)
                density += before.log_density(one.value**2) - math.log(one.sigma)
            densities.append(density)
        gains[rows[0].order[n]] = densities[1] - densities[0]
    return gains
