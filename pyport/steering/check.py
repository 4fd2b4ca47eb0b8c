"""A steering table held to the published one, in the last digit that was printed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.pointing import recovered
from pyport.steering.published import Block, published
from pyport.steering.tabulate import DEFAULT_REFRACTION, rt32_offsets


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
