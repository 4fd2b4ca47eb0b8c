"""The oracle's answers on paper: hexadecimal floats in JSON, with where they came from.

They hold the ports where no Fortran compiler is. One file for each group of inputs and routine; a
file whose numbers stay the same is left alone, its provenance too: the header says which build
first gave the numbers, and any build that gives them again is the same program.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import platform
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.files import write_file
from pyport.parity.compiled import build
from pyport.parity.compiled.oracle import Oracle
from pyport.parity.described import inputs
from pyport.parity.described.description import Batch, Description, Group, Port, Routine, Variable
from pyport.parity.described.functions import size, spell, unspell
from pyport.parity.promise import Spread, spread

SCHEMA = "pyport.oracle/2"


@dataclass(frozen=True)
class Stored:
    """One stored set of n points."""

    #: `batch`, `answers`: the points and what the oracle answered, by variable.
    batch: Batch
    answers: Batch
    spread: Spread  #: the least and greatest of its own answers there
    provenance: dict[str, Any]  #: sources, compiler, flags, C library
    #: One for each block of the whole group, where the set is but a sample of it, else empty.
    digests: list[str]


def path_of(description: Description, group: Group, routine: Routine) -> Path:
    """Return the file of a stored set."""
    return description.answers / f"{group.name}-{routine.name.lower()}.json"


def load(description: Description, group: Group, routine: Routine) -> Stored:
    """Read a stored set.

    Raises `BadInput`: there is none, or it cannot be read.
    """
    path = path_of(description, group, routine)
    expected = "expected the oracle's stored answers, as `pyport parity golden` writes them"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError:
        raise BadInput(f"is not there: {expected}", path) from None
    except ValueError as error:
        raise BadInput(f"no JSON ({error}): {expected}", path) from None
    if content.get("schema") != SCHEMA:
        raise BadInput(f"expected schema {SCHEMA}, found {content.get('schema')}", path)
    try:
        return _read(content, routine)
    except (KeyError, IndexError, ValueError, TypeError) as error:
        raise BadInput(f"not the answers of {routine.name} ({error!r}): {expected}", path) from None


def _read(content: dict[str, Any], routine: Routine) -> Stored:
    columns = list(zip(*content["rows"], strict=True))
    taken = iter(columns)
    batch = {}
    for one in routine.inputs:
        texts: list = list(next(taken))
        if one.shape:
            table = unspell(content["arrays"][one.key], one.type, one.shape)
            batch[one.key] = table[np.array(texts)]
        else:
            batch[one.key] = unspell(texts, one.type)
    if not batch:
        batch[""] = np.zeros(len(content["rows"]), dtype=np.int8)
    values = [
        {one.key: unspell(next(taken), one.type, one.shape) for one in outputs}
        for outputs in (routine.outputs, _reals(routine), _reals(routine))
    ]
    answers, least, greatest = values
    span = {k: (least.get(k, v), greatest.get(k, v)) for k, v in answers.items()}
    return Stored(batch, answers, span, content["provenance"], content["digests"])


def _reals(routine: Routine) -> list[Variable]:
    return [one for one in routine.outputs if one.type.base == "real"]


def write(
    description: Description, group: Group, routine: Routine, oracles: dict[str, Oracle]
) -> bool:
    """Write a stored set; leave a file alone that already holds the same. Tell if written."""
    path = path_of(description, group, routine)
    if group.draws and path.exists():  # the random points, once drawn, are those in the file
        batch = load(description, group, routine).batch
    else:
        batch = inputs.sample(description, group, routine)
    reference = oracles["reference"]
    answers = reference.ask(routine, batch)
    widest = next((p for p in description.ports_of(routine) if p.promise == "spread"), None)
    span = spread(
        widest or Port("", "bits"), routine, batch, answers, lambda b, r, at: oracles[b].ask(r, at)
    )
    arrays: dict[str, list[Any]] = {}
    columns: list[Any] = []
    for one in routine.inputs:
        if one.shape:
            flat = batch[one.key].reshape(size(batch), -1)
            rows, which = np.unique(_as_bytes(flat), return_inverse=True)
            first = [int(np.flatnonzero(which == k)[0]) for k in range(len(rows))]
            arrays[one.key] = [spell(flat[k]) for k in first]
            columns.append(which.tolist())
        else:
            columns.append([spell(v) for v in batch[one.key]])
    columns += [[spell(v) for v in answers[one.key]] for one in routine.outputs]
    for side in (0, 1):
        columns += [[spell(v) for v in span[one.key][side]] for one in _reals(routine)]
    names = [one.name for one in routine.inputs] + [one.label for one in routine.outputs]
    names += [f"{o.label} {what}" for what in ("least", "greatest") for o in _reals(routine)]
    content = {
        "schema": SCHEMA,
        "provenance": describe(description),
        "units": {one.name: one.unit for one in routine.variables if one.unit},
        "columns": names,
        "digests": digests(
            routine, group, reference.ask(routine, whole(description, group, routine))
        )
        if group.digest
        else [],
        "arrays": arrays,
        "rows": [list(row) for row in zip(*columns, strict=True)],
    }
    if path.exists():
        old = json.loads(path.read_text(encoding="utf-8"))
        if {**old, "provenance": None} == {**content, "provenance": None}:
            return False
    write_file(path, one_row_a_line(content))
    return True


def _as_bytes(flat: NDArray) -> NDArray:
    """Return each row as one value that compares by its bits."""
    flat = np.ascontiguousarray(flat)
    return flat.view(np.dtype((np.void, flat.dtype.itemsize * flat.shape[1]))).ravel()


def whole(description: Description, group: Group, routine: Routine) -> Batch:
    """Return all points of a group that is held by digests."""
    return inputs.points(description, group, routine, 0, 0)


def digests(routine: Routine, group: Group, answers: Batch) -> list[str]:
    """Return one digest for each block of `group.digest` points."""
    n = size(answers)
    rows = np.concatenate(
        [
            _as_bytes(answers[one.key].reshape(n, -1))[:, None].view(np.uint8)
            for one in routine.outputs
        ],
        axis=1,
    )
    blocks = [rows[i : i + group.digest] for i in range(0, n, group.digest)]
    return [hashlib.sha256(block.tobytes()).hexdigest()[:16] for block in blocks]


def one_row_a_line(content: dict[str, Any]) -> str:
    """Return JSON that a line-by-line comparison reads well."""
    parts = []
    for key, value in content.items():
        if isinstance(value, list) and value:
            rows = ",\n".join("  " + json.dumps(row) for row in value)
            parts.append(f'"{key}": [\n{rows}\n ]')
        else:
            parts.append(f'"{key}": {json.dumps(value, indent=2)}')
    return "{\n " + ",\n ".join(parts) + "\n}\n"


@cache
def maths_library() -> str:
    """Return a fingerprint of the C library's functions, as ports and Fortran call them.

    Where two machines' fingerprints agree their answers must agree bit for bit; another C library,
    or another processor's variant of it, may round a sine the other way.
    """
    library = ctypes.CDLL(None)

    def called(name: str, kind: type, divisor: float = 1.0) -> list[float]:
        function = getattr(library, name)
        function.argtypes, function.restype = [kind], kind
        return [float(function(float(x) / divisor)) for x in arguments]

    arguments = np.linspace(-7, 7, 4001).astype(np.float32)
    double = [called(name, ctypes.c_double) for name in ("sin", "cos", "atan")]
    single = [called(name, ctypes.c_float) for name in ("sinf", "cosf", "tanf")]
    arcs = [called("asin", ctypes.c_double, 7)]
    results = np.array([*double, *single, *arcs], dtype="<f8")
    return hashlib.sha256(results.tobytes()).hexdigest()[:16]


def describe(description: Description) -> dict[str, Any]:
    """Return where the oracle's answers come from: sources, compiler, flags, C library."""
    return {
        **build.provenance(description, description.reference),
        "libc": " ".join(platform.libc_ver()),
        "machine": platform.machine(),
        "maths_library": maths_library(),
    }
