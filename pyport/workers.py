"""Who does the work: this process, several of this machine's, or a Dask cluster.

Whoever it is, results come in the order of the items, and what is made of them
is made here: the same items give the same answer to the last digit, however
many workers there are and whichever of them die on the way.
"""

from __future__ import annotations

import contextlib
import itertools
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

from pyport.errors import BadInput

Item = TypeVar("Item")
Result = TypeVar("Result")

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
            yield lambda call, items: _in_order(pool.submit, call, items, AHEAD * jobs)


def end_with_parent() -> None:
    """End this process when the one that started it is killed: nobody waits for its work."""
    import multiprocessing
    import os
    import threading

    def watch() -> None:
        parent = multiprocessing.parent_process()
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _in_order(
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
        told = str(error).splitlines()[0]
        raise BadInput(f"--cluster {address}: expected a Dask scheduler there ({told})") from None
    with client:

        def spread(call: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
            # What is common to all items travels once; the scheduler, which keeps the task that
            # makes it, can make it again when the worker that has it dies.
            shared = client.submit(_same, call, pure=False)
            threads = max(1, sum(client.nthreads().values()))

            def submit(_: Callable[[Item], Result], item: Item) -> Any:  # noqa: ANN401
                return client.submit(_call, shared, item, pure=False, retries=TRIES)

            return _in_order(submit, call, items, AHEAD * threads)

        yield spread


def _same(function: Callable[[Item], Result]) -> Callable[[Item], Result]:
    return function


def _call(function: Callable[[Item], Result], item: Item) -> Result:
    return function(item)
