"""Who does the work: threads of this process, several of this machine's, or a Dask cluster.

Whoever it is, results come in the order of the items, and what is made of them
is made here: the same items give the same answer to the last digit, however
many workers there are and whichever of them die on the way.

Linear algebra keeps to one thread: on matrices as small as ours several only wait for each other.
So do estimates of noise, which are many short calls; only whole searches run side by side.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import multiprocessing
import operator
import os
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from pyport.errors import BadInput

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
Item = TypeVar("Item")
Result = TypeVar("Result")


def one_thread(work: Callable[P, Result]) -> Callable[P, Result]:
    """Return a function that keeps the linear algebra libraries to one thread while it runs."""

    @functools.wraps(work)
    def alone(*args: P.args, **options: P.kwargs) -> Result:
        with _controller(scipy="scipy.linalg" in sys.modules).limit(limits=1, user_api="blas"):
            return work(*args, **options)

    return alone


@functools.cache
def _controller(*, scipy: bool) -> ThreadpoolController:  # noqa: ARG001 - it brings one library more
    """Return what holds the libraries that are loaded; looking for them takes a millisecond."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def in_order(work: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """Yield what a function makes of each item, by as many threads as there are cores.

    The answers are those of one thread, in the items' order; who stops half-way has no more begun
    than cores can do. A process among others, each of which has a core, goes through them one by
    one.
    """
    wanted = list(items)
    several = min(len(wanted), _cores())
    if several < 2 or multiprocessing.parent_process() is not None:
        yield from map(work, wanted)
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(several) as pool:
        yield from pool.map(work, wanted)


def _cores() -> int:
    of_process = getattr(os, "sched_getaffinity", None)
    return len(of_process(0)) if of_process else os.cpu_count() or 1


#: Calls a function for each item; results come in the items' order.
Spread = Callable[[Callable[[Item], Result], Iterable[Item]], Iterator[Result]]

#: Items on their way for each worker: enough that none waits, few enough to be held.
AHEAD = 3
#: How often an item is given to another worker when those who had it died.
TRIES = 10
#: How long a cluster may take to answer. [s]
PATIENCE_S = 20


@contextlib.contextmanager
def workers(jobs: int = 1, cluster: str | None = None) -> Iterator[Spread[Any, Any]]:
    """Provide what calls a function for each item.

    `jobs`: processes of this machine.
    `cluster`: address of a Dask scheduler; its workers need pyport, and the same files under the
      same names.
    Raises `BadInput`: there is no such cluster, or no Dask.
    """
    if cluster is not None:
        with _cluster(cluster) as spread:
            yield spread
    elif jobs == 1:
        yield map
    else:
        from concurrent.futures import ProcessPoolExecutor

        with ProcessPoolExecutor(jobs, initializer=end_with_parent) as pool:
            yield lambda call, items: _ahead(pool.submit, call, items, AHEAD * jobs)


def end_with_parent() -> None:
    """End this process when the one that started it is killed: nobody waits for its work."""
    import threading

    def watch() -> None:
        parent = multiprocessing.parent_process()
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _ahead(
    submit: Callable[..., Any], call: Callable[[Item], Result], items: Iterable[Item], ahead: int
) -> Iterator[Result]:
    """Yield results in the order of the items, never more than `ahead` of them on their way."""
    rest = iter(items)
    waiting = deque(submit(call, item) for item in itertools.islice(rest, ahead))
    while waiting:
        result = waiting.popleft().result()
        waiting.extend(submit(call, item) for item in itertools.islice(rest, 1))
        yield result


@contextlib.contextmanager
def _cluster(address: str) -> Iterator[Spread[Any, Any]]:
    try:
        from distributed import Client
    except ImportError:
        raise BadInput("--cluster needs Dask: pip install 'pyport-pointing[dask]'") from None
    try:
        client = Client(address, timeout=PATIENCE_S, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = str(error).splitlines()[0]
        raise BadInput(f"--cluster {address}: expected a Dask scheduler there ({reason})") from None
    with client:

        def spread(call: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
            # What is common to all items travels once; the scheduler, which keeps the task that
            # makes it, can make it again when the worker that has it dies.
            shared = client.submit(_same, call, pure=False)
            threads = max(1, sum(client.nthreads().values()))

            def submit(_: Callable[[Item], Result], item: Item) -> Any:  # noqa: ANN401
                return client.submit(operator.call, shared, item, pure=False, retries=TRIES)

            return _ahead(submit, call, items, AHEAD * threads)

        yield spread


def _same(function: Callable[[Item], Result]) -> Callable[[Item], Result]:
    return function
