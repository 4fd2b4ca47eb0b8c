"""Counting: shares with Wilson's intervals, and what they say of a target."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

#: Standard deviations that hold 95 % of a normal distribution.
_Z95 = 1.959963984540054

MET, MISSED, OPEN, NONE = "met", "missed", "open", "none"


@dataclass(frozen=True)
class Share:
    """A share that was counted, and what its interval is made from.

    `hits` of `of`; `effective` is how many independent ones the `of` are worth.
    """

    hits: int
    of: int
    effective: float

    @property
    def value(self) -> float:
        """Return the share; NaN where nothing was counted."""
        return self.hits / self.of if self.of else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Return Wilson's 95 % interval (Wilson 1927, JASA 22, 209)."""
        if not self.of:
            return 0.0, 1.0
        spread = _Z95**2 / self.effective
        centre = (self.value + spread / 2) / (1 + spread)
        half = math.sqrt(self.value * (1 - self.value) * spread + spread**2 / 4) / (1 + spread)
        return max(0.0, centre - half), min(1.0, centre + half)

    def judged(self, low: float, high: float) -> str:
        """Tell whether a target was met (its share is in it), missed (its interval is not), open.

        Open is a share outside the target that more cases may bring into it.
        """
        if not self.of:
            return NONE
        if low <= self.value <= high:
            return MET
        least, most = self.interval
        return MISSED if least > high or most < low else OPEN

    def __str__(self) -> str:
        """Return "71.2 (68.0-74.1)" in per cent."""
        if not self.of:
            return "-"
        low, high = self.interval
        return f"{100 * self.value:.1f} ({100 * low:.1f}-{100 * high:.1f})"


def counted(outcomes: Sequence[bool]) -> Share:
    """Return the share of what came true among independent outcomes."""
    return Share(sum(outcomes), len(outcomes), float(len(outcomes)))


def clustered(groups: Sequence[Sequence[bool]]) -> Share:
    """Return the share of what came true where the outcomes of a group hang together.

    The coefficients of one fit share its noise: the variance of the share is that between groups
    (Kish 1965, Survey Sampling, sec. 5.4), never less than that of independent outcomes.
    """
    kept = [group for group in groups if group]
    hits, of = sum(map(sum, kept)), sum(map(len, kept))
    if of == 0:
        return Share(0, 0, 0.0)
    share = hits / of
    free = share * (1 - share) / of
    between = sum((sum(group) - share * len(group)) ** 2 for group in kept) / of**2
    if len(kept) > 1:
        between *= len(kept) / (len(kept) - 1)
    worse = max(between / free, 1.0) if free > 0 else of / len(kept)
    return Share(hits, of, of / worse)
