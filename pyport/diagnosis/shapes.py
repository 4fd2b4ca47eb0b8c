"""Shapes without a name: smooth curves in every column, and low waves over the sky.

They stand for physics that the catalogue lacks. When one of them explains the
recordings better than any effect does, the honest answer is `unknown`.
"""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.candidates import Candidate
from pyport.effects.base import Circumstances, Coefficient, Effect
from pyport.fitting.stacking import Stack
from pyport.recordings.schema import Recordings

#: Order of the curve that is laid through a column.
ORDER = 4


def columns(recordings: Recordings) -> dict[str, Array]:
    """Return the numbers that a misfit may follow: the direction and every numeric column.

    Columns that the file's header calls `bookkeeping` say how a row was
    written down, not what the telescope met, and are passed over.
    """
    at = recordings.at
    found = {"az_deg": at.az, "el_deg": at.el}
    passed_over = recordings.meta.get("bookkeeping", "").split()
    for name, column in at.columns.items():
        if name in passed_over or column.dtype.kind not in "fiu":
            continue
        values = np.asarray(column, float)
        if np.isfinite(values).all() and len(np.unique(values)) > ORDER + 1:
            found[name] = values
    return found


def design(recordings: Recordings, stack: Stack) -> tuple[Array, list[Candidate]]:
    """Return the columns of all shapes and what they are, axis by axis."""
    blocks = [np.zeros((len(stack), 0))]
    found: list[Candidate] = []
    start = 0
    for name, values in columns(recordings).items():
        curve = _curve(values)
        for axis, measured in (("xel", ~stack.is_y), ("el", stack.is_y)):
            if not measured.any():
                continue
            block = curve[stack.row] * measured[:, None]
            blocks.append(block)
            found.append(
                Candidate(_shape(name, axis), np.arange(start, start + ORDER), tuple(range(ORDER)))
            )
            start += ORDER
    return np.concatenate(blocks, axis=1), found


def _curve(values: Array) -> Array:
    """Return Legendre polynomials of a column's ranks, so that gaps and tails do not rule it."""
    distinct, rank = np.unique(values, return_inverse=True)
    spread = 2 * (distinct - distinct[0]) / (distinct[-1] - distinct[0]) - 1
    return np.polynomial.legendre.legvander(spread[rank], ORDER)[:, 1:]


def _shape(name: str, axis: str) -> Effect:
    """Return a shape as an effect that nobody may name."""
    return Effect(
        "unknown",
        f"a smooth curve in {name}",
        "a polynomial, no physics",
        tuple(Coefficient(f"{name}_{n + 1}") for n in range(ORDER)),
        _no_basis,
        physical=False,
        variant=f"{axis} follows {name}",
    )


def _no_basis(at: Circumstances) -> tuple[Array, Array]:
    """Return nothing: a shape's columns are made for one set of recordings only."""
    return np.zeros((len(at), ORDER)), np.zeros((len(at), ORDER))
