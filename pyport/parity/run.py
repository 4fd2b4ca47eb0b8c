"""Hold the ports to the oracle: live where it is installed, else to its stored answers."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import reduce
from operator import add
from pathlib import Path
from typing import Any

from pyport.checkpoint import Checkpoint
from pyport.parity import points, promise, stored
from pyport.parity.answers import find_oracle, of_legacy, of_oracle, of_pointing
from pyport.parity.edges import edges
from pyport.parity.held import Held, hold
from pyport.parity.progress import over
from pyport.parity.spread import spread

#: Points that one process takes at a time.
CHUNK = 5000


@dataclass(frozen=True)
class Parity:
    """What `pyport parity` found.

    Attributes
    ----------
    source
        "live" when the compiled routines were asked, "stored" for their answers on paper.
    provenance
        Sources, compiler, flags, C library of the oracle.
    points
        Set of points -> number.
    held
        Both ports over all of them.
    table_azimuths_differing
        Azimuths of the whole table at which the legacy port leaves the stored digests; 0 when the
        compiled routines were asked, which is at each of its points.
    """

    source: str
    provenance: dict[str, Any]
    points: dict[str, int]
    held: Held
    table_azimuths_differing: int

    @property
    def bit_for_bit(self) -> bool:
        """Whether the legacy port is the published program wherever it was asked."""
        return self.table_azimuths_differing == 0 and not any(
            comparison.differing for comparison in self.held.legacy
        )

    @property
    def promise_kept(self) -> bool:
        """Whether the vectorised port keeps its promise."""
        return promise.kept([comparison.most for comparison in self.held.beyond])


def run(
    random_points: int = 20_000,
    seed: int = 0,
    jobs: int | None = None,
    *,
    live: bool = True,
    kept: Path | None = None,
) -> Parity:
    """Compare both ports with the oracle.

    Parameters
    ----------
    random_points
        How many random points to add to the table and the edges where the oracle is installed.
    seed
        Seed of the random points.
    jobs
        Processes; all cores by default.
    live
        Ask the compiled routines where they are installed, instead of their stored answers.
    kept
        Where to keep how far it has come; who asks removes that when the answer is written.
    """
    oracle = find_oracle() if live else None
    if oracle is None:
        return _run_stored()
    sizes = {"table": len(points.table()), "edges": len(edges()), "random": random_points}
    chunks = [
        (name, seed, start, min(start + CHUNK, size))
        for name, size in sizes.items()
        for start in range(0, size, CHUNK)
    ]
    about = stored.describe(oracle)
    so_far = Checkpoint(kept, about, sizes, seed, CHUNK)
    held = over(chunks, _hold_chunk, jobs or os.cpu_count() or 1, so_far)
    assert held is not None  # noqa: S101 - there are the table and the edges
    return Parity("live", about, sizes, held, 0)


def _run_stored() -> Parity:
    sets = {name: stored.load(name) for name in stored.SETS}
    parts = (
        hold(kept.at, kept.answers, kept.spread, of_legacy(kept.at), of_pointing(kept.at))
        for kept in sets.values()
    )
    held = reduce(add, parts)
    sizes = {name: len(kept.at) for name, kept in sets.items()}
    return Parity("stored", sets["table"].provenance, sizes, held, _azimuths_differing())


def _azimuths_differing() -> int:
    """Count the table's azimuths at which the legacy port leaves the stored answers."""
    expected = stored.load("table").digests
    actual = stored.digests(of_legacy(points.table()))
    return sum(a != b for a, b in zip(actual, expected, strict=True))


def _hold_chunk(task: tuple[str, int, int, int]) -> Held:
    """Compare one chunk of points, made where it is used: (set, seed, from, to)."""
    name, seed, start, stop = task
    oracle = find_oracle()
    if oracle is None:
        raise RuntimeError("the oracle vanished between two processes")
    if name == "random":
        at = points.random(stop - start, [seed, start])
    else:
        at = (points.table() if name == "table" else edges()).part(slice(start, stop))
    expected = of_oracle(oracle, at)
    return hold(at, expected, spread(oracle, at, expected), of_legacy(at), of_pointing(at))
