"""Both axes of all recordings as one list of measured numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
from pyport.effects.base import Circumstances, Effect, MissingColumn
from pyport.errors import BadInput
from pyport.recordings.schema import Recordings


@dataclass(frozen=True)
class Stack:
    """m measured numbers out of n recordings: cross-elevations first, then elevations."""

    row: Codes  #: which recording each number belongs to, shape (m,)
    #: True for an elevation offset, False for a cross-elevation offset, shape (m,).
    is_y: NDArray[np.bool_]
    value: Array  #: the offset [rad], shape (m,)

    def __len__(self) -> int:
        """Return m."""
        return len(self.value)

    def spread(self, x: Array, y: Array) -> Array:
        """Return the numbers of this stack out of (n, ...) arrays for each axis, shape (m, ...)."""
        first = len(self) - int(np.count_nonzero(self.is_y))
        halves = (x, self.row[:first]), (y, self.row[first:])
        # where every row was measured there is nothing to pick
        return np.concatenate([own if len(rows) == len(own) else own[rows] for own, rows in halves])

    def columns(self, effect: Effect, at: Circumstances) -> Array:
        """Return an effect's basis for this stack, shape (m, k)."""
        return self.spread(*effect.columns(at))


def stack(recordings: Recordings) -> Stack:
    """Return every measured number of the recordings."""
    has_x = np.flatnonzero(np.isfinite(recordings.x))
    has_y = np.flatnonzero(np.isfinite(recordings.y))
    return Stack(
        row=np.concatenate([has_x, has_y]),
        is_y=np.repeat([False, True], [len(has_x), len(has_y)]),
        value=np.concatenate([recordings.x[has_x], recordings.y[has_y]]),
    )


def term_columns(data: Stack, effect: Effect, recordings: Recordings) -> Array:
    """Return the basis of a model's term for a stack of these recordings, shape (m, k).

    Raises `BadInput`: the term needs more than these recordings tell.
    """
    try:
        return data.columns(effect, recordings.at)
    except MissingColumn as lack:
        said = f"the model's term {effect.id} {lack}, which is not there"
        raise BadInput(said, recordings.file) from None


def group(recordings: Recordings, per: Sequence[str]) -> tuple[Codes, list[tuple[str, ...]]]:
    """Give rows with the same values of some labels the same number.

    Returns for each row the number of its group, shape (n,).
    Returns the label values of each group.
    """
    codes = np.zeros(len(recordings), dtype=np.intp)
    names: list[tuple[str, ...]] = [()]
    for label in per:
        values, inverse = np.unique(recordings.label(label).astype(str), return_inverse=True)
        pairs, codes = np.unique(codes * len(values) + inverse, return_inverse=True)
        names = [(*names[pair // len(values)], str(values[pair % len(values)])) for pair in pairs]
    return codes, names
