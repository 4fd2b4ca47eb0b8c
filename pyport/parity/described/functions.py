"""Find the Python functions that a description names, and call a port with a batch."""

from __future__ import annotations

import importlib
import sys
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.parity.described.description import Batch, Description, Kind, Port, Routine, Variable

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


Function = Callable[..., Any]


def resolve(description: Description, name: str) -> Function:
    """Return the function that ``module:function`` names.

    Modules beside the description come first: its folder is put on Python's path.

    Raises `BadInput`: there is no such module or function.
    """
    folder = str(description.folder.resolve())
    if folder not in sys.path:
        sys.path.insert(0, folder)
    module_name, _, function_name = name.partition(":")
    try:
        module = importlib.import_module(module_name)
    except ImportError as error:
        raise BadInput(
            f"{name}: {error}: expected a module beside the description, or an installed one",
            description.path,
        ) from None
    except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever a module does when imported
        at = traceback.extract_tb(error.__traceback__)[-1]
        known = isinstance(error, SyntaxError) or "importlib" in at.filename
        place = "" if known else f" ({Path(at.filename).name}, line {at.lineno})"
        raise BadInput(
            f"{name}: {type(error).__name__}: {error}{place}: expected a module to import",
            description.path,
        ) from None
    function = getattr(module, function_name, None)
    if not callable(function):
        raise BadInput(f"{name}: no function {function_name!r} in that module", description.path)
    return function


class Answers(dict[str, NDArray]):
    """A port's answers by output; `raised` says at which points it raised what instead."""

    def __init__(self, *arguments: Any):  # noqa: ANN401 - a dict's
        super().__init__(*arguments)
        self.raised: dict[int, str] = {}


def ask_port(
    description: Description,
    port: Port,
    routine: Routine,
    batch: Batch,
    function: Function | None = None,
) -> Answers:
    """Return what a port answers at each point, each output as the kind that Fortran stores.

    An exception of a port that is called point by point is its answer there.

    `description`, `port`, `routine`, `batch`: whom to ask about what.
    `function`: the port's function; the one that the description names unless given.
    """
    function = function or resolve(description, routine.ports[port.name])
    if routine.reset:
        resolve(description, routine.reset)()
    variables = [routine.by_key[name] for name in routine.call]
    n = size(batch)
    columns = [
        _column(description, one, batch, n, scalars=not port.vectorised) for one in variables
    ]
    if port.vectorised:
        try:
            with np.errstate(all="ignore"):
                value = function(*columns)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever a port raises
            raise BadInput(
                f"{routine.ports[port.name]} raised {type(error).__name__}: {error}, expected "
                "answers: it is vectorised, and is called once with all points",
                description.path,
            ) from None
        returned = _returned(routine, value, port)
        return Answers(
            {
                one.key: _stored(one, value, (n, *one.shape), routine, port)
                for one, value in zip(routine.outputs, returned, strict=True)
            }
        )
    answers = Answers({one.key: constant(one, n) for one in routine.outputs})
    mutable = [one.key for one in variables if one.shape]
    with np.errstate(all="ignore"):
        for i, arguments in enumerate(zip(*columns, strict=True) if columns else [()] * n):
            own = [a.copy() if v.shape else a for a, v in zip(arguments, variables, strict=True)]
            try:
                value = function(*own)
            # One that ends the program would end the comparison, and with 0 pass for equal.
            except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever it raises
                answers.raised[i] = f"{type(error).__name__}: {error}"
                continue
            if value is None:  # it changed its arrays in place, as the Fortran does
                changed = dict(zip([v.key for v in variables], own, strict=True))
                if all(one.key in mutable for one in routine.outputs):
                    value = tuple(changed[one.key] for one in routine.outputs)
            for one, found in zip(routine.outputs, _returned(routine, value, port), strict=True):
                answers[one.key][i] = _one(one, found, routine, port)
    return answers


def _column(description: Description, one: Variable, batch: Batch, n: int, *, scalars: bool) -> Any:  # noqa: ANN401 - an array, or a list of Python's values
    """Return an argument's values as Python counts them: float for REAL*8, str for CHARACTER."""
    if one.kind is None:
        function = resolve(description, one.python) if one.python else None
        return [function] * n
    values = batch.get(one.key)
    if values is None:
        values = constant(one, n)
    if one.shape or not scalars:
        return values
    if values.dtype.kind == "S":
        return [v.decode("ascii", "replace").ljust(one.type.size) for v in values.tolist()]
    # a REAL*4 stays one: a Python float would hide its roundings
    return values if values.dtype == np.float32 else values.tolist()


def _returned(routine: Routine, value: Any, port: Port) -> tuple[Any, ...]:  # noqa: ANN401
    wanted = routine.outputs
    if len(wanted) == 1:
        return (value,)
    if not isinstance(value, tuple | list) or len(value) != len(wanted):
        got = f"{len(value)} values" if isinstance(value, tuple | list) else f"{value!r:.60}"
        raise BadInput(
            f"{routine.ports[port.name]} returned {got}, expected {len(wanted)}: "
            f"{', '.join(one.name for one in wanted)}"
        )
    return tuple(value)


def _one(one: Variable, value: Any, routine: Routine, port: Port) -> Any:  # noqa: ANN401
    if one.type.base == "character" and isinstance(value, str):
        return value.ljust(one.type.size)[: one.type.size].encode("ascii", "replace")
    stored = _stored(one, value, one.shape, routine, port)
    return stored if one.shape else stored[()]


def _stored(
    one: Variable,
    value: Any,  # noqa: ANN401 - whatever a port returned
    shape: tuple[int, ...],
    routine: Routine,
    port: Port,
) -> NDArray:
    try:
        with np.errstate(all="ignore"):  # what REAL*8 holds may be infinite in REAL*4
            return np.asarray(value).astype(one.type.dtype()).reshape(shape)
    except (TypeError, ValueError, OverflowError):
        raise BadInput(
            f"{routine.ports[port.name]} returned {value!r:.60} as {one.name}, expected {one.type}"
            + (f" of shape {shape}" if shape else "")
        ) from None
