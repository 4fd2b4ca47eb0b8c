"""The tables as printed: rows of cells, nothing interpreted but who stands where.

A printed row of m cells and the n columns it should have are read side by
side. Each step is one of four: a cell that is its column's (MATCH), a cell
that stands in its column's place but was taken from elsewhere (FOREIGN), a
cell too many (EXTRA), a column that lost its cell (LOST). Sums over all ways
through (forward and backward) give the probability that cell i is column j's.
Durbin, Eddy, Krogh & Mitchison 1998, Biological Sequence Analysis, ch. 4.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array

FOLDER = Path(__file__).parent / "printed"

#: An offset as the tables print it: a sign and three digits.
OFFSET = re.compile(r"[+-]\d{3}")

#: An antenna's name.
LABEL = re.compile(r"[CESW]\d\d")

#: Numbers that stand for "no peak found".
NO_PEAK = (999, 99)


@dataclass(frozen=True)
class Row:
    """A printed row: its number below the titles (from 1), its first cells and its offsets."""

    number: int
    head: tuple[str, ...]
    offsets: tuple[str, ...]

    def column(self, position: int) -> int:
        """Return the printed column (from 1) of an offset, counted with the head's cells."""
        return len(self.head) + position + 1


def lines(table: int) -> list[list[str]]:
    """Return the cells of each line of a table, as printed."""
    text = (FOLDER / f"table_{table}.tsv").read_text("utf-8")
    return [line.split("\t") for line in text.splitlines()]


def day(table: int) -> tuple[Row, ...]:
    """Return the rows of one of the tables 14 to 17: hour angle, elevation, then offsets."""
    body = lines(table)[1:]
    return tuple(Row(n, tuple(row[:2]), tuple(row[2:])) for n, row in enumerate(body, 1))


def antennas_down() -> tuple[Row, ...]:
    """Return the rows of Table 13: one antenna (or two labels run together), then offsets."""
    rows = []
    for number, cells in enumerate(lines(13)[2:], 1):
        labels = next((n for n, cell in enumerate(cells) if not LABEL.fullmatch(cell)), len(cells))
        rows.append(Row(number, tuple(cells[:labels]), tuple(cells[labels:])))
    return tuple(rows)


def scans_across() -> list[tuple[int, int]]:
    """Return direction (p is +1, m is -1) and elevation [deg] of each scan of Table 13."""
    titles = " ".join(lines(13)[1])
    signs = {"p": 1, "m": -1}
    return [(signs[sign], int(el)) for sign, el in re.findall(r"([pm])(\d+)", titles)]


def number(cell: str) -> float:
    """Return a printed number [arcmin], NaN where the cell is no sign and three digits."""
    return float(cell) if OFFSET.fullmatch(cell) else math.nan


def minutes(cell: str) -> int | None:
    """Return a printed offset [arcmin], None where the cell is no offset or no peak."""
    if not OFFSET.fullmatch(cell) or abs(int(cell)) == NO_PEAK[0]:
        return None
    return int(cell)


MATCH, FOREIGN, EXTRA, LOST = range(4)

#: Probability of the next step (columns) after a step (rows). Most rows lose or
#: gain few cells; foreign cells come in runs, as a row's tail repeats another row's.
STEPS = np.array(
    [
        [0.95, 0.01, 0.02, 0.02],
        [0.08, 0.84, 0.04, 0.04],
        [0.55, 0.05, 0.37, 0.03],
        [0.35, 0.02, 0.03, 0.60],
    ]
)


def alignment(likelihood: Array, background: Array, cells: NDArray[np.int64]) -> Array:
    """Return the probability that each cell is its column's, for many rows at once.

    `likelihood`: of cell i if it is column j's, shape (rows, m, n).
    `background`: of cell i wherever it came from, shape (rows, m).
    `cells`: how many of the m cells each row really has, shape (rows,).
    Returns shape (rows, m, n); what is missing from 1 along j is the probability that the
      cell is a foreign one or one too many.
    """
    ahead = _ahead(likelihood, background)
    behind = _behind(likelihood, background, cells)
    rows, n = np.arange(len(cells)), likelihood.shape[2]
    whole = ahead[rows, cells, n].sum(axis=1)
    both: Array = ahead[:, 1:, 1:, MATCH] * behind[:, 1:, 1:, MATCH]
    return both / whole[:, None, None]


def _ahead(likelihood: Array, background: Array) -> Array:
    """Return the likelihood of the first i cells and j columns by last step, (rows, i, j, 4)."""
    rows, m, n = likelihood.shape
    ahead = np.zeros((rows, m + 1, n + 1, 4))
    ahead[:, 0, 0, MATCH] = 1
    for i in range(m + 1):
        for j in range(n + 1):
            here = ahead[:, i, j]
            if i and j:
                before = ahead[:, i - 1, j - 1]
                here[:, MATCH] += before @ STEPS[:, MATCH] * likelihood[:, i - 1, j - 1]
                here[:, FOREIGN] = before @ STEPS[:, FOREIGN] * background[:, i - 1]
            if i:
                here[:, EXTRA] = ahead[:, i - 1, j] @ STEPS[:, EXTRA] * background[:, i - 1]
            if j:
                here[:, LOST] = ahead[:, i, j - 1] @ STEPS[:, LOST]
    return ahead


def _behind(likelihood: Array, background: Array, cells: NDArray[np.int64]) -> Array:
    """Return the likelihood of what follows i cells and j columns, given the last step."""
    rows, m, n = likelihood.shape
    behind = np.zeros((rows, m + 1, n + 1, 4))
    behind[np.arange(rows), cells, n] = 1
    for i in range(m, -1, -1):
        for j in range(n, -1, -1):
            here = behind[:, i, j]
            if i < m and j < n:
                after = behind[:, i + 1, j + 1]
                matched = after[:, MATCH] * likelihood[:, i, j]
                here += matched[:, None] * STEPS[:, MATCH]
                here += (after[:, FOREIGN] * background[:, i])[:, None] * STEPS[:, FOREIGN]
            if i < m:
                extra = behind[:, i + 1, j, EXTRA] * background[:, i]
                here += extra[:, None] * STEPS[:, EXTRA]
            if j < n:
                here += behind[:, i, j + 1, LOST, None] * STEPS[:, LOST]
    return behind


#: How far along hour angle scans still tell of each other (one sigma) [h].
WIDTH_H = 1.5

#: A fit pulls in scans of a track within this many of its sigmas; the rest fade out.
FADE = 2.0

#: Pull towards the track's median: for its value, slope, bend and direction's half-difference.
PULL = np.diag([1e-3, 0.02, 0.5, 1e-2])

#: An offset that is alone in its hour angle tells nothing; this many weigh enough.
ENOUGH = 4


def expected_offsets(
    offset: Array,
    weight: Array,
    *,
    hour_angle_h: Array,
    direction: Array,
    scan: NDArray[Any],
    stretch: NDArray[Any],
) -> Array:
    """Return each antenna's offset as the other scans lead to expect it.

    A local parabola in hour angle and a half-difference between forward and
    reverse, fitted robustly to the scans of the same stretch (between two
    settings of the offsets), the scan itself and its other channel left out.

    `offset`, `weight`: offsets [arcmin] and how far each is trusted (0 to 1), shape (rows,
      antennas).
    `hour_angle_h`, `direction`, `scan`, `stretch`: of each row, shape (rows,).
    Returns shape (rows, antennas) [arcmin]; NaN where too few scans are trusted.
    """
    apart_h = hour_angle_h[None, :] - hour_angle_h[:, None]
    tells = (scan[None, :] != scan[:, None]) & (stretch[None, :] == stretch[:, None])
    # (expected row, telling row, antenna)
    base = (np.exp(-0.5 * (apart_h / WIDTH_H) ** 2) * tells)[:, :, None] * weight[None]
    y = np.nan_to_num(offset)
    turned = np.broadcast_to(direction[None, :], apart_h.shape)
    terms = np.stack([np.ones_like(apart_h), apart_h, apart_h**2, turned], axis=2)
    start = np.zeros((*base.shape[::2], 4))
    start[..., 0] = _medians(offset, base > 0)
    fit = start
    for turn in range(12):
        apart = y[None] - np.einsum("erk,eak->era", terms, fit)
        spread = 1.2 if turn >= 4 else np.maximum(1.0, 1.48 * _median_of(np.abs(apart), base > 0))
        fading = base / (1 + (apart / (FADE * spread)) ** 2) ** 2
        normal = np.einsum("era,erk,erl->eakl", fading, terms, terms) + PULL
        right = np.einsum("era,erk,ra->eak", fading, terms, y) + start @ PULL
        fit = np.linalg.solve(normal, right[..., None])[..., 0]
    here = fit[..., 0] + fit[..., 3] * direction[:, None]
    return np.where((base > 0).sum(axis=1) >= ENOUGH, here, np.nan)


def _medians(offset: Array, known: NDArray[np.bool_]) -> Array:
    """Return each antenna's median over the rows known to each row, 0 where none is."""
    return np.nan_to_num(_median_of(np.broadcast_to(offset, known.shape), known)[:, 0])


def _median_of(values: Array, known: NDArray[np.bool_]) -> Array:
    """Return the median along the telling rows, kept as an axis of length 1."""
    with np.errstate(all="ignore"):
        masked = np.ma.masked_array(values, ~known)
        middle = np.ma.median(masked, axis=1, keepdims=True)
    return np.ma.filled(middle, np.nan)
