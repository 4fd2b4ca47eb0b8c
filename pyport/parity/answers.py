"""What each program answers at given points: the oracle, the legacy port, the vectorised port."""

from __future__ import annotations

import importlib
import os
from types import ModuleType

import numpy as np

from pyport import legacy, pointing
from pyport.angles import DEG
from pyport.errors import BadInput
from pyport.parity.points import Points, Real4

#: The five numbers that the routines return, and the columns of every array of answers.
OUTPUTS = (
    ("Model", "azimuth"),
    ("Model", "altitude"),
    ("ModelA", "azimuth"),
    ("ModelA", "altitude"),
    ("Hjump", "altitude"),
)


def find_oracle() -> ModuleType | None:
    """Return the compiled routines, or None where they are not installed.

    With ``PYPORT_ORACLE=required`` in the environment a missing oracle is an error.
    """
    try:
        return importlib.import_module("pyport_oracle")
    except ModuleNotFoundError as error:
        if error.name != "pyport_oracle":
            raise
        if os.environ.get("PYPORT_ORACLE") == "required":
            raise BadInput(
                "the compiled routines are required (PYPORT_ORACLE) and not installed: "
                "expected `pip install ./legacy_fortran`, which needs gfortran"
            ) from None
        return None


def of_oracle(oracle: ModuleType, at: Points, *, promoted: bool = False) -> Real4:
    """Return what the compiled routines answer, shape (n, 5), in the order of ``OUTPUTS``."""
    answers = np.column_stack(
        [
            *oracle.model(at.az, at.alt, at.p, promoted=promoted),
            *oracle.modela(at.az, at.alt, at.p, promoted=promoted),
            oracle.hjump(at.az, at.alt, promoted=promoted),
        ]
    )
    with np.errstate(over="ignore"):  # what REAL*8 holds may be infinite in REAL*4
        return answers.astype(np.float32)


def of_legacy(at: Points) -> Real4:
    """Return what the statement-by-statement port answers, shape (n, 5)."""
    answers = np.empty((len(at), len(OUTPUTS)), dtype=np.float32)
    for row, az, alt, p in zip(answers, at.az, at.alt, at.p, strict=True):
        row[0:2] = legacy.model(az, alt, p)
        row[2:4] = legacy.modela(az, alt, p)
        row[4] = legacy.hjump(az, alt)
    return answers


def of_pointing(at: Points) -> Real4:
    """Return what the vectorised port answers, rounded to REAL*4, shape (n, 5)."""
    answers = np.empty((len(at), len(OUTPUTS)))
    az, alt = at.az.astype(float), at.alt.astype(float)
    with np.errstate(all="ignore"):  # the edges hold infinities, at which nothing is promised
        for number, p in enumerate(at.parameters.astype(float) * DEG):
            here = at.which == number
            exact = pointing.exact_offsets(az[here], alt[here], p)
            approximate = pointing.approximate_offsets(az[here], alt[here], p)
            answers[here, :4] = np.column_stack([*exact, *approximate]) / DEG
        jumped = pointing.has_jumped(az, alt).astype(float)
        answers[:, 4] = np.where(alt < 0, pointing.jump_altitude(az) / DEG, jumped)
        return answers.astype(np.float32)
