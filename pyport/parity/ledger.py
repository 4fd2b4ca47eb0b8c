"""The ledger of deviations: where the published routines leave their own equations, and why.

Its file has a row for each cause: an input, the routine's answer and the true value. A row with a
`region`, ``module:function``, says at which points its cause is at work: there a port that follows
the equations may leave the routine by more than its own spread.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.parity.batches import Spelling, size, unspell
from pyport.parity.description import Batch, Description, Routine
from pyport.parity.functions import resolve

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Deviation:
    """One cause: what `routine` does for the example, and what its equations say."""

    #: `id`, `routine`, `output`, `fortran`, `cause`: its name, where it is seen, the Fortran line,
    #: and why.
    id: str
    routine: str
    output: str
    fortran: str
    cause: str
    port: str  #: whom the ports that follow the equations follow here: "true" or "oracle"
    #: The example: a hexadecimal literal for each argument, a list for an array.
    input: dict[str, Spelling]
    #: `oracle`, `true`: what the routine answers (hexadecimal) and the equations (decimal).
    oracle: str
    true: str
    #: ``module:function`` of (inputs, the oracle's answers by output) that tells where the cause is
    #: at work, "" where no distance is explained by it.
    region: str = ""
    outputs: tuple[str, ...] = ()  #: "ROUTINE OUTPUT" for each answer that the region explains


def deviations(description: Description) -> tuple[Deviation, ...]:
    """Return the ledger of a description, read once; none where it has no ledger."""
    return () if description.ledger is None else _read(description.ledger)


@cache
def _read(path: Path) -> tuple[Deviation, ...]:
    try:
        rows = tomllib.loads(path.read_text(encoding="utf-8")).get("deviation", [])
    except (OSError, ValueError) as error:
        raise BadInput(f"cannot be read ({error}): expected a ledger of deviations", path) from None
    known = {one.name for one in fields(Deviation)}
    found = []
    for row in rows:
        name = row.get("id", "without id")
        for key in set(row) - known:
            raise BadInput(f"deviation {name}: `{key}` is not known", path)
        missing = known - set(row) - {"region", "outputs"}
        if missing:
            raise BadInput(f"deviation {name}: `{min(missing)}` is missing", path)
        found.append(Deviation(**{**row, "outputs": tuple(row.get("outputs", ()))}))
    return tuple(found)


def example(description: Description, entry: Deviation) -> Batch:
    """Return an entry's input as one point."""
    routine = description.routine(entry.routine)
    given: dict[str, Any] = {key.lower(): value for key, value in entry.input.items()}
    return {one.key: unspell([given[one.key]], one.type, one.shape) for one in routine.inputs}


def explained(
    description: Description, routine: Routine, batch: Batch, expected: Batch
) -> dict[str, dict[str, Mask]]:
    """Return for each region which of the oracle's answers it explains, by output."""
    labels = {f"{routine.name} {one.label}": one.key for one in routine.outputs}
    masks = {}
    for entry in deviations(description):
        keys = [labels[name] for name in entry.outputs if name in labels]
        if entry.region and keys:
            mask = np.asarray(resolve(description, entry.region)(batch, expected), dtype=bool)
            if mask.shape != (size(batch),):
                raise BadInput(
                    f"{entry.region} returned shape {mask.shape}, expected one truth a point"
                )
            masks[entry.id] = dict.fromkeys(keys, mask)
    return masks
