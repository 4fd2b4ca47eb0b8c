"""Rows made ready for the watch: what each reading depends on, as columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.recordings.schema import Recordings
from pyport.watch.detection.baseline import Baseline
from pyport.watch.detection.changes import columns


@dataclass(frozen=True)
class Rows:
    """n rows of one antenna in the order of time."""

    #: Offsets less what the model gives before any fit [rad], (n, 2); NaN where not measured.
    value: Array
    off: Array  #: offsets against the model of the past [rad], (n, 2)
    #: `nuisance`, `change`: what one of each nuisance, and of each changed coefficient, does to
    #: either axis, (n, 2, D) and (n, 2, C).
    nuisance: Array
    change: Array
    variance: Array  #: white variance of the readings [rad^2], (n, 2)
    clock: Array  #: time [s since 1970], or the number of the row where none is recorded
    timed: bool  #: whether the clock is a time
    labels: dict[str, list[str]]  #: session and source of each row
    #: `az`, `el`: where [rad].
    az: Array
    el: Array
    order: NDArray[np.intp]  #: which of the recordings each row is

    def __len__(self) -> int:
        """Return n."""
        return len(self.clock)


def prepare(baseline: Baseline, recordings: Recordings, home: Array | None = None) -> Rows:
    """Return rows of the baseline's antenna as the watch takes them, ordered by time.

    `home` (D,) holds the states that make up the model of the past.
    """
    at = recordings.at
    clock = np.asarray(at.columns.get("time", recordings.line), float)
    timed = "time" in at and bool(np.isfinite(clock).all())
    if not timed:
        clock = recordings.line.astype(float)
    order = np.argsort(clock, kind="stable")
    recordings, clock = recordings.take(order), clock[order]
    given_x, given_y = baseline.model.offsets(recordings.at)
    value = np.stack([recordings.x - given_x, recordings.y - given_y], axis=1)
    nuisance = np.stack(baseline.design(recordings.at), axis=1)
    off = value if home is None else value - np.sum(nuisance * home, axis=2)
    value = value.copy()
    change = np.stack(columns([one.effect for one in baseline.changes], recordings.at), axis=1)
    variance = baseline.variance(recordings)
    if baseline.coupling:
        # what the axes share is taken out of elevation where both were measured
        both = np.isfinite(value).all(axis=1)
        slope = baseline.coupling * np.sqrt(variance[both, 1] / variance[both, 0])
        value[both, 1] -= slope * value[both, 0]
        for part in (nuisance, change):
            part[both, 1] -= slope[:, None] * part[both, 0]
        variance[both, 1] *= 1 - baseline.coupling**2
    names = ("session", "source")
    labels = {name: list(map(str, recordings.label(name).tolist())) for name in names}
    az, el = recordings.at.az, recordings.at.el
    return Rows(value, off, nuisance, change, variance, clock, timed, labels, az, el, order)
