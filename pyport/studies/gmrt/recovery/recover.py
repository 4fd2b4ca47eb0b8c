"""Garbled rows put right: alignment and expectation in turns until they agree.

Every column's offsets run smoothly from scan to scan, forward and reverse
apart; so the rows that are whole tell what a garbled row should read, the
rows put right tell it better, and so on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pyport.angles import Array
from pyport.studies.gmrt.recovery.printed import NO_PEAK, alignment, expected_offsets

#: Turns of expectation and alignment; the cells vouched for stand still after four.
TURNS = 6

#: A cell counts in the expectation of others from this probability on.
COUNTS = 0.3

#: A sign is lost where the other one is nearer to the published curve by this [arcmin].
SIGN_MATTERS = 3

#: How often a cell lost or gained its minus in print.
SIGN_GOES = 0.02

#: An offset that no antenna of this array has when it sees the source [arcmin].
LARGEST_ARCMIN = 60

#: Bounds of an antenna's scatter about its expectation [arcmin].
LEAST_SPREAD, MOST_SPREAD = 0.7, 2.5


@dataclass(frozen=True)
class Numbers:
    """The rows of a table as numbers; r rows of up to m cells."""

    offset: Array  #: offsets [arcmin], NaN where a cell is no number, shape (r, m)
    cells: NDArray[np.int64]  #: how many cells each row has, shape (r,)
    #: `hour_angle_h`, `direction`, `scan`, `stretch`: of each row, shape (r,); `stretch` counts the
    #: settings of the offsets.
    hour_angle_h: Array
    direction: Array
    scan: NDArray[np.int64]
    stretch: NDArray[np.int64]
    #: What each column's published curve gives [arcmin], NaN where there is none, shape (r, n). It
    #: settles signs that were lost, nothing else.
    published: Array


@dataclass(frozen=True)
class Recovered:
    """Where each cell belongs; r rows of up to m cells, n columns."""

    column: NDArray[np.intp]  #: the column that the cell most probably is of, shape (r, m)
    belongs: Array  #: the probability that it is, shape (r, m)
    #: The probability that it is and that it reads as the scans around it lead to expect, shape (r,
    #: m).
    trusted: Array
    expected: Array  #: what the columns should read [arcmin], shape (r, n)


def recover(table: Numbers) -> Recovered:
    """Return where the cells of a table with so many columns belong."""
    offset, weight = _whole_rows(table)
    background = _background(table.offset)
    failing = np.clip(1 - weight.mean(axis=0), 0.03, 0.97)
    for _ in range(TURNS):
        expected = expected_offsets(
            offset,
            weight,
            hour_angle_h=table.hour_angle_h,
            direction=table.direction,
            scan=table.scan,
            stretch=table.stretch,
        )
        spread = _spread(offset, expected)
        good = (1 - failing) * _likelihood(table.offset, expected, spread)
        turned = SIGN_GOES * _likelihood(-table.offset, expected, spread)
        either = good + turned + failing * _no_peak(table.offset)[..., None]
        belongs = alignment(either, background, table.cells)
        belongs *= (np.arange(table.offset.shape[1]) < table.cells[:, None])[..., None]
        trusted = belongs * good / either
        failing = 1 - (trusted.sum(axis=(0, 1)) + 0.5) / (belongs.sum(axis=(0, 1)) + 1)
        failing = np.clip(failing, 0.02, 0.98)
        seen = belongs * (good + turned) / either
        cell = seen.argmax(axis=1)[:, None]
        weight = np.take_along_axis(seen, cell, axis=1)[:, 0]
        weight = np.where(weight > COUNTS, weight, 0)
        offset = np.take_along_axis(table.offset, cell[:, 0], axis=1)
        offset = np.where(weight > 0, _signed(offset, table.published), np.nan)
    column = belongs.argmax(axis=2)
    pick = column[..., None]
    return Recovered(
        column,
        np.take_along_axis(belongs, pick, axis=2)[..., 0],
        np.take_along_axis(trusted, pick, axis=2)[..., 0],
        expected,
    )


def _whole_rows(table: Numbers) -> tuple[Array, Array]:
    """Return the offsets by column, and their weights, of the rows that have a cell for each."""
    columns = table.published.shape[1]
    offset = np.full(table.published.shape, np.nan)
    whole = table.cells == columns
    offset[whole] = table.offset[whole, :columns]
    weight = np.where(np.abs(offset) < LARGEST_ARCMIN, 1.0, 0.0)
    return _signed(offset, table.published), weight


def _signed(offset: Array, published: Array) -> Array:
    """Return offsets with the sign that the published curve leaves no doubt about.

    Only what others should read is made of them; a cell itself is never mended.
    """
    return np.where(sign_lost(offset, published), -offset, offset)


def sign_lost(offset: ArrayLike, published: ArrayLike) -> NDArray[np.bool_]:
    """Tell where the other sign would be nearer to the published curve, beyond doubt [arcmin]."""
    offset, published = np.asarray(offset, float), np.asarray(published, float)
    return np.abs(offset - published) > np.abs(offset + published) + SIGN_MATTERS


def _background(offset: Array) -> Array:
    """Return how often the table has a cell like each, from anywhere."""
    number = np.isfinite(offset)
    place = np.clip(np.nan_to_num(offset), -1000, 1000).astype(int) + 1000
    count = np.bincount(place[number], minlength=2001).astype(float)
    kernel = np.exp(-0.5 * (np.arange(-6, 7) / 1.5) ** 2)
    smooth = np.convolve(count, kernel / kernel.sum(), "same")
    share = 0.9 * smooth / smooth.sum() + 0.1 / len(smooth)
    return np.where(number, share[place], 0.01)


def _likelihood(offset: Array, expected: Array, spread: Array) -> Array:
    """Return the density of each cell about each column's expectation: Student's t, 3 degrees."""
    t = (offset[:, :, None] - expected[:, None, :]) / spread
    density = 2 / (np.pi * np.sqrt(3)) / (1 + t**2 / 3) ** 2 / spread
    return np.nan_to_num(density)


def _spread(offset: Array, expected: Array) -> Array:
    """Return each column's scatter about its expectation [arcmin]."""
    apart = np.abs(offset - expected)
    few = np.isfinite(apart).sum(axis=0) < 6
    middle = np.ma.median(np.ma.masked_invalid(apart), axis=0).filled(MOST_SPREAD)
    return np.where(few, MOST_SPREAD, np.clip(1.48 * middle, LEAST_SPREAD, MOST_SPREAD))


def _no_peak(offset: Array) -> Array:
    """Return the density of each cell where an antenna found no peak: marks, else anything."""
    size = np.abs(np.nan_to_num(offset))
    anything = np.where(size > LARGEST_ARCMIN, 0.002, 0.0008)
    marked = np.where(np.isin(size, NO_PEAK), 0.25, anything)
    return np.where(np.isfinite(offset), marked, 0.05)
