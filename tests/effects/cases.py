"""What a case of the harness is: an effect, and what it truly does."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from effects.sky import campaign

from pyport.effects import Circumstances

AT = campaign()


@dataclass(frozen=True)
class Case:
    """An effect and what it truly does, by a calculation that shares nothing with the catalogue.

    Attributes
    ----------
    effect, variant
        Id, and the member of the family; "" for the first.
    amounts
        Coefficients in their reported units, for an amplitude of one.
    offsets
        Amplitude -> (x, y) [rad], as it truly is.
    at
        Where it is.
    tolerance
        Share of the largest offset by which the catalogue may differ to first order.
    scales
        False where nature fixes the amplitude.
    """

    effect: str
    amounts: tuple[float, ...]
    offsets: Callable[[float], tuple[np.ndarray, np.ndarray]]
    variant: str = ""
    at: Circumstances = AT
    tolerance: float = 1e-4
    scales: bool = True

    def __str__(self):
        """Name the case in a test's id."""
        return f"{self.effect} {self.variant}".strip()
