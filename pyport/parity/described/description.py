"""What `parity.toml` says: the Fortran, its routines, the ports and what they promise."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_KIND = re.compile(r"(real|integer|logical|character)\*(\d+)$")
_SIZES = {
    "real": {4: "f4", 8: "f8"},
    "integer": {1: "i1", 2: "i2", 4: "i4", 8: "i8"},
    "logical": {4: "?", 1: "?", 2: "?", 8: "?"},
}


@dataclass(frozen=True)
class Kind:
    """A Fortran type with its length: ``real*8``, ``character*10``."""

    base: str
    size: int

    @classmethod
    def read(cls, text: str) -> Kind:
        """Return the kind that a text names.

        Raises `ValueError`: it is none that is supported; the message says which are.
        """
        found = _KIND.match(text.lower().replace(" ", ""))
        if found and (found[1] == "character" or int(found[2]) in _SIZES[found[1]]):
            return cls(found[1], int(found[2]))
        raise ValueError(
            f"kind {text!r} is not supported, expected real*4, real*8, integer*1, *2, *4 or *8, "
            "logical*1, *2, *4 or *8, or character*N"
        )

    def __str__(self) -> str:
        """Return the Fortran name."""
        return f"{self.base}*{self.size}"

    def dtype(self, *, promoted: bool = False) -> np.dtype:
        """Return the NumPy type of its values; of a build that promotes REAL*4 where `promoted`."""
        if self.base == "character":
            return np.dtype(f"S{self.size}")
        if promoted and self.base == "real":
            return np.dtype("f8")
        return np.dtype(_SIZES[self.base][self.size])

    def value(self, value: Any) -> NDArray:  # noqa: ANN401 - of any kind
        """Return what a description says, a value or a list of them, as this kind holds it."""
        if self.base == "character":
            value = str(value).ljust(self.size).encode("ascii")
        return np.asarray(value, self.dtype())


#: One value of each variable for each of n points, by the variable's name in lower case.
Batch = dict[str, NDArray]

INTENTS = ("in", "out", "inout", "result")
PROMISES = ("bits", "ulp", "spread", "within")

#: What a port is held to, in words.
PROMISE_TEXT = {
    "bits": "bit for bit",
    "ulp": "N ulp",
    "spread": "N ulp beyond the oracle's own spread",
    "within": "within a tolerance",
}


@dataclass(frozen=True)
class Variable:
    """An argument, a result, or a member of a COMMON block that a routine reads or sets.

    `name`, `label`: the Fortran name, and what reports call it.
    `kind`: its type; None for a function that is passed as an argument.
    `intent`: one of ``INTENTS``.
    `shape`: its dimensions; () for a scalar.
    `unit`: for people.
    `low`, `high`, `logarithmic`: where inputs are drawn; `logarithmic` draws the size log-uniform,
      with either sign.
    `thresholds`, `values`: where branches turn; the only values there are, where there are few.
    `fixed`: the value that it always has, else None; of an EXTERNAL the Fortran name that is
      passed.
    `python`: of an EXTERNAL, the ``module:function`` that the port gets.
    `common`: the COMMON block that it belongs to, else None.
    `limits`: where a port promises anything but bits; None for everywhere.
    `ulp`, `within`, `turn`: the promise's bound for this output (None: the port's), and a full
      turn: half a turn to either side is one angle.
    `physical`: (unit, factor, input whose cosine is a factor too or "") of a distance in other
      units.
    """

    name: str
    kind: Kind | None
    intent: str
    shape: tuple[int, ...]
    label: str
    unit: str
    low: float
    high: float
    logarithmic: bool
    thresholds: tuple[float, ...]
    values: tuple[Any, ...]
    fixed: Any
    python: str
    common: str | None
    limits: tuple[float, float] | None
    ulp: int | None
    within: float | None
    turn: float | None
    physical: tuple[str, float, str] | None

    @property
    def key(self) -> str:
        """The name in lower case, as batches have it."""
        return self.name.lower()

    @property
    def type(self) -> Kind:
        """The kind of what is no EXTERNAL."""
        if self.kind is None:
            raise TypeError(f"{self.name} is a function")
        return self.kind

    @property
    def is_input(self) -> bool:
        """Whether the caller gives it a value that varies."""
        return self.intent in {"in", "inout"} and self.fixed is None


@dataclass(frozen=True)
class Routine:
    """A subroutine or function and the ports of it."""

    name: str  #: the Fortran name; that of an ENTRY too
    #: Arguments in their order, then the result and members of COMMON blocks.
    variables: tuple[Variable, ...]
    ports: dict[str, str]  #: port -> ``module:function``
    #: `call`, `returns`: names of what a port takes and returns, in its order.
    call: tuple[str, ...]
    returns: tuple[str, ...]
    #: Whether it remembers (SAVE): points are asked in order, from a fresh start.
    sequence: bool
    reset: str  #: ``module:function`` that makes the ports forget, "" where nothing does
    note: str  #: for the report: why the port differs on purpose

    @cached_property
    def by_key(self) -> dict[str, Variable]:
        """Return its variables by their names in lower case."""
        return {one.key: one for one in self.variables}

    @property
    def inputs(self) -> list[Variable]:
        """Return the variables whose values vary from point to point."""
        return [one for one in self.variables if one.is_input]

    @property
    def outputs(self) -> list[Variable]:
        """Return the variables that it sets, in the order in which ports return them."""
        return [self.by_key[name] for name in self.returns]

    @property
    def arguments(self) -> list[Variable]:
        """Return what stands between the parentheses of a call."""
        return [one for one in self.variables if one.common is None and one.intent != "result"]

    @property
    def result(self) -> Variable | None:
        """Return the result of a function, None of a subroutine."""
        return next((one for one in self.variables if one.intent == "result"), None)


@dataclass(frozen=True)
class Port:
    """One port of the routines and what it promises.

    `absolute` is a distance at which answers are equal, for the reason written beside it; `moved`
    names the inputs whose neighbours, and `builds` the builds whose answers, make up the spread.
    """

    name: str
    promise: str
    vectorised: bool = False
    ulp: int = 0
    within: float = 0.0
    absolute: float = 0.0
    moved: tuple[str, ...] = ()
    builds: tuple[str, ...] = ()
    title: str = ""


@dataclass(frozen=True)
class Build:
    """One way to compile the files: compiler, flags, patches."""

    name: str
    flags: tuple[str, ...]
    patches: tuple[Path, ...]
    compiler: str

    @property
    def promoted(self) -> bool:
        """Whether every REAL*4 is REAL*8 in it."""
        return "-freal-4-real-8" in self.flags

    @property
    def counted(self) -> bool:
        """Whether gcov's counters are compiled into it."""
        return "--coverage" in self.flags


@dataclass(frozen=True)
class Group:
    """A set of inputs."""

    name: str
    make: str  #: "edges", "random", or ``module:function``
    draws: bool = False  #: whether the function is called with a number of points and a seed
    #: ``module:function`` of the points whose answers are stored, "" for all of them.
    sample: str = ""
    #: `keep`, `seed`: how many random points are stored, and their seed.
    keep: int = 200
    seed: int = 0
    digest: int = 0  #: points that share a digest where all answers are held by digests, else 0


@dataclass(frozen=True)
class Description:
    """A whole `parity.toml`; see ``docs/parity-kit.md`` for its keys."""

    path: Path
    name: str
    title: str
    files: tuple[Path, ...]
    include: tuple[Path, ...]
    commons: dict[str, tuple[Variable, ...]]
    builds: dict[str, Build]
    matrix: tuple[Build, ...]
    routines: tuple[Routine, ...]
    ports: tuple[Port, ...]
    groups: tuple[Group, ...]
    ledger: Path | None
    answers: Path
    survivors: Path | None
    page: dict[str, str]
    mutants: tuple[tuple[str, str, str], ...]

    @property
    def folder(self) -> Path:
        """The folder of the description, from which its paths start."""
        return self.path.parent

    @property
    def reference(self) -> Build:
        """The build that ports are held to."""
        return self.builds["reference"]

    def routine(self, name: str) -> Routine:
        """Return the routine of a name."""
        return next(one for one in self.routines if one.name == name)

    def ports_of(self, routine: Routine) -> list[Port]:
        """Return the ports that a routine has."""
        return [one for one in self.ports if one.name in routine.ports]

    @cached_property
    def digest(self) -> str:
        """Return one SHA-256 for the description and the files that it names."""
        whole = hashlib.sha256(self.path.read_bytes())
        patches = {one for build in self.builds.values() for one in build.patches}
        for path in (*self.files, *self.include, *sorted(patches)):
            whole.update(path.read_bytes() if path.is_file() else b"")
        for path in sorted(self.folder.glob("*.py")):
            whole.update(path.read_bytes())
        return whole.hexdigest()
