"""Periods of waves in time: which of them the readings show, beside a model and a noise.

A wave's phase may hold from session to session. Or it wanders, and is free in stretches of a few
periods: then the beam swings along one line, for one thing moves it, and a session must hold two
periods, for each is seen alone. Both are looked for by sums over readings, no column for each
frequency.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pyport.angles import DEG, Array, Codes
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.searching.confirming import beside_model
from pyport.noise.covariance import Covariance
from pyport.recordings.sky import clock
from pyport.thresholds import (
    ANOTHER_PERIOD,
    CONVINCING,
    ENOUGH_SQUARES,
    PERIODS_ALONE,
    PERIODS_FREE,
    SHORTEST_PERIOD_S,
    SHORTEST_STEPS,
)

#: A wandering period is tried at steps of this share.
STEP = 0.04
#: Lines [deg] along which the beam may swing, from across toward along elevation.
DIRECTIONS_DEG = np.arange(0.0, 180.0, 22.5)
#: Frequencies tried in one over the length of a session, and in one over that of the campaign.
OVERSAMPLED = 4
#: Longest stretch [s] that is searched as one: a day, as most sessions are shorter.
LONGEST_PIECE_S = 86400.0
#: Frequencies times sessions at which coherence through a campaign is given up: it is too long.
MOST_PHASES = 50_000_000
#: Periods at which the noise's spectrum is looked at.
SPECTRUM = 16
#: Periods of a wave whose phase holds that are looked at closely.
MOST_PERIODS = 6
#: Sizes of a wandering wave that are tried, over what a stretch determines it to.
_SIZES = np.geomspace(0.02, 1e3, 16)[:, None, None]


@dataclass(frozen=True)
class Peak:
    """The best period of a kind, in the unit of its scan.

    `evidence` is twice the log of how much likelier the data are with it, its choice among
    `choices` periods not yet paid. `direction_deg` is the line of one whose phase wanders.
    """

    period: float
    evidence: float
    choices: float
    direction_deg: float | None = None

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
        """Return ascending periods (F,), and the cosine and the sine of each, shape (m, 2 F)."""
        periods = np.geomspace(self.shortest, self.longest, SPECTRUM)
        phase = 2 * np.pi * self.time[:, None] / periods
        waves = np.concatenate([np.cos(phase), np.sin(phase)], axis=1)
        return periods, self.sign[:, None] * waves


def scan_of(setup: Problem, *, reversing: bool) -> Scan | None:
    """Return the readings for a search; None where no period could be seen.

    `reversing`: for waves that change their sign where the mount has turned over.
    """
    at = setup.recordings.at
    if setup.blocks.antennas > 1 or "time" not in at:
        return None
    time = clock(at)[setup.stack.row]
    if len(time) < ENOUGH_SQUARES or not np.isfinite(time).all():
        return None
    time = time - time.min()
    session = np.unique(setup.session, return_inverse=True)[1]
    begin, end = np.full(session.max() + 1, np.inf), np.zeros(session.max() + 1)
    np.minimum.at(begin, session, time)
    np.maximum.at(end, session, time)
    length = end - begin
    moments = np.diff(np.unique(time))
    step = float(np.median(moments)) if len(moments) else 0.0
    shortest = max(SHORTEST_PERIOD_S, SHORTEST_STEPS * step)
    longest = float(np.median(length)) / (1.0 if len(length) > 1 else PERIODS_ALONE)
    if longest < 2 * shortest:
        return None
    is_y = setup.stack.is_y.astype(np.intp)
    side = np.broadcast_to(at.side if reversing else 1.0, len(at))
    return Scan(time, session, is_y, side[setup.stack.row], begin, length, shortest, longest)


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


def view_of(setup: Problem, scan: Scan, noise: Covariance, chosen: Sequence[Chosen]) -> View:
    """Return the readings beside a model and what is chosen, and beside a noise."""
    model = setup.expanded((*setup.base, *chosen))
    periods, waves = scan.waves
    data = np.concatenate([model, setup.residual[:, None], waves], axis=1)
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


def peaks_of(scan: Scan, views: Sequence[View]) -> list[list[Peak]]:
    """Return the best period of each kind beside each noise."""
    held = [_held(scan, view) for view in views]
    return [
        [one] if other is None else [one, other]
        for one, other in zip(_wandering(scan, views), held, strict=True)
    ]


def _held(scan: Scan, view: View) -> Peak | None:
    """Return the best period of a wave whose phase holds; None where a campaign is too long.

    Periods beyond the longest take part, so that what they do is not given to a shorter one.
    """
    found = _gains(scan, view)
    if found is None:
        return None
    return highest(scan, *found)


def highest(scan: Scan, frequency: Array, gain: Array, waves: int) -> Peak:
    """Return the period of the highest gain (F,) of a number of amplitudes, with its price."""
    best = int(np.argmax(gain))
    most = max(float(gain[best]) / waves, 1.0)
    # Of equal information the likeliest variance has a closed form.
    evidence = waves * (most - 1 - np.log(most))
    # Among frequencies that lie close a high peak is met more often than among independent ones,
    # by the root of its height (Baluev 2008, MNRAS 385, 1279).
    choices = scan.coherent * float(np.sqrt(max(float(gain[best]) / 2, 1.0)))
    return Peak(1 / float(frequency[best]), evidence, choices)


def _gains(scan: Scan, view: View) -> tuple[Array, Array, int] | None:
    """Return frequencies [1/s], what a wave of each gains, and the number of its amplitudes.

    Within a day or a session neighbouring frequencies differ by less than a quarter of a turn: the
    sums of each at a coarse frequency, turned, are those at the fine ones between.
    """
    whole = max(float(np.ptp(scan.time)), 1.0)
    day = np.floor((scan.time - scan.begin[scan.session]) / LONGEST_PIECE_S).astype(np.intp)
    piece = np.unique(scan.session * (day.max() + 1) + day, return_inverse=True)[1]
    count = int(piece.max()) + 1
    middle = np.bincount(piece, scan.time) / np.bincount(piece)
    from_middle = scan.time - middle[piece]
    step = 1 / (OVERSAMPLED * min(float(scan.length.max()), LONGEST_PIECE_S))
    coarse: Array = np.arange(0.5 * step, 1 / scan.shortest + step, step)
    count_fine = int(np.ceil(whole * OVERSAMPLED * step))
    fine: Array = ((np.arange(count_fine) + 0.5) / count_fine - 0.5) * step
    if len(fine) * len(coarse) * count > MOST_PHASES:
        return None
    sums = _sums(view.pull, 2 * piece + scan.is_y, from_middle, coarse, 2 * count)
    sums = sums.reshape(len(coarse), count, 2) * np.exp(
        -2j * np.pi * coarse[:, None, None] * middle[:, None]
    )
    turned = np.exp(-2j * np.pi * fine[:, None] * middle)
    squares = np.abs(np.tensordot(turned, sums, axes=([1], [1]))) ** 2
    information = view.at(1 / coarse).reshape(-1, 2, len(coarse)).sum(axis=0).T
    known = information > 1e-9 * information.max()
    gain = np.where(known, squares / np.where(known, information, 1.0), 0.0).sum(axis=2)
    waves = 2 * int(known.any(axis=0).sum())
    return (fine[:, None] + coarse).ravel(), gain.ravel(), waves


def _sums(pull: Array, group: Codes, time: Array, frequency: Array, groups: int) -> Array:
    """Return sums of a pull times waves of evenly spaced frequencies (F,), (F, groups), complex."""
    order = np.argsort(group, kind="stable")
    there, starts = np.unique(group[order], return_index=True)
    out = np.zeros((len(frequency), groups), complex)
    turn = np.exp(-2j * np.pi * (frequency[1] - frequency[0]) * time[order])
    wave = pull[order] * np.exp(-2j * np.pi * frequency[0] * time[order])
    for n in range(len(frequency)):
        out[n, there] = np.add.reduceat(wave, starts)
        wave *= turn
    return out


def _wandering(scan: Scan, views: Sequence[View]) -> list[Peak]:
    """Return the best period of a wave whose phase is free in stretches of some periods.

    And its line. Periods beyond the longest that is shown take part here, too.
    """
    logs = np.arange(np.log(scan.shortest), np.log(scan.longest), STEP)
    periods = np.exp(logs)
    own = 2 * scan.session + scan.is_y
    readings = np.maximum(np.bincount(own, minlength=2 * len(scan.length)), 1)[:, None]
    each = [view.at(periods) / readings for view in views]
    lines = scan.lines_deg
    line = np.stack([np.cos(lines * DEG), np.sin(lines * DEG)])
    evidence = np.empty((len(views), len(periods), len(lines)))
    for n, period in enumerate(periods):
        stretch, count = stretches_of(scan, period, PERIODS_FREE)
        group = 2 * stretch + scan.is_y
        wave = np.exp(-2j * np.pi * scan.time / period)
        for k, view in enumerate(views):
            pulled = view.pull * wave
            sums = np.bincount(group, pulled.real, 2 * count) + 1j * np.bincount(
                group, pulled.imag, 2 * count
            )
            squares = np.abs(sums.reshape(count, 2) @ line) ** 2
            information = np.bincount(group, each[k][own, n], 2 * count).reshape(count, 2) @ line**2
            size = _SIZES / max(float(information.max()), 1e-300)
            power = size * information
            gained = size * squares / (1 + power) - 2 * np.log1p(power)
            evidence[k, n] = gained.sum(axis=1).max(axis=0)
    choices = max(1.0, float(np.ptp(logs)) / ANOTHER_PERIOD) * len(lines)
    found = [(np.unravel_index(one.argmax(), one.shape), float(one.max())) for one in evidence]
    return [
        Peak(float(periods[period]), worth, choices, float(lines[direction]))
        for (period, direction), worth in found
    ]


def stretches_of(scan: Scan, period_s: float, periods: float) -> tuple[Codes, int]:
    """Return the stretch of each reading, of so many periods, and the number of stretches."""
    parts = np.maximum(1, np.round(scan.length / (periods * period_s))).astype(np.intp)
    first = np.cumsum([0, *parts])
    within = (scan.time - scan.begin[scan.session]) / np.maximum(scan.length, 1.0)[scan.session]
    part = np.minimum((within * parts[scan.session]).astype(np.intp), parts[scan.session] - 1)
    return first[scan.session] + part, int(first[-1])


def near_best(scan: Scan, view: View) -> list[float]:
    """Return periods of a wave whose phase holds that gain nearly as much as the best."""
    found = _gains(scan, view)
    if found is None:
        return []
    frequency, gain, _ = found
    order = np.argsort(frequency)
    frequency, gain = frequency[order], gain[order]
    high = np.flatnonzero((gain[1:-1] >= gain[:-2]) & (gain[1:-1] > gain[2:])) + 1
    high = high[(frequency[high] >= 1 / scan.longest) & (gain[high] > gain.max() - 2 * CONVINCING)]
    best = high[np.argsort(-gain[high])][:MOST_PERIODS]
    return [1 / float(one) for one in frequency[best]]
