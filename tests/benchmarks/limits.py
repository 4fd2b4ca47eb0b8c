"""What work cannot be done without: its bytes and functions, counted, and then taken alone."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pyarrow.parquet import ParquetFile

from pyport.pointing import kernel

#: Points that functions are taken of at a time: they stay in the second cache.
BLOCK = 16384
_NUMPYS = {"sine": np.sin, "arcsine": np.arcsin, "arctangent": np.arctan2}
_KERNELS = {"sine": 0, "arcsine": 2, "arctangent": 3}


@dataclass(frozen=True)
class Limit:
    """What is unavoidable: a call that does nothing else, and what was counted, in words."""

    take: Callable[[], object]
    counted: str


def of_points(count: int, *, angles: bool, functions: tuple[str, ...]) -> Limit:
    """Return the limit of work on points: two numbers come in where they are read, two go out.

    Parameters
    ----------
    count
        How many points.
    angles
        Whether each point has its angles, or they are those of a grid's axes.
    functions
        What the geometry asks for, a point; a sine comes with its cosine.
    """
    numbers = np.linspace(0.1, 0.9, 2 * (count if angles else BLOCK)).reshape(2, -1)
    # Written once before: what fresh pages cost depends on how scattered the memory is by then.
    room, out = np.ones(BLOCK), np.ones((2, count))

    def take() -> None:
        for low in range(0, count, BLOCK):
            some = out[:, low : low + BLOCK]
            y, x = numbers[:, low : low + BLOCK] if angles else numbers[:, : some.shape[1]]
            for name in functions:
                _each(name, y, x, room[: len(x)])
            np.copyto(some[0], y)
            np.copyto(some[1], x)

    read = 32 if angles else 16
    return Limit(take, f"{read} bytes and {len(functions)} functions a point")


def _each(name: str, y: np.ndarray, x: np.ndarray, out: np.ndarray) -> None:
    """Take a function of numbers, by the same path as the program."""
    if kernel.KERNEL is None:
        function = _NUMPYS[name]
        function(*(y, x)[-function.nin :], out=out)
    else:
        kernel.KERNEL.elementary(_KERNELS[name], y, x, out)


def of_rounds(rounds: int, points: int, columns: int) -> Limit:
    """Return the limit of a robust fit: a median and products of columns in each round."""
    rng = np.random.default_rng(0)
    of, weight = rng.normal(size=(columns, points)), np.ones(points)
    residual = rng.normal(size=2 * points)

    def take() -> None:
        for _ in range(rounds):
            np.median(np.abs(residual))
            for axis in (residual[:points], residual[points:]):
                kernel.gram(of, weight, axis)

    return Limit(take, f"{rounds} rounds: a median, products of {columns} columns of either axis")


def of_data_set(root: Path) -> Limit:
    """Return the limit of two passes over a data set: what pyarrow takes to read it twice."""

    def take() -> None:
        for path in [*root.rglob("*.parquet")] * 2:
            for batch in ParquetFile(path).iter_batches(use_threads=False):
                batch.num_rows  # noqa: B018 - it is there

    return Limit(take, "the same bytes by pyarrow, in one thread")


def of_process(code: str, counted: str) -> Limit:
    """Return the limit of a process: what Python does before anything of the program."""
    return Limit(lambda: subprocess.run([sys.executable, "-c", code], check=True), counted)
