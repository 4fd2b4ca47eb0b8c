"""The arms of the array, which section 5 (c) calls mirror images of each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.studies.gmrt.curves import Curve

#: The antennas that the paper calls mirror images of each other.
EAST = ("E03", "E04", "E05", "E06")
WEST = ("W04", "W05", "W06")


@dataclass(frozen=True)
class Mirror:
    """The odd part (coefficient of sin HA) of both arms on one day.

    Attributes
    ----------
    session
        The day.
    odd
        Antenna -> coefficient and sigma [rad].
    opposite
        How many antennas have the sign of their arm, and how many there are.
    chance
        Of as many with the right sign if signs were tossed.
    """

    session: str
    odd: dict[str, tuple[float, float]]
    opposite: tuple[int, int]
    chance: float


def mirrors(found: Sequence[Curve]) -> list[Mirror]:
    """Return for each day whether the arms bend opposite ways about the meridian."""
    from scipy.stats import binom

    days = []
    for session in sorted({curve.track.session for curve in found}):
        odd = {
            curve.track.antenna: curve.odd
            for curve in found
            if curve.track.session == session and curve.track.antenna in EAST + WEST
        }
        right = sum(
            np.sign(value) == (-1 if antenna in EAST else 1) for antenna, (value, _) in odd.items()
        )
        chance = float(binom.sf(right - 1, len(odd), 0.5)) if odd else 1.0
        days.append(Mirror(session, odd, (int(right), len(odd)), chance))
    return days
