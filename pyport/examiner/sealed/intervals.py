"""How sure a counted rate is."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

#: Standard deviations that hold 95 % of a normal distribution.
_Z95 = 1.959963984540054


@dataclass(frozen=True)
class Rate:
    """`hits` out of `of`, with Wilson's 95 % interval."""

    hits: int
    of: int

    @property
    def value(self) -> float:
        """Return the rate; NaN where nothing was counted."""
        return self.hits / self.of if self.of else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """Return Wilson's 95 % interval (Wilson 1927, JASA 22, 209); all of it for nothing."""
        if not self.of:
            return 0.0, 1.0
        spread = _Z95**2 / self.of
        centre = (self.value + spread / 2) / (1 + spread)
        half = sqrt(self.value * (1 - self.value) * spread + spread**2 / 4) / (1 + spread)
        return max(0.0, centre - half), min(1.0, max(centre + half, self.value))

    def __str__(self) -> str:
        """Return "93.3 % (56 of 60; 84.1 to 97.4)"."""
        if not self.of:
            return "none"
        low, high = self.interval
        counted = f"{self.hits} of {self.of}; {100 * low:.1f} to {100 * high:.1f}"
        return f"{100 * self.value:.1f} % ({counted})"


def count(outcomes: list[bool]) -> Rate:
    """Return the rate of what came true."""
    return Rate(sum(outcomes), len(outcomes))
