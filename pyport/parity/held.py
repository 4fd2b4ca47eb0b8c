"""Both ports held to the oracle at some points, and over all sets of points together."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from operator import add

import numpy as np

from pyport.parity import promise
from pyport.parity.compare import Comparison, compare
from pyport.parity.ledger import explained
from pyport.parity.points import Points, Real4


@dataclass(frozen=True)
class Held:
    """Both ports held to the oracle at some points; comparisons in the order of ``OUTPUTS``.

    Attributes
    ----------
    legacy
        The statement-by-statement port, which is to be equal bit for bit.
    pointing
        The vectorised port, where it promises anything.
    sky
        The same without the points that the ledger explains: how far off on the sky.
    beyond
        The same, counting only what goes beyond the oracle's own spread as well.
    explained
        Entry of the ledger -> number of answers beyond the promise that it explains.
    """

    legacy: list[Comparison]
    pointing: list[Comparison]
    sky: list[Comparison]
    beyond: list[Comparison]
    explained: Counter[str]

    def __add__(self, other: Held) -> Held:
        """Return the same over both sets of points."""
        return Held(
            _sum(self.legacy, other.legacy),
            _sum(self.pointing, other.pointing),
            _sum(self.sky, other.sky),
            _sum(self.beyond, other.beyond),
            Counter({k: self.explained[k] + other.explained[k] for k in self.explained}),
        )


def _sum(one: list[Comparison], other: list[Comparison]) -> list[Comparison]:
    return [add(*pair) for pair in zip(one, other, strict=True)]


def hold(at: Points, expected: Real4, own_spread: Real4, legacy: Real4, pointing: Real4) -> Held:
    """Compare both ports' answers with the oracle's, all of shape (n, 5)."""
    inside = promise.promised(at)
    there = at.part(inside)
    true, port = expected[inside], pointing[inside]
    apart = promise.distances(true, port)
    outside = ~np.any(list(explained(there, true).values()), axis=0)
    left, numbers = promise.beyond(true, port, own_spread[:, inside], there)
    return Held(
        compare(expected, legacy, at),
        compare(true, port, there, apart),
        compare(true, port, there, apart * outside),
        compare(true, port, there, left),
        Counter(numbers),
    )
