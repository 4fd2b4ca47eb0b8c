"""The watch of one antenna: what it consists of, and where its states stand."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import log

import numpy as np
from scipy.special import logsumexp

from pyport.angles import Array, Codes
from pyport.watch.detection import detector
from pyport.watch.detection.baseline import Baseline
from pyport.watch.detection.composite import Composite, log_omitted
from pyport.watch.detection.detector import Detector, Layout
from pyport.watch.detection.null import Null


@dataclass
class Slot:
    """A confirmed alarm whose change is a further state of the filter, or of the scatter."""

    alarm: int  #: its number
    change: int  #: which of the changes, or which of the spreads behind them
    #: Of the change to none: of a spread it is kept here, of a change it follows from the state.
    log_ratio: float = 0.0
    reference: float = 0.0  #: scale, or share of outliers, before


@dataclass
class Antenna:
    """The watch of one antenna."""

    #: `baseline`, `layout`: what does not change.
    baseline: Baseline
    layout: Layout
    #: `nulls`, `detector`: the running state.
    nulls: Composite
    detector: Detector
    threshold: float  #: logarithm of what the mixture must reach
    #: Confirmed alarms, those with states of the filter in their order first.
    slots: list[Slot] = field(default_factory=list)
    pending: int | None = None  #: the alarm that is being named, its number
    rows: int = 0  #: pointings taken in
    #: What was known of standing effects when the pending alarm was raised.
    unchanged_mean: Array = field(default_factory=lambda: np.zeros(0))
    unchanged_covariance: Array = field(default_factory=lambda: np.zeros(0))
    #: The states that make up the model of the past, (D,).
    home: Array = field(default_factory=lambda: np.zeros(0))
    #: Offsets of the last row against that model, and its white sigma [rad], (2, 2).
    left: Array = field(default_factory=lambda: np.full((2, 2), np.nan))

    @property
    def null(self) -> Null:
        """Return the filter that the detector follows."""
        return self.nulls.levels[0].null

    @property
    def standing(self) -> Detector:
        """Return the effects that may have stood all along."""
        return self.nulls.levels[0].standing

    @property
    def white(self) -> Array:
        """Return the white scatter of either axis as it is now [rad], (2,)."""
        return np.sqrt(self.baseline.white * self.null.scale)

    @property
    def evidence(self) -> float:
        """Return the logarithm of the mixture."""
        return detector.evidence(self.detector, self.layout, self.nulls.log_ratio)

    @property
    def omitted(self) -> float:
        """Return the logarithm of the mixture of what may have stood all along."""
        return float(logsumexp(log_omitted(self.nulls, self.layout)))


def begin(
    baseline: Baseline, placed: Layout, nulls: Composite, pointings_per_false_alarm: float
) -> Antenna:
    """Return the watch at its beginning; the threshold keeps one false alarm in so many."""
    first = nulls.levels[0]
    home = first.null.mean * (first.states.of == "model")
    empty = detector.fresh(placed, first.null)
    return Antenna(baseline, placed, nulls, empty, log(pointings_per_false_alarm), home=home)


def state_columns(watch: Antenna) -> list[Codes]:
    """Return the columns of the changes that are states, in the order of those."""
    members = watch.layout.members
    return [columns_of(watch, slot.change) for slot in watch.slots if slot.change < members]


def columns_of(watch: Antenna, change: int) -> Codes:
    """Return the columns of a change among all coefficients."""
    return watch.layout.place[change, : len(watch.baseline.changes[change].prior)]


def first_state(watch: Antenna, slot: Slot) -> int:
    """Return where the states of a slot begin among all."""
    before = watch.slots[: watch.slots.index(slot)]
    behind = sum(len(watch.baseline.changes[one.change].prior) for one in before)
    return len(watch.nulls.levels[0].states) + behind
