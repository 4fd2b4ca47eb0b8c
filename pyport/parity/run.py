"""Hold the ports to the oracle: live where it is installed, else to its stored answers."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import reduce
from operator import add
from typing import Any

from pyport.parity import points, stored
from pyport.parity.answers import find_oracle, of_legacy, of_oracle, of_pointing
from pyport.parity.compare import Comparison, compare
from pyport.parity.edges import edges
from pyport.parity.points import Points, Real4
from pyport.progress import track

CHUNK = 5000


@dataclass(frozen=True)
class Parity:
    """The ports against the oracle, five comparisons a port in the order of ``OUTPUTS``."""

    source: str
    provenance: dict[str, Any]
    points: dict[str, int]
    legacy: list[Comparison]
    pointing: list[Comparison] | None
    table_azimuths_differing: int

    @property
    def holds(self) -> bool:
        """Whether the legacy port is the published program, bit for bit, wherever it was asked."""
        return self.table_azimuths_differing == 0 and not any(c.differing for c in self.legacy)


def run(random_points: int = 20_000, seed: int = 0, jobs: int | None = None) -> Parity:
    """Compare both ports with the oracle.

    Parameters
    ----------
    random_points
        How many random points to add to the table and the edges where the oracle is installed.
    seed
        Seed of the random points.
    jobs
        Processes; all cores by default.
    """
    oracle = find_oracle()
    if oracle is None:
        return _run_stored()
    chunks = [(name, i, CHUNK) for name in ("table", "edges") for i in range(_chunks(_named(name)))]
    whole, rest = divmod(random_points, CHUNK)
    chunks += [(f"random {seed}", i, CHUNK) for i in range(whole)]
    chunks += [(f"random {seed}", whole, rest)] if rest else []
    results = list(track(_map(chunks, jobs), "parity", total=len(chunks)))
    legacy = _total([legacy for legacy, _ in results])
    pointing = _total([part for _, part in results if part])
    return Parity(
        source="live",
        provenance=stored.describe(oracle),
        points={
            "table": len(points.table()),
            "edges": len(edges()),
            "random": random_points,
        },
        legacy=legacy,
        pointing=pointing or None,
        table_azimuths_differing=_azimuths_differing(),
    )


def _run_stored() -> Parity:
    sets = {name: stored.load(name) for name in stored.SETS}
    legacy = _total([compare(s.answers, of_legacy(s.at), s.at) for s in sets.values()])
    parts = [_pointing(name, s.at, s.answers) for name, s in sets.items()]
    return Parity(
        source="stored",
        provenance=sets["table"].provenance,
        points={name: len(s.at) for name, s in sets.items()},
        legacy=legacy,
        pointing=_total([part for part in parts if part]) or None,
        table_azimuths_differing=_azimuths_differing(),
    )


def _azimuths_differing() -> int:
    """Count the table's azimuths at which the legacy port leaves the stored answers."""
    expected = stored.load("table").digests
    actual = stored.digests(of_legacy(points.table()))
    return sum(a != b for a, b in zip(actual, expected, strict=True))


def _pointing(name: str, at: Points, expected: Real4) -> list[Comparison]:
    """Compare the vectorised port, which promises nothing at the ends of REAL*4."""
    actual = None if name == "edges" else of_pointing(at)
    return [] if actual is None else compare(expected, actual, at)


def _named(name: str) -> Points:
    return points.table() if name == "table" else edges()


def _chunks(at: Points) -> int:
    return -(-len(at) // CHUNK)


def _map(
    chunks: list[tuple[str, int, int]], jobs: int | None
) -> Iterator[tuple[list[Comparison], list[Comparison]]]:
    with ProcessPoolExecutor(jobs or os.cpu_count()) as pool:
        yield from pool.map(_chunk, chunks)


def _chunk(task: tuple[str, int, int]) -> tuple[list[Comparison], list[Comparison]]:
    """Compare one chunk of points, made where it is used: (set, number, size)."""
    name, number, size = task
    oracle = find_oracle()
    if oracle is None:
        raise RuntimeError("the oracle vanished between two processes")
    if name.startswith("random"):
        at = points.random(size, [int(name.split()[1]), number])
    else:
        at = _named(name).part(slice(number * CHUNK, (number + 1) * CHUNK))
    expected = of_oracle(oracle, at)
    return compare(expected, of_legacy(at), at), _pointing(name, at, expected)


def _total(parts: list[list[Comparison]]) -> list[Comparison]:
    """Add up comparisons column by column."""
    return [reduce(add, column) for column in zip(*parts, strict=True)]
