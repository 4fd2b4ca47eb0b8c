"""A long comparison that can be killed and goes on where it was."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pyport.checkpoint import Checkpoint, State, cache_folder
from pyport.parity.compare import Comparison, Worst
from pyport.parity.held import Held
from pyport.progress import track
from pyport.workers import workers

_COMPARISONS = ("legacy", "pointing", "sky", "beyond")


def kept_beside(report: str | None, points: int, seed: int) -> Path:
    """Return where is kept how far a comparison has come: beside its report, or in the cache."""
    if report is None:
        return cache_folder() / f"parity-{points}-{seed}.npz"
    return Path(report).with_name(f"{Path(report).name}.unfinished.npz")


def over(
    chunks: Sequence[Any], hold: Callable[[Any], Held], jobs: int, kept: Checkpoint
) -> Held | None:
    """Add up what holds at each chunk, in their order, from where it was killed the last time."""
    state = kept.load()
    done, held = (0, None) if state is None else (state[0]["done"], _of_state(state))
    with workers(jobs) as spread:
        parts = spread(hold, chunks[done:])
        for part in track(parts, "Comparing", total=len(chunks) - done):
            held = part if held is None else held + part
            done += 1
            now = done, held
            kept.offer(lambda: _as_state(*now))  # noqa: B023 - called at once
    return held


def _as_state(done: int, held: Held) -> State:
    told = {name: [_told(one) for one in getattr(held, name)] for name in _COMPARISONS}
    return {"done": done, "explained": held.explained, **told}, {}


def _of_state(state: State) -> Held:
    told, _ = state
    some = {name: [_comparison(one) for one in told[name]] for name in _COMPARISONS}
    return Held(**some, explained=Counter(told["explained"]))


def _told(one: Comparison) -> dict[str, Any]:
    worst = None if one.worst is None else vars(one.worst)
    return vars(one) | {"worst": worst, "counts": list(one.counts.items())}


def _comparison(told: dict[str, Any]) -> Comparison:
    worst = told["worst"]
    if worst is not None:
        worst = Worst(**worst | {"p": tuple(worst["p"])})
    counts = Counter(dict(told["counts"]))
    return Comparison(told["routine"], told["output"], counts, worst, told["arcsec"])
