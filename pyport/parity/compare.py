"""Compare two arrays of answers: how many differ, by how much, and where worst."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.parity.answers import OUTPUTS
from pyport.parity.points import Points, Real4
from pyport.parity.ulp import UNLIKE, ulps

#: Distances are counted one by one below this, by powers of two above.
EXACT_BELOW = 1024


def hexadecimal(value: float) -> str:
    """Return a REAL*4 as the shortest hexadecimal literal that ``float.fromhex`` reads back."""
    mantissa, p, exponent = float(value).hex().partition("p")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").rstrip(".")
    return mantissa + p + exponent


@dataclass(frozen=True)
class Worst:
    """The input whose answers are farthest apart, every number as a hexadecimal literal."""

    az: str
    alt: str
    p: tuple[str, ...]
    expected: str
    actual: str
    distance: int


@dataclass(frozen=True)
class Comparison:
    """How one output of one routine compares.

    Attributes
    ----------
    routine, output
        Which of ``OUTPUTS``.
    counts
        Distance [ulp of REAL*4] -> number of points; by powers of two from ``EXACT_BELOW`` on.
    worst
        The input that is farthest off, None where all answers are equal.
    arcsec
        The greatest distance on the sky [arcsec], of azimuths times the cosine of altitude.
    """

    routine: str
    output: str
    counts: Counter[int]
    worst: Worst | None
    arcsec: float

    @property
    def points(self) -> int:
        """The number of points compared."""
        return self.counts.total()

    @property
    def differing(self) -> int:
        """The number of points whose answers are not equal."""
        return self.points - self.counts[0]

    @property
    def most(self) -> int:
        """The greatest distance [ulp]; ``UNLIKE`` where a NaN or infinity met a number."""
        return 0 if self.worst is None else self.worst.distance

    def quantile(self, share: float) -> int:
        """Return the least distance [ulp] that `share` of the points do not exceed."""
        seen = 0
        for distance in sorted(self.counts):
            seen += self.counts[distance]
            if seen >= share * self.points:
                return distance
        return 0

    def __add__(self, other: Comparison) -> Comparison:
        """Return the comparison over both sets of points."""
        return Comparison(
            self.routine,
            self.output,
            self.counts + other.counts,
            other.worst if other.most > self.most else self.worst,
            max(self.arcsec, other.arcsec),
        )

    def __str__(self) -> str:
        """Say routine, output, differing points, distance and the worst input in one line."""
        text = f"{self.routine} {self.output}: {self.differing} of {self.points} differ"
        if self.worst is None:
            return text
        worst = self.worst
        return (
            f"{text}, worst by {distance_text(self.most)} at az={worst.az} alt={worst.alt} "
            f"p=[{', '.join(worst.p)}]: expected {worst.expected}, got {worst.actual}"
        )


def distance_text(distance: int) -> str:
    """Return a distance as people read it."""
    return "NaN or infinity against a number" if distance == UNLIKE else f"{distance} ulp"


def compare(
    expected: Real4, actual: Real4, at: Points, distances: NDArray[np.int64] | None = None
) -> list[Comparison]:
    """Compare answers of shape (n, 5) column by column, in the order of ``OUTPUTS``.

    Parameters
    ----------
    expected, actual
        The answers.
    at
        The points.
    distances
        What to count, shape (n, 5); the distances of the answers [ulp] unless given.
    """
    distances = ulps(expected, actual) if distances is None else distances
    return [
        _compare_one(output, expected[:, k], actual[:, k], at, distances[:, k])
        for k, output in enumerate(OUTPUTS)
    ]


def _compare_one(
    output: tuple[str, str],
    expected: Real4,
    actual: Real4,
    at: Points,
    distances: NDArray[np.int64],
) -> Comparison:
    counts: Counter[int] = Counter()
    values, numbers = np.unique(distances, return_counts=True)
    for value, number in zip(values.tolist(), numbers.tolist(), strict=True):
        counts[_bin(value)] += number
    if not distances.any():
        return Comparison(*output, counts, None, 0.0)
    i = int(np.argmax(distances))
    worst = Worst(
        az=hexadecimal(at.az[i]),
        alt=hexadecimal(at.alt[i]),
        p=tuple(hexadecimal(value) for value in at.parameters[at.which[i]]),
        expected=hexadecimal(expected[i]),
        actual=hexadecimal(actual[i]),
        distance=int(distances[i]),
    )
    apart = (distances > 0) & np.isfinite(expected) & np.isfinite(actual)
    arcsec = np.abs(actual[apart].astype(float) - expected[apart]) * 3600
    if output[1] == "azimuth":
        arcsec *= np.abs(np.cos(at.alt[apart].astype(float)))
    return Comparison(*output, counts, worst, float(arcsec.max(initial=0)))


def _bin(distance: int) -> int:
    """Return the distance itself when it is small or `UNLIKE`, else the power of two below."""
    if distance < EXACT_BELOW or distance == UNLIKE:
        return distance
    return 1 << (distance.bit_length() - 1)
