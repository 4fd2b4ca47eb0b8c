"""Votes that are weighed anew until they agree with the residuals, on a design of two axes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pyport.angles import Array, Codes
from pyport.least_squares.gram import solved
from pyport.pointing import kernel
from pyport.pointing.swift import Columns
from pyport.recordings.schema import Stack
from pyport.studies.rt32.losses import Tune, Tuned

#: Most rounds of weighing; votes within this of each other have settled.
ROUNDS = 60
_SETTLED = 1e-4


@dataclass(frozen=True)
class Half:
    """One axis's rows of a design, and the columns that move it."""

    rows: slice  #: where they stand among all m
    which: Codes  #: which of all columns these are, shape (k,)
    columns: Array  #: their numbers, contiguous, shape (k, rows)

    @cached_property
    def both(self) -> tuple[Codes, ...]:
        """Return where its products stand among those of all columns."""
        return np.ix_(self.which, self.which)


@dataclass(frozen=True)
class Design:
    """A design whose columns mostly move one axis alone: cross-elevations first, as in a stack."""

    halves: tuple[Half, ...]
    size: int  #: how many columns there are

    @classmethod
    def of(cls, data: Stack, x: Columns, y: Columns, size: int) -> Design:
        """Return the design of a stack from the columns of each axis, of `size` that there are."""
        first = len(data) - int(np.count_nonzero(data.is_y))
        halves = []
        for columns, rows in ((x, slice(0, first)), (y, slice(first, len(data)))):
            own = np.empty((len(columns), rows.stop - rows.start))
            for k, column in enumerate(columns.values()):
                # where every row was measured there is nothing to pick
                own[k] = column if len(column) == own.shape[1] else column[data.row[rows]]
            halves.append(Half(rows, np.array([*columns], np.intp), own))
        return cls(tuple(halves), size)

    @property
    def columns(self) -> Array:
        """Return all its numbers, shape (m, P)."""
        whole = np.zeros((self.halves[-1].rows.stop, self.size))
        for half in self.halves:
            whole[half.rows, half.which] = half.columns.T
        return whole

    @property
    def finite(self) -> bool:
        """Tell whether all its numbers are."""
        return all(np.isfinite(half.columns).all() for half in self.halves)

    def products(self, weight: Array, value: Array) -> tuple[Array, Array]:
        """Return the products of weighted columns, (P, P), and of columns with a value, (P,)."""
        normal, right = np.zeros((self.size, self.size)), np.zeros(self.size)
        for half in self.halves:
            own = kernel.gram(half.columns, weight[half.rows], value[half.rows])
            normal[half.both] += own[0]
            right[half.which] += own[1]
        return normal, right

    def left(self, value: Array, values: Array) -> Array:
        """Return what is left of data (m,) beside coefficients (P,)."""
        return np.concatenate(
            [value[half.rows] - values[half.which] @ half.columns for half in self.halves]
        )


@dataclass(frozen=True)
class Settled:
    """Coefficients at which votes and residuals agree, and how that came about."""

    values: Array  #: coefficients, shape (P,)
    #: `residual`, `weight`: what they leave, and its votes, shape (m,) each.
    residual: Array
    weight: Array
    tuned: Tuned  #: the loss with its scale
    rounds: int  #: how often votes were weighed
    settled: bool  #: whether they had come to rest by then


def settle(
    design: Design,
    value: Array,
    tune: Tune,
    times: Array,
    start: Array | None = None,
    most: int = ROUNDS,
) -> Settled:
    """Weigh votes anew until they agree with the residuals.

    `design`, `value`: the columns and the data (m,).
    `tune`: what sets the votes by the residuals.
    `times`: how often each datum counts, shape (m,).
    `start`: votes to begin with, shape (m,); all are equal when not given.
    `most`: rounds after which it ends whether votes have settled or not.
    """
    weight = np.ones(len(value)) if start is None else start
    solution, residual, slope = np.zeros(design.size), value, weight
    for rounds in range(1, most + 1):
        normal, right = design.products(slope * times, weight * times * residual)
        solution = solution + solved(normal, right)
        residual = design.left(value, solution)
        tuned = tune(residual)
        last, weight = weight, tuned.weight(residual)
        if np.max(np.abs(weight - last)) < _SETTLED:
            return Settled(solution, residual, weight, tuned, rounds, settled=True)
        # near the end Newton's steps: they know that votes change as residuals do
        slope = weight if rounds == 1 else np.maximum(tuned.slope(residual, weight), weight / 4)
    return Settled(solution, residual, weight, tuned, most, settled=False)
