"""Ask the compiled Fortran, in a process of its own: it may stop, crash, or change the rounding."""

from __future__ import annotations

import os
import shutil
import tempfile
from functools import cache
from importlib.machinery import ExtensionFileLoader, ModuleSpec
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.parity.compiled import build as building
from pyport.parity.compiled import driver
from pyport.parity.described.description import Batch, Build, Description, Routine
from pyport.parity.described.functions import filled, part, size, spelled
from pyport.runs.workers import end_with_parent

#: A process that has loaded so many copies of a library makes room for a new one.
MOST_COPIES = 500


class Oracle:
    """A compiled library and the process that calls it.

    `description`, `build`: what was compiled, and how.
    `library`: the compiled library; compiled, or found in the cache, unless given.
    """

    def __init__(self, description: Description, build: Build, library: Path | None = None):
        self.description, self.build = description, build
        self.library = library or building.library(description, build)
        self._child: _Child | None = None

    def ask(self, routine: Routine, batch: Batch) -> Batch:
        """Return what a routine answers: an array for each of its outputs.

        Raises `BadInput`: it ends the process, changes an argument that is only its input, or
          `batch` holds numbers that its kinds cannot hold.
        """
        arrays = self._arrays(routine, batch)
        try:
            after = self._call(routine, arrays)
        except EOFError:
            self._child = None
            raise self._ended(routine, batch) from None
        changed = [
            one.name
            for one, was, now in zip(driver.passed(routine), arrays, after, strict=True)
            if one.intent == "in" and was.tobytes() != now.tobytes()
        ]
        if changed:
            raise BadInput(
                f"{routine.name} changes its argument {changed[0]}, which is described as intent "
                "in: expected inout",
                self.description.path,
            )
        answers = dict(zip([one.key for one in driver.passed(routine)], after, strict=True))
        return {one.key: answers[one.key] for one in routine.outputs}

    def close(self) -> None:
        """End the process."""
        if self._child is not None and self._child.parent == os.getpid():
            self._child.end()
        self._child = None

    def _arrays(self, routine: Routine, batch: Batch) -> list[NDArray]:
        whole = filled(routine, batch)
        arrays = []
        for one in driver.passed(routine):
            given = np.asarray(whole[one.key])
            wanted = one.type.dtype(promoted=self.build.promoted)
            with np.errstate(over="ignore"):
                array = given.astype(wanted)
            if given.dtype.kind == "f" and array.dtype.itemsize < given.dtype.itemsize:
                same = (array == given) | (np.isnan(array) & np.isnan(given))
                if not same.all():
                    wrong = given[~same].flat[0]
                    raise BadInput(f"{one.name}: {wrong!r} is no {one.type}")
            arrays.append(array)
        return arrays

    def _call(self, routine: Routine, arrays: list[NDArray]) -> list[NDArray]:
        # a process that was forked from this one has the object, and no process of its own yet
        if self._child is None or self._child.parent != os.getpid():
            self._child = _Child()
        elif self._child.copies > MOST_COPIES:
            self._child.end()
            self._child = _Child()
        number = self.description.routines.index(routine)
        return self._child.call(str(self.library), number, arrays, fresh=routine.sequence)

    def _ended(self, routine: Routine, batch: Batch) -> BadInput:
        """Return the error that names the first input at which the process ends."""
        low, high = 0, size(batch)
        while high - low > 1:
            middle = (low + high) // 2
            try:
                self._call(routine, self._arrays(routine, part(batch, slice(low, middle))))
                low = middle
            except EOFError:
                self._child = None
                high = middle
        at = " ".join(f"{k}={v}" for k, v in spelled(routine, batch, low).items())
        return BadInput(
            f"{routine.name} ends the program (STOP, or a crash) at {at}: expected a range of "
            "inputs that it answers"
        )


class _Child:
    """A process that calls libraries; one pipe to it, no threads on this side.

    It is started anew and not forked: a fork would hold open what this process has open.
    """

    def __init__(self) -> None:
        self.parent = os.getpid()
        self.copies = 0
        context = get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()

    def call(self, path: str, number: int, arrays: list[NDArray], *, fresh: bool) -> list[NDArray]:
        """Return the arrays after the call.

        Raises `EOFError`: the process ended.
        """
        self.copies += fresh
        try:
            self._pipe.send((path, number, arrays, fresh))
            answer: list[NDArray] = self._pipe.recv()
        except OSError as error:
            raise EOFError(str(error)) from None
        return answer

    def end(self) -> None:
        """End the process and wait for it."""
        self._pipe.close()
        self._process.terminate()
        self._process.join()


def _serve(pipe: Connection) -> None:
    end_with_parent()
    while True:
        try:
            path, number, arrays, fresh = pipe.recv()
        except EOFError:
            return
        # a fresh copy of a library has nothing saved yet
        pipe.send(call(_fresh(path) if fresh else _loaded(path), number, arrays))


def imported(path: str) -> ModuleType:
    """Import the extension module that f2py made, from wherever it is."""
    loader = ExtensionFileLoader(driver.MODULE, path)
    module = loader.create_module(ModuleSpec(driver.MODULE, loader, origin=path))
    loader.exec_module(module)
    return module


_loaded = cache(imported)


def call(library: ModuleType, number: int, arrays: list[NDArray]) -> list[NDArray]:
    """Call the loop of that number; return its arrays as they are afterwards.

    What f2py gets has the loop's types and Fortran's order of elements, so it copies nothing.
    """
    passed = [_flat(array) for array in arrays]
    if not len(arrays[0]):  # f2py takes no array without elements for one of Fortran's
        return [_unflat(before, after) for before, after in zip(arrays, passed, strict=True)]
    getattr(library, driver.entry(number))(len(arrays[0]), *passed)
    return [_unflat(before, after) for before, after in zip(arrays, passed, strict=True)]


def _flat(array: NDArray) -> NDArray:
    """Return a copy as the loop takes it: LOGICAL as INTEGER, CHARACTER as bytes, points last."""
    if array.dtype.kind == "b":
        array = array.astype(np.int32)
    elif array.dtype.kind == "S":
        array = np.ascontiguousarray(array).view(np.int8).reshape(len(array), -1)
    return np.array(np.moveaxis(array, 0, -1), order="F")


def _unflat(before: NDArray, after: NDArray) -> NDArray:
    """Return an array of the loop with the type and order of the one that was given."""
    back = np.ascontiguousarray(np.moveaxis(after, -1, 0))
    if before.dtype.kind == "S":
        return back.view(before.dtype).reshape(before.shape)
    return back != 0 if before.dtype.kind == "b" else back


def _fresh(path: str) -> ModuleType:
    handle, copy = tempfile.mkstemp(suffix=".so")
    os.close(handle)
    try:
        shutil.copy(path, copy)
        return imported(copy)
    finally:
        Path(copy).unlink()


@cache
def of(description_path: Path, build: str) -> Oracle:
    """Return the oracle of a description's build in this process."""
    from pyport.parity.described.loading import load

    description = load(description_path)
    return Oracle(description, description.builds[build])


def available(description: Description) -> bool:
    """Tell whether the Fortran is there, and what compiles and wraps it.

    Raises `BadInput`: the Fortran is not there, nor are stored answers that could stand in for it;
      or there is no compiler, or no header of Python's, and ``PYPORT_ORACLE=required`` in the
      environment.
    """
    gone = next((one for one in description.files if not one.is_file()), None)
    if gone is not None:
        if description.answers.is_dir():  # installed without its Fortran
            return False
        raise BadInput(f"{gone} is not there: expected a Fortran file", description.path)
    lacking = building.lacking(description.reference.compiler)
    if lacking and os.environ.get("PYPORT_ORACLE") == "required":
        raise BadInput(f"{lacking} is required (PYPORT_ORACLE), and not on this machine")
    return not lacking
