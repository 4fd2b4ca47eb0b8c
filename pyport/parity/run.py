"""Hold the ports to the oracle: live where it can be compiled, else to its stored answers."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import Any

from pyport.errors import BadInput
from pyport.parity.compare import Comparison, Pair
from pyport.parity.compiled import oracle, stored
from pyport.parity.compiled.stored import Stored
from pyport.parity.described import inputs
from pyport.parity.described.description import Batch, Description, Group, Port, Routine
from pyport.parity.described.functions import Answers, ask_port, part, size
from pyport.parity.described.loading import load
from pyport.parity.evidence.shrink import Fails, Minimal, failing, minimal
from pyport.parity.promise import Asker, Held, hold, kept, spread
from pyport.runs.checkpoint import Checkpoint, State, cache_folder
from pyport.runs.stages import track
from pyport.runs.workers import workers

#: Points that one process takes at a time.
CHUNK = 5000

#: (port, routine) -> how that port of that routine compares.
Results = dict[tuple[str, str], Held]


@dataclass(frozen=True)
class Parity:
    """What `pyport parity` found."""

    description: Description  #: what was compared
    #: "live" when the compiled routines were asked, "stored" for their answers on paper.
    source: str
    provenance: dict[str, Any]  #: sources, compiler, flags, C library of the oracle
    points: dict[str, int]  #: group of inputs -> number of points, of the routine that has most
    results: Results  #: every port of every routine over all of them
    #: (port, routine) -> (blocks of points whose digest is not the stored one, all blocks).
    blocks: dict[tuple[str, str], tuple[int, int]] = field(default_factory=dict)
    #: (port, routine) -> the simplest input that breaks the promise.
    minimal: dict[tuple[str, str], Minimal] = field(default_factory=dict)

    def kept(self, port: Port) -> bool:
        """Tell whether a port keeps its promise."""
        d = self.description
        return not any(self.blocks.get((port.name, r.name), (0, 0))[0] for r in d.routines) and all(
            kept(port, d.routine(name), held)
            for (of, name), held in self.results.items()
            if of == port.name
        )

    @property
    def promise_kept(self) -> bool:
        """Whether all ports keep their promises."""
        return all(self.kept(port) for port in self.description.ports)

    def comparisons(self, port: Port, what: str = "plain") -> list[Comparison]:
        """Return a port's comparisons, routine by routine and output by output."""
        return [
            one
            for (name, _), held in self.results.items()
            if name == port.name
            for one in getattr(held, what)
        ]

    def explained(self, port: Port) -> dict[str, int]:
        """Return how many of a port's answers each entry of the ledger explains, if any."""
        total: Counter[str] = Counter()
        for (name, _), held in self.results.items():
            if name == port.name:
                total.update(held.explained)
        return {entry: n for entry, n in total.items() if n}


def run(
    description: Description,
    random_points: int = 20_000,
    seed: int = 0,
    jobs: int | None = None,
    *,
    live: bool = True,
    kept_in: Path | None = None,
) -> Parity:
    """Compare the ports with the oracle.

    `description`: what to compare.
    `random_points`: how many points to draw of each group that draws, where the oracle can be
      asked.
    `seed`: seed of the random points.
    `jobs`: processes; all cores by default.
    `live`: ask the compiled routines where they can be compiled, instead of their stored answers.
    `kept_in`: where to keep how far it has come; who asks removes that when the answer is written.
    """
    if not (live and oracle.available(description)):
        return _run_stored(description)
    for build in description.builds:  # once, before several processes would compile it each
        oracle.of(description.path, build)
    sizes = inputs.sizes(description, random_points)
    chunks = [
        (str(description.path), group, routine, seed, start, min(start + CHUNK, n))
        for group, of_each in sizes.items()
        for routine, n in of_each.items()
        for start in range(0, n, CHUNK)
    ]
    about = stored.describe(description)
    so_far = Checkpoint(kept_in, about, description.digest, sizes, seed, CHUNK)
    results = over(chunks, _hold_chunk, jobs or os.cpu_count() or 1, so_far)
    points = {group: max(of_each.values()) for group, of_each in sizes.items()}
    done = Parity(description, "live", about, points, _ordered(description, results))
    return _with_minimal(done, partial(failing, description, asker(description)))


def kept_beside(report: str | None, description: Description, points: int, seed: int) -> Path:
    """Return where is kept how far a comparison has come: beside its report, or in the cache."""
    if report is None:
        return cache_folder() / f"parity-{description.name}-{points}-{seed}.npz"
    return Path(report).with_name(f"{Path(report).name}.unfinished.npz")


def over(
    chunks: Sequence[Any], hold_one: Callable[[Any], Results], jobs: int, so_far: Checkpoint
) -> Results:
    """Add up what holds at each chunk, in their order, from where it was killed the last time."""
    state = so_far.load()
    saved: dict[str, Any] = {"done": 0, "results": []} if state is None else state[0]
    done = saved["done"]
    results = {(port, name): Held.from_json(held) for port, name, held in saved["results"]}
    with workers(jobs) as spread_over:
        parts = spread_over(hold_one, chunks[done:])
        for some in track(parts, "Comparing", total=len(chunks) - done):
            results = added(results, some)
            done += 1
            now = done, results
            so_far.offer(lambda: _as_state(*now))  # noqa: B023 - called at once
    return results


def added(results: Results, some: Results) -> Results:
    """Return two results as one."""
    return results | {k: results[k] + v if k in results else v for k, v in some.items()}


def _as_state(done: int, results: Results) -> State:
    listed = [[*key, held.as_json()] for key, held in results.items()]
    return {"done": done, "results": listed}, {}


def _ordered(description: Description, results: Results) -> Results:
    return {
        (port.name, routine.name): results[port.name, routine.name]
        for port in description.ports
        for routine in description.routines
        if (port.name, routine.name) in results
    }


@cache
def _described(path: str) -> Description:
    return load(path)


def _hold_chunk(task: tuple[str, str, str, int, int, int]) -> Results:
    """Compare one chunk of points, made where it is used."""
    path, group_name, routine_name, seed, start, stop = task
    description = _described(path)
    routine = description.routine(routine_name)
    group = next(one for one in description.groups if one.name == group_name)
    if group.draws:
        batch = inputs.points(description, group, routine, stop - start, [seed, start])
    else:
        batch = part(inputs.points(description, group, routine, 0, 0), slice(start, stop))
    return hold_live(description, routine, batch)


def hold_live(description: Description, routine: Routine, batch: Batch) -> Results:
    """Compare every port of a routine with the compiled one at some points."""
    ask = asker(description)
    expected = ask("reference", routine, batch)
    results = {}
    for port in description.ports_of(routine):
        actual = ask_port(description, port, routine, batch)
        span = spread(port, routine, batch, expected, ask) if port.promise == "spread" else None
        pair = Pair(routine, batch, expected, actual, actual.raised)
        results[port.name, routine.name] = hold(description, port, pair, span)
    return results


def _ask(description: Description, build: str, routine: Routine, batch: Batch) -> Batch:
    return oracle.of(description.path, build).ask(routine, batch)


def hold_stored(
    description: Description, routine: Routine, known: Stored, answers: Callable[..., Answers]
) -> Results:
    """Compare every port of a routine with stored answers; `answers` asks a port."""
    results = {}
    for port in description.ports_of(routine):
        actual = answers(description, port, routine, known.batch)
        pair = Pair(routine, known.batch, known.answers, actual, actual.raised)
        results[port.name, routine.name] = hold(description, port, pair, known.spread)
    return results


def _run_stored(description: Description) -> Parity:
    results: Results = {}
    blocks = {}
    points: dict[str, int] = {}
    provenance: dict[str, Any] = {}
    for group in description.groups:
        for routine in description.routines:
            known = stored.load(description, group, routine)
            provenance = provenance or known.provenance
            points[group.name] = max(points.get(group.name, 0), size(known.batch))
            results = added(results, hold_stored(description, routine, known, ask_port))
            for port in description.ports_of(routine):
                if known.digests and port.promise == "bits":
                    differing = _blocks_differing(description, group, routine, port, known)
                    blocks[port.name, routine.name] = differing, len(known.digests)
    if not results:
        raise BadInput("no routine has a port: nothing to compare", description.path)
    done = Parity(description, "stored", provenance, points, _ordered(description, results), blocks)
    return _with_minimal(done, None)


def _blocks_differing(
    description: Description, group: Group, routine: Routine, port: Port, known: Stored
) -> int:
    """Count the blocks of a whole group at which a port leaves the stored answers."""
    answers = ask_port(description, port, routine, stored.whole(description, group, routine))
    actual = stored.digests(routine, group, answers)
    return sum(a != b for a, b in zip(actual, known.digests, strict=True))


def asker(description: Description) -> Asker:
    """Return what asks a build of a description, compiled once in each process."""
    return partial(_ask, description)


def _with_minimal(done: Parity, fails: Fails | None) -> Parity:
    """Add the simplest input for each broken promise; on paper the worst one is all there is."""
    d = done.description
    for (port_name, name), held in done.results.items():
        port = next(one for one in d.ports if one.name == port_name)
        routine = d.routine(name)
        if not kept(port, routine, held):
            done.minimal[port_name, name] = minimal(port, routine, held, fails)
    return done
