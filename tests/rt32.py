"""The RT32's description for tests: what each program answers, as one array with five columns."""

from pathlib import Path

import numpy as np

from pyport.parity.compiled import oracle, stored
from pyport.parity.described import loading
from pyport.parity.described.functions import ask_port, joined, part, size
from pyport.parity.run import hold_live

FORTRAN = Path(__file__).parents[1] / "legacy_fortran"
DESCRIPTION = loading.load(FORTRAN / "parity.toml")
ROUTINES = DESCRIPTION.routines
LEGACY, VECTORISED = DESCRIPTION.ports
GROUPS = {one.name: one for one in DESCRIPTION.groups}

#: The five numbers that the routines return, and the columns of every array of answers.
OUTPUTS = [(routine.name, one.label) for routine in ROUTINES for one in routine.outputs]

__all__ = ["joined", "part", "size"]


def _columns(answers):
    return np.column_stack([of[one.key] for routine, of in answers for one in routine.outputs])


def of_port(port, at):
    """Return what a port answers, shape (n, 5)."""
    return _columns([(r, ask_port(DESCRIPTION, port, r, at)) for r in ROUTINES])


def of_legacy(at):
    """Return what the statement-by-statement port answers, shape (n, 5)."""
    return of_port(LEGACY, at)


def of_pointing(at):
    """Return what the vectorised port answers, rounded to REAL*4, shape (n, 5)."""
    return of_port(VECTORISED, at)


def of_oracle(at, build="reference"):
    """Return what the compiled routines answer, shape (n, 5)."""
    asked = oracle.of(DESCRIPTION.path, build)
    return _columns([(r, asked.ask(r, at)) for r in ROUTINES])


def held(at):
    """Return how each port of each routine compares with the compiled one."""
    results = {}
    for routine in ROUTINES:
        results |= hold_live(DESCRIPTION, routine, {v.key: at[v.key] for v in routine.inputs})
    return results


def known(name):
    """Return the stored set of that name of each routine."""
    return [(routine, stored.load(DESCRIPTION, GROUPS[name], routine)) for routine in ROUTINES]
