"""Compare two arrays of answers: how many differ, by how much, and where worst."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pyport.parity.described.description import Batch, Routine, Variable
from pyport.parity.described.functions import Spelling, spell, spelled

#: Distance between answers of different kinds: NaN and a number, infinite and finite, two texts.
UNLIKE = np.iinfo(np.int64).max

#: The greatest distance between two numbers that is counted.
FARTHEST = UNLIKE - 1

_INTEGERS: dict[int, type[np.signedinteger]] = {4: np.int32, 8: np.int64}


def ordinal(values: NDArray[np.floating]) -> NDArray[np.int64]:
    """Return the rank of each REAL*4 or REAL*8: neighbours differ by one, -0.0 and 0.0 too.

    `values`: float32 or float64 numbers, no NaN, any shape.
    """
    integer = _INTEGERS[values.dtype.itemsize]
    bits = np.ascontiguousarray(values).view(integer).reshape(values.shape).astype(np.int64)
    return np.where(bits < 0, -(bits & np.iinfo(integer).max) - 1, bits)


def ulps(expected: ArrayLike, actual: ArrayLike) -> NDArray[np.int64]:
    """Return how many REAL numbers apart two arrays are, element by element.

    REAL*8 where `expected` is float64, else REAL*4. Any NaN equals any other: IEEE 754 promises
    neither sign nor payload. A NaN and a number are ``UNLIKE``, so are infinity and a finite
    number.
    """
    real = np.float64 if getattr(expected, "dtype", None) == np.float64 else np.float32
    expected, actual = np.asarray(expected, real), np.asarray(actual, real)
    low, high = ordinal(expected), ordinal(actual)
    with np.errstate(over="ignore"):
        distance = np.abs(low - high)
    # REAL*8 of opposite signs may be farther apart than an INTEGER*8 counts
    distance = np.where(np.abs(low.astype(float) - high) >= 2.0**63, FARTHEST, distance)
    unlike = (np.isnan(expected) != np.isnan(actual)) | (np.isinf(expected) != np.isinf(actual))
    unlike |= np.isinf(expected) & np.isinf(actual) & (expected != actual)
    distance = np.where(unlike, UNLIKE, distance)
    return np.where(np.isnan(expected) & np.isnan(actual), 0, distance)


def distances(expected: NDArray, actual: NDArray) -> NDArray[np.int64]:
    """Return the distance of each pair of answers of any kind, the kind being that of `expected`.

    REAL in ulp, INTEGER in steps; LOGICAL and CHARACTER are equal or ``UNLIKE``.
    """
    if expected.dtype.kind == "f":
        return ulps(expected, actual)
    if expected.dtype.kind == "i":
        apart = np.abs(expected.astype(float) - actual.astype(float))
        with np.errstate(over="ignore"):
            exact = np.abs(expected.astype(np.int64) - actual.astype(np.int64))
        return np.where(apart >= 2.0**63, FARTHEST, exact)
    return np.where(expected == actual, 0, UNLIKE)


def neighbour(values: NDArray[np.floating], side: float) -> NDArray[np.floating]:
    """Return the next number of the same kind towards `side`."""
    with np.errstate(over="ignore"):  # beyond the largest number comes infinity
        return np.nextafter(values, values.dtype.type(side))


#: Distances are counted one by one below this, by powers of two above.
EXACT_BELOW = 1024


@dataclass(frozen=True)
class Worst:
    """The input whose answers are farthest apart, every number as a hexadecimal literal."""

    inputs: dict[str, Spelling]
    expected: Spelling
    actual: Spelling
    distance: int

    def input_text(self) -> str:
        """Return the inputs in one line."""
        return " ".join(
            f"{name}=[{', '.join(v)}]" if isinstance(v, list) else f"{name}={v}"
            for name, v in self.inputs.items()
        )


@dataclass(frozen=True)
class Comparison:
    """How one output of one routine compares."""

    #: `routine`, `output`: the routine's name and the label of its output.
    routine: str
    output: str
    counts: Counter[int]  #: distance -> number of points; by powers of two from ``EXACT_BELOW`` on
    worst: Worst | None  #: the input that is farthest off, None where all answers are equal
    physical: float = 0.0  #: the greatest distance in the output's physical unit, where it has one
    unit: str = ""  #: that unit

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
        """The greatest distance; ``UNLIKE`` where a NaN or infinity met a number."""
        return 0 if self.worst is None else self.worst.distance

    def quantile(self, share: float) -> int:
        """Return the least distance that `share` of the points do not exceed."""
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
            max(self.physical, other.physical),
            self.unit,
        )

    def __str__(self) -> str:
        """Say routine, output, differing points, distance and the worst input in one line."""
        text = f"{self.routine} {self.output}: {self.differing} of {self.points} differ"
        if self.worst is None:
            return text
        return (
            f"{text}, worst by {distance_text(self.most)} at {self.worst.input_text()}: "
            f"expected {one_text(self.worst.expected)}, got {one_text(self.worst.actual)}"
        )

    def as_json(self) -> dict[str, Any]:
        """Return it as plain data, counts and all."""
        return vars(self) | {
            "worst": None if self.worst is None else vars(self.worst),
            "counts": [list(pair) for pair in self.counts.items()],
        }

    @classmethod
    def from_json(cls, content: dict[str, Any]) -> Comparison:
        """Return what `as_json` gave."""
        worst = content["worst"]
        counts = Counter(dict(content["counts"]))
        return cls(**content | {"worst": worst and Worst(**worst), "counts": counts})


def one_text(value: Spelling) -> str:
    """Return a spelled value, or a list of them, as one text."""
    return f"[{', '.join(value)}]" if isinstance(value, list) else value


def distance_text(distance: int) -> str:
    """Return a distance as people read it."""
    return "NaN or infinity against a number" if distance == UNLIKE else f"{distance} ulp"


@dataclass(frozen=True)
class Pair:
    """The oracle's and a port's answers at the same points, by output."""

    routine: Routine
    batch: Batch
    expected: Batch
    actual: Batch
    raised: dict[int, str] = field(default_factory=dict)

    def distances(self) -> dict[str, NDArray[np.int64]]:
        """Return how far apart each output's answers are, shape (n,); arrays by their worst."""
        return {one.key: self.over(one, distances(*self.both(one))) for one in self.routine.outputs}

    def both(self, one: Variable) -> tuple[NDArray, NDArray]:
        """Return an output's answers."""
        return self.expected[one.key], self.actual[one.key]

    def over(self, one: Variable, apart: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return distances of elements as those of points; ``UNLIKE`` where the port raised."""
        result = apart.reshape(len(apart), -1).max(axis=1) if one.shape else apart.copy()
        result[list(self.raised)] = UNLIKE
        return result

    def compare(self, apart: dict[str, NDArray[np.int64]] | None = None) -> list[Comparison]:
        """Return a comparison for each output, of the given distances or of the answers'."""
        apart = self.distances() if apart is None else apart
        return [self._one(one, apart[one.key]) for one in self.routine.outputs]

    def _one(self, one: Variable, apart: NDArray[np.int64]) -> Comparison:
        counts: Counter[int] = Counter()
        values, numbers = np.unique(apart, return_counts=True)
        for value, number in zip(values.tolist(), numbers.tolist(), strict=True):
            counts[_bin(value)] += number
        unit = one.physical[0] if one.physical else ""
        if not apart.any():
            return Comparison(self.routine.name, one.label, counts, None, 0.0, unit)
        i = int(np.argmax(apart))
        expected, actual = self.both(one)
        worst = Worst(
            inputs=spelled(self.routine, self.batch, i),
            expected=spell(expected[i]),
            actual=self.raised.get(i) or spell(actual[i]),
            distance=int(apart[i]),
        )
        physical = self._physical(one, apart > 0)
        return Comparison(self.routine.name, one.label, counts, worst, physical, unit)

    def _physical(self, one: Variable, where: NDArray[np.bool_]) -> float:
        expected, actual = self.both(one)
        if one.type.base != "real":
            return 0.0
        _, factor, cosine = one.physical or ("", 1.0, "")
        low, high = expected[where].astype(float), actual[where].astype(float)
        finite = np.isfinite(low) & np.isfinite(high)
        with np.errstate(invalid="ignore"):
            apart = np.abs(high - low) * factor
        if one.turn is not None:
            apart = np.minimum(apart, np.abs(one.turn * factor - apart))
        if cosine:
            apart = apart * np.abs(np.cos(self.batch[cosine][where].astype(float)))
        return float(apart[finite].max(initial=0))


def _bin(distance: int) -> int:
    """Return the distance itself when it is small or `UNLIKE`, else the power of two below."""
    if distance < EXACT_BELOW or distance == UNLIKE:
        return distance
    return 1 << (distance.bit_length() - 1)
