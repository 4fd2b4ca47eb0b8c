"""One thread for linear algebra: on matrices as small as ours several only wait for each other.

Whole estimates of noise that do not ask each other run side by side instead.
"""

from __future__ import annotations

import functools
import multiprocessing
import os
import sys
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")
Item = TypeVar("Item")


def one_thread(work: Callable[P, R]) -> Callable[P, R]:
    """Return a function that keeps the linear algebra libraries to one thread while it runs."""

    @functools.wraps(work)
    def alone(*args: P.args, **options: P.kwargs) -> R:
        with _controller(scipy="scipy.linalg" in sys.modules).limit(limits=1, user_api="blas"):
            return work(*args, **options)

    return alone


@functools.cache
def _controller(*, scipy: bool) -> ThreadpoolController:  # noqa: ARG001 - it brings one library more
    """Return what holds the libraries that are loaded; looking for them takes a millisecond."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def side_by_side(work: Callable[[Item], R], items: Iterable[Item]) -> list[R]:
    """Return what a function makes of each item, by as many threads as there are cores.

    The answers are those of one thread, in the items' order. A process among others, each of which
    has a core, goes through them one by one.
    """
    wanted = list(items)
    several = min(len(wanted), _cores())
    if several < 2 or multiprocessing.parent_process() is not None:
        return [work(one) for one in wanted]
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(several) as pool:
        return list(pool.map(work, wanted))


def _cores() -> int:
    of_process = getattr(os, "sched_getaffinity", None)
    return len(of_process(0)) if of_process else os.cpu_count() or 1
