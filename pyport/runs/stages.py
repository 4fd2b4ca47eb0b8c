"""How work goes: its stages timed, its progress shown."""

from __future__ import annotations

import contextlib
import functools
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


@dataclass
class Clock:
    """Seconds spent in each stage, not counting the stages inside it.

    What runs side by side in threads counts as the stage that waits for it.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    running: list[str] = field(default_factory=list)
    since: float = 0.0

    def turn(self, stage: str | None) -> None:
        """Enter a stage, or with None leave the last one; the time so far is its owner's."""
        now = time.perf_counter()
        if self.running:
            owner = self.running[-1]
            self.seconds[owner] = self.seconds.get(owner, 0.0) + now - self.since
        self.since = now
        if stage is None:
            self.running.pop()
        else:
            self.running.append(stage)


_clock: ContextVar[Clock | None] = ContextVar("clock", default=None)


@contextlib.contextmanager
def timed() -> Iterator[Clock]:
    """Take the time of every stage that is gone through inside."""
    clock = Clock()
    token = _clock.set(clock)
    try:
        yield clock
    finally:
        _clock.reset(token)


def stage(name: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator: calls of the function are a stage of this name, where time is taken."""

    def decorate(work: Callable[P, R]) -> Callable[P, R]:
        @functools.wraps(work)
        def staged(*args: P.args, **options: P.kwargs) -> R:
            clock = _clock.get()
            if clock is None:
                return work(*args, **options)
            clock.turn(name)
            try:
                return work(*args, **options)
            finally:
                clock.turn(None)

        return staged

    return decorate


T = TypeVar("T")


def track(items: Iterable[T], what: str, total: int | None = None) -> Iterator[T]:
    """Yield `items`, showing a bar with a time estimate on standard error.

    Nothing is drawn where standard error is no terminal.
    """
    if not sys.stderr.isatty():
        yield from items
        return
    from rich.console import Console
    from rich.progress import track as rich_track

    console = Console(stderr=True)
    yield from rich_track(items, description=what, total=total, console=console, transient=True)


@contextlib.contextmanager
def working(what: str) -> Iterator[Callable[[str], None]]:
    """Show what is being done and for how long; call what this yields with the news.

    Nothing is drawn where standard error is no terminal.
    """
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
        task = shown.add_task(what)
        yield lambda news: shown.update(task, description=f"{what}: {news}")
