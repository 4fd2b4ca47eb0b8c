"""Periods of waves in time: which of them the readings show, beside a model and a noise.

A wave's phase may hold from session to session. Or it wanders, and is free in stretches of a few
periods: then the beam swings along one line, for one thing moves it, and a session must hold two
periods, for each is seen alone. Both are looked for by sums over readings, no column for each
frequency.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import DEG, Array, Codes
from pyport.diagnosis.shapes.forms import HARMONICS
from pyport.diagnosis.shapes.scans import Peak, Scan, View, stretches_of
from pyport.thresholds import (
    ANOTHER_PERIOD,
    CONVINCING,
    PERIODS_FREE,
)

#: A wandering period is tried at steps of this share.
STEP = 0.04
#: Frequencies tried in one over the length of a session, and in one over that of the campaign.
OVERSAMPLED = 4
#: Longest stretch [s] that is searched as one, a day, as most sessions are shorter; or two of the
#: shortest periods.
LONGEST_PIECE_S = 86400.0
#: Frequencies times sessions at which coherence through a campaign is given up: it is too long.
MOST_PHASES = 50_000_000
#: Periods of a wave whose phase holds that are looked at closely.
MOST_PERIODS = 12
#: Share of its gain that a wave may lack there: a twentieth between two frequencies, as much by
#: sums that know the amplitudes in the mean only.
LOST = 0.1
#: Periods of a profile that are tried for one of a sine: its shortest waves turn faster.
FINER = 2
#: Size at which all profiles are looked at, and how many of them at every size.
USUAL_SIZE, MOST_PROFILES = 30.0, 50
#: Sizes of what wanders, or of a profile, that are tried, over what it is determined to.
_SIZES = np.geomspace(0.02, 1e3, 16)[:, None, None]


def peaks_of(scan: Scan, views: Sequence[View]) -> list[list[Peak]]:
    """Return the best period of each kind beside each noise."""
    held = [_held(scan, view) for view in views]
    return [[one, *others] for one, others in zip(_wandering(scan, views), held, strict=True)]


def _held(scan: Scan, view: View) -> list[Peak]:
    """Return the best period of a sine whose phase holds, and of what repeats in any form.

    None where a campaign is too long. Sines beyond the longest period take part, so that what they
    do is not given to a shorter one.
    """
    found = _spectrum(scan, view)
    if found is None:
        return []
    return [highest(scan, found.frequency, found.gain, found.waves), *_repeating(scan, found)]


@dataclass(frozen=True)
class _Spectrum:
    """What readings say of waves whose phase holds.

    Attributes
    ----------
    frequency
        Evenly spaced, rising, the first half a step above zero [1/s], shape (F,).
    squares, information
        Of the sums of the readings times a wave in each axis, and what is known of either of its
        amplitudes, zero where there is nothing; shape (F, 2).
    """

    frequency: Array
    squares: Array
    information: Array

    @property
    def gain(self) -> Array:
        """Return what a wave of each frequency gains, shape (F,)."""
        known = self.information > 0
        each = np.where(known, self.squares / np.where(known, self.information, 1.0), 0.0)
        return np.asarray(each.sum(axis=1))

    @property
    def waves(self) -> int:
        """Return the number of amplitudes that a wave has."""
        return 2 * int(self.information.any(axis=0).sum())


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


def _repeating(scan: Scan, found: _Spectrum) -> list[Peak]:
    """Return the best period of a profile of any form: sums over harmonics, as for pulsars.

    The m-th is expected to be smaller by m, so that a profile is as rough as a random walk. One
    beyond the longest period would take all of a drift.
    """
    step = float(found.frequency[1] - found.frequency[0])
    turns: Array = np.arange(1 / (scan.longest * step), len(found.frequency) / 2, 1 / FINER)
    if len(turns) == 0:
        return []
    some = turns[np.argsort(-_profiles(found, turns, USUAL_SIZE))[:MOST_PROFILES]]
    evidence = np.max([_profiles(found, some, float(size)) for size in _SIZES.flat], axis=0)
    period = 1 / (float(some[np.argmax(evidence)]) * step)
    # Of as many periods as the harmonics are apart, in either axis or in both.
    choices = scan.coherent * HARMONICS * (2 ** len(np.unique(scan.is_y)) - 1)
    return [Peak(period, float(evidence.max()), choices, harmonics=HARMONICS)]


def _profiles(found: _Spectrum, turns: Array, size: float) -> Array:
    """Return the evidence of profiles that come back so often (P,), each wave of some size.

    Frequencies are in steps of the spectrum, the size is over what a wave is determined to.
    """
    evidence = np.zeros(len(turns))
    variance = size / max(float(found.information.max()), 1e-300)
    for order in range(1, HARMONICS + 1):
        place = np.round(order * turns - 0.5).astype(np.intp)
        there = place < len(found.frequency)
        power = variance / order**2 * found.information[place[there]]
        gained = variance / order**2 * found.squares[place[there]] / (1 + power)
        evidence[there] += (gained - 2 * np.log1p(power)).sum(axis=1)
    return evidence


def _spectrum(scan: Scan, view: View) -> _Spectrum | None:
    """Return what readings say of waves of every frequency; None where there are too many.

    Within a day or a session neighbouring frequencies differ by less than a quarter of a turn: the
    sums of each at a coarse frequency, turned, are those at the fine ones between.
    """
    whole, longest = max(float(np.ptp(scan.time)), 1.0), max(LONGEST_PIECE_S, 2 * scan.shortest)
    day = np.floor((scan.time - scan.begin[scan.session]) / longest).astype(np.intp)
    piece = np.unique(scan.session * (day.max() + 1) + day, return_inverse=True)[1]
    count = int(piece.max()) + 1
    middle = np.bincount(piece, scan.time) / np.bincount(piece)
    from_middle = scan.time - middle[piece]
    step = 1 / (OVERSAMPLED * min(float(scan.length.max()), longest))
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
    return _Spectrum(
        (coarse[:, None] + fine).ravel(),
        squares.swapaxes(0, 1).reshape(-1, 2),
        np.repeat(np.where(known, information, 0.0), len(fine), axis=0),
    )


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


def near_best(scan: Scan, view: View) -> list[float]:
    """Return periods of a wave whose phase holds that gain nearly as much as the best."""
    found = _spectrum(scan, view)
    if found is None:
        return []
    frequency, gain = found.frequency, found.gain
    high = np.flatnonzero((gain[1:-1] >= gain[:-2]) & (gain[1:-1] > gain[2:])) + 1
    least = (1 - LOST) * gain.max() - 2 * CONVINCING
    high = high[(frequency[high] >= 1 / scan.longest) & (gain[high] > least)]
    best = high[np.argsort(-gain[high])][:MOST_PERIODS]
    return [1 / float(one) for one in frequency[best]]
