"""Readings left out: single pointings, bands of elevation, sectors of azimuth, other nights.

Single pointings have neighbours in the fit, and bend with them; a whole band or sector
has none, as any direction has that was not observed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array, Codes
from pyport.effects import CATALOGUE
from pyport.effects.telescope.geometry import NIGHTLY
from pyport.prediction.contenders import Contender, Night, Rows, solved

#: Parts that pointings are dealt to, and that elevation and azimuth are cut into.
DEALT, BANDS, SECTORS = 10, 10, 8
#: Pointings are dealt so often: what terms are picked hangs on who is left out with whom.
DEALS = 5


@dataclass(frozen=True)
class Scheme:
    """A way to leave readings out: its name, and each time the part of each reading, (m,)."""

    name: str
    parts: tuple[Codes, ...]


def schemes(night: Night, seed: int) -> Iterator[Scheme]:
    """Yield the ways to leave readings of a night out."""
    first, number = night.pointings
    az, el = (one[first] for one in (night.recordings.at.az, night.recordings.at.el))
    rng = np.random.default_rng(seed)
    deals = tuple((rng.permutation(len(first)) % DEALT)[number] for _ in range(DEALS))
    yield Scheme("pointings", deals)
    yield Scheme("elevation bands", (_cut(el, BANDS)[number],))
    yield Scheme("azimuth sectors", (_cut(np.mod(az, 2 * np.pi), SECTORS)[number],))


def _cut(values: Array, parts: int) -> Codes:
    """Cut values (n,) into parts of as many each, by rank."""
    rank = np.argsort(np.argsort(values, kind="stable"), kind="stable")
    return rank * min(parts, len(values)) // len(values)


def left_out(contender: Contender, scheme: Scheme) -> Array:
    """Return the rms, over all times, of what is left of each reading unseen, shape (m,)."""
    squares = np.zeros(len(scheme.parts[0]))
    for part in scheme.parts:
        for one in np.unique(part):
            own = part == one
            squares[own] += contender.residual(~own)[own] ** 2
    return np.asarray(np.sqrt(squares / len(scheme.parts)))


def on_another(contender: Contender, own: Night, other: Night) -> Array:
    """Return what is left of another night's readings, its zero points refitted, shape (m,)."""
    left = contender.residual(np.ones(len(own.stack), bool), other)
    zeros = np.concatenate(
        [other.stack.columns(CATALOGUE[one], other.recordings.at) for one in NIGHTLY], axis=1
    )
    everything = np.ones(len(left), bool)
    return np.asarray(left - zeros @ solved(zeros, left, other.stack.is_y, everything)[0])


def on_the_sky(left: Array, is_y: Rows, counted: Rows) -> float:
    """Return the rms on the sky of residuals in both axes; of one axis where there is one."""
    squares = [
        float(np.mean(left[rows] ** 2)) for rows in (counted & ~is_y, counted & is_y) if rows.any()
    ]
    return float(np.sqrt(sum(squares)))
