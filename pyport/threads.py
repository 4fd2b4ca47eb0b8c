"""One thread for linear algebra: on matrices as small as ours several only wait for each other."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")


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
