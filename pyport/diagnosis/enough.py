"""Whether recordings are enough: the one rule on how few say nothing.

A name is weighed by the scatter of what is left. From n numbers beyond all coefficients that is
known to a share of 1 / sqrt(2 n): with twenty to a sixth, so that four sigmas may be three and a
half or five; with five to a third, so that they may be anything. Below that nothing is looked for,
and nothing that was found keeps a name.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC
from pyport.diagnosis.case import Problem
from pyport.thresholds import ENOUGH, FEWEST


@dataclass(frozen=True)
class TooFew:
    """Recordings that say nothing: how many there are, and for how many coefficients.

    `numbers` are measured offsets, one for each axis of a pointing.
    """

    pointings: int
    numbers: int
    coefficients: int

    @property
    def lacking(self) -> int:
        """Return how many measured numbers more are needed."""
        return lacking(self.numbers, self.coefficients)

    @property
    def scatter_known(self) -> bool:
        """Tell whether enough is left beyond the coefficients to hold anything against."""
        return self.numbers - self.coefficients >= FEWEST

    @property
    def sentence(self) -> str:
        """Return that nothing can be said, and what would be needed."""
        of = "pointing" if self.pointings == 1 else "pointings"
        return (
            f"Too few recordings: nothing can be said from {self.pointings} {of} "
            f"({self.numbers} measured numbers) with {self.coefficients} fitted coefficients; "
            f"{self.coefficients + ENOUGH} numbers are needed"
        )


def lacking(numbers: int, coefficients: int) -> int:
    """Return how many measured numbers are lacking beside so many coefficients, 0 for none."""
    return max(0, coefficients + ENOUGH - numbers)


def measured(setup: Problem, rows: NDArray[np.bool_] | None = None) -> int:
    """Return how many numbers some readings (m,) measured; repeats of a pointing are one."""
    number = setup.pointing * 2 + setup.stack.is_y
    return len(np.unique(number if rows is None else number[rows]))


def too_few(setup: Problem) -> TooFew | None:
    """Return how few recordings there are beside the model's own terms; None for enough."""
    design = setup.expanded(setup.base)
    rank = int(np.linalg.matrix_rank(design)) if design.size else 0
    found = TooFew(len(np.unique(setup.pointing)), measured(setup), rank)
    return found if found.lacking else None


def smallest_seen(limits: dict[str, float]) -> str | None:
    """Return how large an effect would have been seen, the best seen one; None where none is."""
    known = {name: size for name, size in limits.items() if np.isfinite(size)}
    if not known:
        return None
    name = min(known, key=lambda one: known[one])
    return (
        f"an offset of {known[name] / ARCSEC:.2g} arcsec rms would have been seen in half of such "
        f"recordings ({name.replace('_', ' ')}, what they show best), a smaller one not"
    )
