"""A steering table held to the published one, in the last digit that was printed.

The zenith-distance offsets are -dAlt - R(z). Each printed number, with half a unit of its last
digit either way, bounds R at its zenith distance; all azimuths must agree.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.effects.sky.atmosphere import FORMULAE, ITERATIONS
from pyport.pointing import recovered
from pyport.steering.published import Block, published
from pyport.steering.tabulate import DEFAULT_REFRACTION, rt32_offsets, zenith_refraction


@dataclass(frozen=True)
class BlockCheck:
    """A published block beside what the program computes, in units of the last printed digit.

    `computed` has the block's shape (n,), unrounded.
    """

    block: Block
    computed: Array

    @property
    def misses(self) -> NDArray[np.intp]:
        """Return the indices of the cells whose last digit differs."""
        return np.flatnonzero(np.rint(self.computed) != self.block.printed)

    @property
    def agree(self) -> int:
        """Return how many cells agree in their last digit."""
        return len(self.block.printed) - len(self.misses)

    @property
    def total(self) -> int:
        """Return how many cells there are."""
        return len(self.block.printed)


def check(
    refraction_name: str = DEFAULT_REFRACTION,
    reading: str = "as-written",
    parameters: Array | None = None,
) -> list[BlockCheck]:
    """Compute every printed number of the 3model table anew, block by block.

    Parameters
    ----------
    refraction_name, reading
        As for :func:`pyport.steering.tabulate`.
    parameters
        p1..p12 [rad]; those of `rt32-3model` where none are given.
    """
    p = recovered() if parameters is None else parameters
    results = []
    for block in published():
        at = block.az_deg, block.zd_deg, p, refraction_name, reading
        d_az, d_zd = rt32_offsets(*at, exact=True)
        if block.quantity.endswith("_difference"):
            d_az_rough, d_zd_rough = rt32_offsets(*at, exact=False)
            d_az, d_zd = d_az_rough - d_az, d_zd_rough - d_zd
        value_deg = d_az if block.quantity.startswith("d_az") else d_zd
        results.append(BlockCheck(block, value_deg / block.unit_deg))
    return results


@dataclass(frozen=True)
class Bounds:
    """Between which R(z) lies [deg] for every printed number's sake, by zenith distance, (n,)."""

    zd_deg: Array
    low_deg: Array
    high_deg: Array

    def outside(self, values_deg: Array) -> Array:
        """Return how far values of R lie outside the bounds [deg], shape (n,)."""
        short = np.maximum(self.low_deg - values_deg, values_deg - self.high_deg)
        return np.maximum(short, 0)


@dataclass(frozen=True)
class Candidate:
    """A formula of refraction, and how far it stays from what the digits tell.

    `name`, `iterations`: as for :func:`pyport.effects.sky.atmosphere.refraction`.
    `outside_deg`: distance from the bounds [deg] at their zenith distances, shape (n,).
    `agree`, `total`: how many printed zenith-distance offsets it reproduces, of how many.
    """

    name: str
    iterations: int
    outside_deg: Array
    agree: int
    total: int


def _zenith_blocks() -> list[Block]:
    return [block for block in published() if block.quantity == "d_zd"]


def refraction_bounds() -> Bounds:
    """Return the bounds on R(z) that the published table sets."""
    height, low, high = [], [], []
    for block in _zenith_blocks():
        at = block.az_deg, block.zd_deg, recovered(), "none", "as-written"
        _, without_deg = rt32_offsets(*at, exact=True)
        refraction_deg = without_deg - block.printed * block.unit_deg
        height.append(block.zd_deg)
        low.append(refraction_deg - block.unit_deg / 2)
        high.append(refraction_deg + block.unit_deg / 2)
    all_zd_deg = np.concatenate(height)
    zd_deg, which = np.unique(all_zd_deg, return_inverse=True)
    lowest, highest = np.full(len(zd_deg), -np.inf), np.full(len(zd_deg), np.inf)
    np.maximum.at(lowest, which, np.concatenate(low))
    np.minimum.at(highest, which, np.concatenate(high))
    return Bounds(zd_deg, lowest, highest)


def candidates() -> list[Candidate]:
    """Return every formula, iterated and not, nearest to the table first."""
    bounds = refraction_bounds()
    found = []
    for name, formula in FORMULAE.items():
        for iterations in (0, 1, ITERATIONS) if formula.of == "apparent" else (0,):
            outside = bounds.outside(zenith_refraction(name, bounds.zd_deg, iterations))
            agree, total = _cells(name, iterations)
            found.append(Candidate(name, iterations, outside, agree, total))
    return sorted(found, key=lambda one: float(np.max(one.outside_deg)))


def _cells(name: str, iterations: int) -> tuple[int, int]:
    """Return how many printed zenith-distance offsets agree with a formula, of how many."""
    agree = total = 0
    for block in _zenith_blocks():
        at = block.az_deg, block.zd_deg, recovered()
        _, table_deg = rt32_offsets(*at, DEFAULT_REFRACTION, "as-written", exact=True)
        ours, theirs = (
            zenith_refraction(one, block.zd_deg, times)
            for one, times in ((DEFAULT_REFRACTION, 0), (name, iterations))
        )
        agree += int(np.sum(np.rint((table_deg + ours - theirs) / block.unit_deg) == block.printed))
        total += len(block.printed)
    return agree, total
