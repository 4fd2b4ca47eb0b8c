"""What noise is fitted to, the series of one antenna and axis, and what it is found to be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from pyport.angles import Array, Codes
from pyport.noise.pointings import pointings
from pyport.pointing.kernel import Columns
from pyport.recordings.schema import Recordings, Stack, group
from pyport.recordings.sky import clock


@dataclass(frozen=True)
class Series:
    """The stacked numbers of one antenna and axis: the unit that noise is fitted to.

    Attributes
    ----------
    rows
        Their indices in the stack, shape (m,), ordered by time.
    pointing
        For each the number of its pointing within the series, in the order of their first
        readings; readings of one pointing share it, shape (m,).
    time
        Time of each pointing [s since the first], or its place in the order of the rows where no
        times are recorded; None where any is unknown.
    number
        The number of each pointing among all pointings of the recordings.
    antenna, is_y
        What the series is of.
    """

    rows: Codes
    pointing: Codes
    time: Array | None
    number: Codes
    antenna: str
    is_y: bool

    @cached_property
    def span(self) -> float:
        """Return the time from the first pointing to the last [s], 0 where any is unknown."""
        return 0.0 if self.time is None else float(np.ptp(self.time))

    @cached_property
    def readings(self) -> Codes:
        """Return how many readings each pointing has."""
        return np.bincount(self.pointing)

    @cached_property
    def alone(self) -> bool:
        """Tell whether each reading is a pointing."""
        return bool(self.readings.max() == 1)

    @cached_property
    def first(self) -> Codes:
        """Return the index in the stack of the first reading of each pointing."""
        return self.rows[np.unique(self.pointing, return_index=True)[1]]

    @cached_property
    def sums(self) -> csr_array:
        """Return what sums the readings of each pointing, (p, m)."""
        rows = self.pointing, np.arange(len(self.rows))
        return csr_array((np.ones(len(self.rows)), rows))

    @cached_property
    def lone(self) -> NDArray[np.bool_]:
        """Tell which readings are the only ones of their pointings, shape (m,)."""
        return np.asarray(self.readings[self.pointing] == 1)

    def turns(self, memory: float) -> float:
        """Return how many independent deviations of a drift of some memory [s] the series saw.

        The mean square of one over a time T scatters as that of T / memory deviations do; a gap
        that it forgets in is one memory long.
        """
        if self.time is None or not len(self.time):
            return 1.0
        return 1.0 + float(np.minimum(np.diff(np.sort(self.time)), memory).sum()) / memory


@dataclass(frozen=True)
class Noise:
    """Fitted noise of one series [rad, s].

    Attributes
    ----------
    within, between
        Scatter of readings about their pointing's mean, and of pointings.
    drifts
        Amplitude and correlation time of each Ornstein-Uhlenbeck process: where
        the recordings allow several, each stands there as likely as it is.
    dof
        What the scale was estimated from.
    how
        `replicates` or `reml`.
    tail
        By what factor `between` was widened because the tails are heavy.
    centred
        Whether what drifts is counted from its mean: what never changes is no drift.
    """

    within: float
    between: float
    drifts: tuple[tuple[float, float], ...] = ()
    dof: float = np.inf
    how: str = "reml"
    tail: float = 1.0
    centred: bool = False

    @property
    def drift(self) -> float:
        """Return the rms of all that drifts [rad]."""
        return float(np.sqrt(sum(amplitude**2 for amplitude, _ in self.drifts)))

    @property
    def time_s(self) -> float | None:
        """Return the correlation time, averaged over what drifts; None where nothing does [s]."""
        if self.drift == 0:
            return None
        power = np.array([amplitude**2 for amplitude, _ in self.drifts])
        return float(np.exp(power @ np.log([time for _, time in self.drifts]) / power.sum()))

    def shown_within(self, span: float) -> Noise:
        """Return the noise with what shows of its drifts within a span [s], in none no drift.

        A longer memory becomes the span, its variance less by as much: from one reading to the
        next it moves as before. To weigh by; `about_mean` says how large drifts look.
        """
        drifts = tuple(
            (amplitude * float(np.sqrt(min(1.0, span / memory))), min(memory, span))
            for amplitude, memory in self.drifts
            if span > 0
        )
        return replace(self, drifts=drifts)

    def about_mean(self, span: float) -> Noise:
        """Return the noise with its drifts as large as they look: about their mean in a span [s].

        To report; where a memory is far longer that is a third of the variance that
        `shown_within` weighs by. Of unit variance and memory span / x the variance is
        1 - 2 / x + 2 (1 - exp(-x)) / x^2.
        """
        drifts = []
        for amplitude, memory in self.drifts if span > 0 else ():
            x = max(span / memory, 1e-3)  # Less is lost to rounding; memories are not that long.
            share = 1 - 2 / x - 2 * float(np.expm1(-x)) / x**2
            drifts.append((amplitude * float(np.sqrt(share)), min(memory, span)))
        return replace(self, drifts=tuple(drifts))

    @property
    def floor(self) -> float:
        """Return the scatter of a single reading about the true curve [rad]."""
        return float(np.sqrt(self.within**2 + self.between**2 + self.drift**2))


def series(recordings: Recordings, stack: Stack) -> list[Series]:
    """Split the stack into antennas and axes, ordered by time where there is one."""
    antennas, names = group(recordings, ("antenna",))
    sessions, _ = group(recordings, ("session",))
    time = clock(recordings.at)
    pointing = pointings(recordings)
    found = []
    for antenna, name in enumerate(names):
        for is_y in (False, True):
            rows = np.flatnonzero((antennas[stack.row] == antenna) & (stack.is_y == is_y))
            if len(rows) == 0:
                continue
            of_row = stack.row[rows]
            timed = bool(np.isfinite(time[of_row]).all())
            first = time[of_row] if timed else sessions[of_row]
            rows = rows[np.lexsort((pointing[of_row], sessions[of_row], first))]
            found.append(_ordered(rows, stack.row[rows], pointing, time, name[0], is_y=is_y))
    return found


def _ordered(
    rows: Codes, of_row: Codes, pointing: Codes, time: Array, antenna: str, *, is_y: bool
) -> Series:
    """Put the pointings of a series in the order of their rows."""
    number, first, inverse = np.unique(pointing[of_row], return_index=True, return_inverse=True)
    order = np.empty(len(first), np.intp)
    order[np.argsort(first, kind="stable")] = np.arange(len(first))
    when = time[of_row][np.sort(first)]
    known = bool(np.all(np.isfinite(when)))
    return Series(
        rows,
        order[inverse],
        np.maximum.accumulate(when - when.min()) if known else None,
        number[np.argsort(first, kind="stable")],
        antenna,
        is_y,
    )


@dataclass(frozen=True)
class Departures:
    """Random departures of sessions or sources in one term, all of one variance.

    Attributes
    ----------
    term
        What departs: `azimuth tilt`, `zero in elevation`, ...
    of
        `session` or `source`.
    antenna
        Whose.
    labels
        The session or source of each column.
    columns
        Offset of each reading for a departure of one [rad/rad], shape (m, q).
    sigma
        Standard deviation of the departures [rad].
    dof
        From how many deviations it is known.
    """

    term: str
    of: str
    antenna: str
    labels: tuple[str, ...]
    columns: Array = field(repr=False)
    sigma: float = 0.0
    dof: float = np.inf

    @property
    def whose(self) -> tuple[str, str, str]:
        """Return the term, of what, and the antenna."""
        return self.term, self.of, self.antenna


@dataclass(frozen=True)
class Possible:
    """Departures that are possible, and the series that show them."""

    departures: tuple[Departures, ...]
    parts: tuple[Series, ...]

    @cached_property
    def kind(self) -> Codes:
        """Return which departures each column belongs to, shape (q,)."""
        widths = [one.columns.shape[1] for one in self.departures]
        return np.repeat(np.arange(len(widths)), widths)

    @cached_property
    def columns(self) -> Array:
        """Return the columns of all departures, shape (m, q)."""
        readings = sum(len(part.rows) for part in self.parts)
        columns = [np.zeros((readings, 0)), *(one.columns for one in self.departures)]
        return np.concatenate(columns, axis=1)

    @cached_property
    def few(self) -> tuple[Columns, ...]:
        """Return for each series those columns in its rows, without their zeros."""
        return tuple(Columns.of(self.columns[part.rows], len(self.kind)) for part in self.parts)

    @cached_property
    def shared(self) -> Array:
        """Return what all labels share, shape (m, s)."""
        found = [self.columns[:, :0]]
        for one in self.departures:
            count = len(set(one.labels))
            found.append(one.columns.reshape(len(one.columns), -1, count).sum(axis=2))
        return np.concatenate(found, axis=1)

    def sizes(self, departures: Sequence[Departures]) -> Array:
        """Return the standard deviation of what each column stands for, zero where unknown."""
        sigmas = {one.whose: one.sigma for one in departures}
        found = [sigmas.get(one.whose, 0.0) for one in self.departures]
        return np.array(found)[self.kind] if found else np.zeros(0)
