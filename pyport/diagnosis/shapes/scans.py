"""Scans: the readings as a search for periods meets them, alone and beside model and noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pyport.angles import Array, Codes
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.searching.confirming import beside_model
from pyport.noise.covariance import Covariance
from pyport.thresholds import (
    ENOUGH_SQUARES,
    PERIODS_ALONE,
    PERIODS_FREE,
    SHORTEST_PERIOD_S,
    SHORTEST_STEPS,
)

#: Lines [deg] along which the beam may swing, from across toward along elevation.
DIRECTIONS_DEG = np.arange(0.0, 180.0, 22.5)
#: Periods at which the noise's spectrum is looked at.
SPECTRUM = 16
#: The number that is hardest to come near by fractions: squares of integers times it are irregular.
GOLDEN = (1 + 5**0.5) / 2


@dataclass(frozen=True)
class Peak:
    """The best period of a kind, in the unit of its scan.

    `evidence` is twice the log of how much likelier the data are with it, its choice among
    `choices` periods not yet paid. `direction_deg` is the line of one whose phase wanders,
    `harmonics` how many one has: one of more repeats in any form.
    """

    period: float
    evidence: float
    choices: float
    direction_deg: float | None = None
    harmonics: int = 1

    @property
    def kind(self) -> tuple[bool, int]:
        """Return whether its phase wanders, and how many harmonics it has."""
        return self.wanders, self.harmonics

    @property
    def plain(self) -> bool:
        """Tell whether it is a sine whose phase holds."""
        return self.kind == (False, 1)

    @property
    def wanders(self) -> bool:
        """Tell whether its phase is free in every few periods."""
        return self.direction_deg is not None

    @property
    def worth(self) -> float:
        """Return the evidence less the price of the choice."""
        return self.evidence - 2 * float(np.log(self.choices))


@dataclass(frozen=True)
class Scan:
    """The readings of one antenna as a search for periods meets them.

    Periods of time are in seconds; of a drive, whose waves follow an angle, in degrees.

    Attributes
    ----------
    time, session, is_y
        Of each reading: time since the first, number of its session, axis; shape (m,).
    sign
        What a wave is multiplied by: -1 where it changes with the side of a pier, shape (m,).
    begin, length
        Of each session, shape (S,).
    shortest, longest
        Periods between which one is looked for.
    """

    time: Array
    session: Codes
    is_y: Codes
    sign: Array
    begin: Array
    length: Array
    shortest: float
    longest: float

    @property
    def alone(self) -> float:
        """Return the longest period that each session shows by itself."""
        return float(np.median(self.length)) / PERIODS_ALONE

    @property
    def lines_deg(self) -> Array:
        """Return the lines along which a swing may be seen: an axis alone is one."""
        measured = np.unique(self.is_y)
        return DIRECTIONS_DEG if len(measured) > 1 else np.asarray(90.0 * measured, float)

    def shows(self, peak: Peak) -> bool:
        """Tell whether sessions are long enough for a period."""
        return peak.period <= (self.alone if peak.wanders else self.longest)

    @property
    def coherent(self) -> float:
        """Return how many periods the campaign can distinguish."""
        return max(1.0, float(np.ptp(self.time)) * (1 / self.shortest - 1 / self.longest))

    @cached_property
    def waves(self) -> tuple[Array, Array]:
        """Return ascending periods (F,), and the cosine and the sine of each, shape (m, 2 F).

        Of another phase every few periods, irregularly: readings that are repeated at a multiple of
        a period meet one that holds as a constant, which is the drift's.
        """
        periods = np.geomspace(self.shortest, self.longest, SPECTRUM)
        stretch = [stretches_of(self, float(one), PERIODS_FREE)[0] for one in periods]
        jumps = np.pi * GOLDEN * np.stack(stretch, axis=1).astype(float) ** 2
        phase = 2 * np.pi * self.time[:, None] / periods + jumps
        waves = np.concatenate([np.cos(phase), np.sin(phase)], axis=1)
        return periods, self.sign[:, None] * waves


def scan_of(problem: Problem, *, reversing: bool) -> Scan | None:
    """Return the readings for a search; None where no period could be seen.

    `reversing`: for waves that change their sign where the mount has turned over.
    """
    at = problem.recordings.at
    if problem.blocks.antennas > 1 or at.times is None or len(problem.stack.row) < ENOUGH_SQUARES:
        return None
    time = at.times[problem.stack.row]
    time = time - time.min()
    session = np.unique(problem.session, return_inverse=True)[1]
    begin, end = np.full(session.max() + 1, np.inf), np.zeros(session.max() + 1)
    np.minimum.at(begin, session, time)
    np.maximum.at(end, session, time)
    length = end - begin
    # Exposures of one visit tell of one moment.
    moments = np.diff(np.sort(time[np.unique(problem.pointing, return_index=True)[1]]))
    moments = moments[moments > 0]
    step = float(np.median(moments)) if len(moments) else 0.0
    shortest = max(SHORTEST_PERIOD_S, SHORTEST_STEPS * step)
    longest = float(np.median(length)) / (1.0 if len(length) > 1 else PERIODS_ALONE)
    if longest < 2 * shortest:
        return None
    is_y = problem.stack.is_y.astype(np.intp)
    side = np.broadcast_to(at.side if reversing else 1.0, len(at))
    return Scan(time, session, is_y, side[problem.stack.row], begin, length, shortest, longest)


@dataclass(frozen=True)
class View:
    """The readings beside a model and a noise.

    Attributes
    ----------
    lack
        Minus twice the restricted log-likelihood of the noise alone.
    pull
        A column's product with this is its whitened one's with what the model leaves, shape (m,).
    log_period, information
        Logs of ascending periods, and what each session and axis knows of a wave of each: shapes
        (F,) and (2 S, F).
    """

    lack: float
    pull: Array
    log_period: Array
    information: Array

    def at(self, period_s: Array) -> Array:
        """Return the information at some periods (F,), shape (2 S, F)."""
        log = np.log(period_s)
        return np.array([np.interp(log, self.log_period, one) for one in self.information])


def view_of(problem: Problem, scan: Scan, noise: Covariance, chosen: Sequence[Chosen]) -> View:
    """Return the readings beside a model and what is chosen, and beside a noise."""
    model = problem.expanded((*problem.base, *chosen))
    periods, waves = scan.waves
    data = np.concatenate([model, problem.residual[:, None], waves], axis=1)
    white = noise.whiten(data)
    p = model.shape[1]
    lack, _, left = beside_model(noise, white[:, :p], white[:, p])
    # Half the squares of both waves: the information on either.
    power = (white[:, p + 1 :] ** 2).reshape(len(white), 2, SPECTRUM).mean(axis=1)
    series = np.resize(2 * scan.session + scan.is_y, len(white))
    information = np.zeros((2 * len(scan.length), SPECTRUM))
    np.add.at(information, series, power)
    pull = scan.sign * noise.unwhiten(left[:, None])[:, 0]
    return View(lack, pull, np.log(periods), information)


def stretches_of(scan: Scan, period_s: float, periods: float) -> tuple[Codes, int]:
    """Return the stretch of each reading, of so many periods, and the number of stretches.

    Those without any are not counted: a session with one wrong date is years long.
    """
    parts = np.maximum(1, np.round(scan.length / (periods * period_s))).astype(np.intp)
    first = np.cumsum([0, *parts])
    within = (scan.time - scan.begin[scan.session]) / np.maximum(scan.length, 1.0)[scan.session]
    part = np.minimum((within * parts[scan.session]).astype(np.intp), parts[scan.session] - 1)
    stretch = first[scan.session] + part
    held = np.zeros(int(first[-1]), np.intp)
    held[stretch] = 1
    return (np.cumsum(held) - 1)[stretch], int(held.sum())
