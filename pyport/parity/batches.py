"""Inputs and answers: a batch of n points, and how its numbers are spelled to the last bit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.parity.description import Batch, Routine, Variable
from pyport.parity.kinds import Kind

#: Texts of one value: one for a scalar, a list for an array.
Spelling = str | list[str]


def size(batch: Batch) -> int:
    """Return the number of points."""
    return len(next(iter(batch.values())))


def part(batch: Batch, which: slice | NDArray) -> Batch:
    """Return some of the points."""
    return {key: values[which] for key, values in batch.items()}


def joined(batches: Sequence[Batch]) -> Batch:
    """Return all points of several batches, one after the other."""
    return {key: np.concatenate([one[key] for one in batches]) for key in batches[0]}


def inputs_of(routine: Routine, batch: Batch) -> Batch:
    """Return of a batch what a routine takes, each as its kind.

    Raises `BadInput`: an input is missing or has another shape.
    """
    result = {}
    for one in routine.inputs:
        if one.key not in batch:
            raise BadInput(f"the points have no {one.key!r}: {routine.name} takes it")
        values = np.asarray(batch[one.key])
        if values.shape[1:] != one.shape:
            raise BadInput(
                f"{one.key!r} of the points has shape {values.shape}, expected (n, "
                f"{', '.join(map(str, one.shape))}) as {routine.name} takes it"
            )
        with np.errstate(over="ignore"):
            result[one.key] = values.astype(one.type.dtype())
    if not result:  # a routine without inputs answers one thing
        result[""] = np.zeros(size(batch) if batch else 1, dtype=np.int8)
    return result


def filled(routine: Routine, batch: Batch) -> Batch:
    """Return a batch with every variable: outputs hold what tells that nothing was set."""
    n = size(batch)
    return batch | {
        one.key: constant(one, n)
        for one in routine.variables
        if one.kind is not None and one.key not in batch
    }


def constant(one: Variable, n: int) -> NDArray:
    """Return the values of what does not vary: the fixed value, or NaN and the like of outputs."""
    value: Any = one.fixed
    if value is None:
        value = {"real": np.nan, "integer": -1, "logical": False, "character": "?" * one.type.size}[
            one.type.base
        ]
    return np.array(np.broadcast_to(one.type.value(value), (n, *one.shape)))


def hexadecimal(value: float) -> str:
    """Return a number as the shortest hexadecimal literal that ``float.fromhex`` reads back."""
    mantissa, p, exponent = float(value).hex().partition("p")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").rstrip(".")
    return mantissa + p + exponent


def spell(value: Any) -> Spelling:  # noqa: ANN401 - a value of any kind
    """Return a value of any kind as text that keeps every bit."""
    array = np.asarray(value)
    if array.ndim:
        return [str(spell(one)) for one in array.ravel()]
    if array.dtype.kind == "f":
        return hexadecimal(float(array))
    if array.dtype.kind == "S":
        return bytes(array.item()).decode("ascii", "replace")
    return str(array.item())


def unspell(texts: Sequence[Spelling], kind: Kind, shape: tuple[int, ...] = ()) -> NDArray:
    """Return the values that `spell` wrote, one for each of n points."""
    dtype = kind.dtype()
    convert: Any = float.fromhex
    if kind.base != "real":
        convert = {"integer": int, "logical": "True".__eq__, "character": str.encode}[kind.base]
    flat = [
        [convert(one) for one in (text if isinstance(text, list) else [text])] for text in texts
    ]
    with np.errstate(over="ignore"):
        values = np.array(flat, dtype=dtype)
    if kind.base == "character":
        values = np.char.ljust(values, kind.size)
    return values.reshape(len(texts), *shape)


def spelled(routine: Routine, batch: Batch, number: int) -> dict[str, Spelling]:
    """Return the inputs of one point by their Fortran names, every bit kept."""
    return {one.name: spell(batch[one.key][number]) for one in routine.inputs}
