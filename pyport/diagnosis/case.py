"""A case: what was given and is to be diagnosed, and which of its columns are fitted."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
from pyport.diagnosis.candidates import Blocks, Candidate, Untestable
from pyport.effects.base import Effect
from pyport.least_squares.gram import Part
from pyport.models.model import Model
from pyport.noise.estimation.frame import Frame
from pyport.noise.series import Series
from pyport.recordings.schema import Recordings, Stack

Made = TypeVar("Made")


@dataclass(frozen=True)
class Chosen:
    """An effect in a fit, and the scope within which its coefficients are shared.

    `spread` is how far its coefficients scatter over all that was not fitted with them, such
    as where an edge runs; it adds to their errors.
    """

    candidate: Candidate
    scope: str
    spread: float = 0.0


@dataclass(frozen=True)
class Problem:
    """What does not change while a diagnosis goes on.

    Attributes
    ----------
    recordings, model, stack
        What was given.
    base, candidates, untestable
        Terms that are refitted, effects that may be named, and effects that these recordings
        cannot show.
    data
        All their columns and, last, the residuals, shape (m, K + 1).
    added
        Columns that refinements brought, which stand behind those K, shape (m, k).
    blocks, block
        The blocks, and the one (antenna in a session) of each reading, shape (m,).
    session
        Number of the session of each reading, shape (m,).
    pointing
        Number of the pointing of each reading, shape (m,).
    scan
        Number of the scan of each reading: one moment and axis for all antennas, shape (m,).
    frame
        What the noise is estimated from: series, sessions, sources.
    seed
        Of the draws of noise.
    memory
        What was made before, see `remembered`, with what the identities in its keys belong to.
    """

    recordings: Recordings
    model: Model
    stack: Stack
    base: tuple[Chosen, ...]
    candidates: tuple[Candidate, ...]
    untestable: tuple[Untestable, ...]
    data: Array
    blocks: Blocks
    block: Codes
    session: Codes
    pointing: Codes
    scan: Codes
    frame: Frame
    seed: int
    memory: dict[tuple[object, ...], tuple[Any, tuple[object, ...]]] = field(
        default_factory=dict, repr=False, compare=False
    )
    added: Array | None = None

    def remembered(
        self, key: tuple[object, ...], whose: Iterable[object], make: Callable[[], Made]
    ) -> Made:
        """Return what was made before under a key, or make it.

        `whose`: what the identities in the key belong to. It is kept as long as the key.
        """
        if key not in self.memory:
            self.memory[key] = make(), tuple(whose)
        found: Made = self.memory[key][0]
        return found

    @property
    def parts(self) -> tuple[Series, ...]:
        """Return the series that noise is estimated for."""
        return self.frame.parts

    @cached_property
    def session_names(self) -> NDArray[np.str_]:
        """Return the name of the session of each reading, shape (m,)."""
        return self.recordings.label("session").astype(str)[self.stack.row]

    @cached_property
    def antenna(self) -> NDArray[np.str_]:
        """Return the name of the antenna of each reading, shape (m,)."""
        return self.blocks.antenna[self.block]

    @cached_property
    def series(self) -> Codes:
        """Return the number of the antenna and axis of each reading, shape (m,)."""
        return 2 * self.blocks.groups("antenna")[self.block] + self.stack.is_y

    @property
    def size(self) -> int:
        """Return how many columns there are of everything that may be fitted."""
        return self.data.shape[1] - 1 + (0 if self.added is None else self.added.shape[1])

    @cached_property
    def whole(self) -> Array:
        """Return the columns of everything that may be fitted and the residuals, (m, size + 1)."""
        if self.added is None:
            return self.data
        return np.concatenate([self.data[:, :-1], self.added, self.data[:, -1:]], axis=1)

    def picked(self, which: Codes) -> Array:
        """Return some of the columns, shape (m, k)."""
        first = self.data.shape[1] - 1
        if self.added is None or max(which, default=0) < first:
            return self.data.take(which, axis=1)
        before = which < first
        out = np.empty((len(self.data), len(which)))
        out[:, before] = self.data[:, which[before]]
        out[:, ~before] = self.added[:, which[~before] - first]
        return out

    @cached_property
    def residual(self) -> Array:
        """Return the data less what the model gives before any fit [rad], shape (m,)."""
        return np.ascontiguousarray(self.data[:, -1])

    def with_columns(self, more: Array) -> Problem:
        """Return the case with further columns, shape (m, k), behind those that it has.

        All columns are put together where all are whitened: most refinements are tried, not taken.
        """
        added = more if self.added is None else np.concatenate([self.added, more], axis=1)
        return replace(self, added=added)

    def with_member(self, one: Chosen, effect: Effect) -> tuple[Problem, Chosen]:
        """Return the case with the columns of another member of a choice's family, and that."""
        candidate = one.candidate
        columns = self.stack.columns(effect, self.recordings.at)[:, list(candidate.coefficients)]
        own = self.size + np.arange(columns.shape[1])
        other = replace(one, candidate=replace(candidate, effect=effect, columns=own))
        return self.with_columns(columns), other

    @cached_property
    def named(self) -> tuple[Effect, ...]:
        """Return an effect of each name that may be given."""
        return tuple({one.effect.id: one.effect for one in self.candidates}.values())

    @cached_property
    def possible(self) -> tuple[Array, ...]:
        """Return for each series the columns of all lasting candidates that are not empty in it.

        What changes with time, or belongs to sources, is not among them: the noise holds what
        nights, drifts and sources do, and such an effect has to stand out of that. So has one that
        begins anew with each session, as a drift may.
        """
        return self.shown_by(self.lasting)

    @property
    def lasting(self) -> list[Candidate]:
        """Return the candidates that neither change with time nor belong to sources."""
        return [
            one
            for one in self.candidates
            if not (confounded(self, one.effect) or one.effect.begins_anew)
        ]

    def shown_by(self, candidates: Sequence[Candidate]) -> tuple[Array, ...]:
        """Return for each series the columns of candidates that are not empty in it."""
        some = [np.zeros(0, np.intp), *(one.columns for one in candidates)]
        columns = self.picked(np.concatenate(some))
        found = []
        for part in self.parts:
            own = columns[part.rows]
            found.append(own[:, own.any(axis=0)])
        return tuple(found)

    def axes_of(self, candidate: Candidate) -> frozenset[bool]:
        """Return in offsets of which axes a candidate acts, the second one true."""
        acting = self.picked(candidate.columns).any(axis=1)
        return frozenset(np.unique(self.stack.is_y[acting]).tolist())

    def part(self, chosen: Chosen) -> Part:
        """Return the columns of a choice and who shares their coefficients."""
        return Part(chosen.candidate.columns, self.blocks.groups(chosen.scope))

    def precision(self, choices: Sequence[Chosen]) -> Array:
        """Return what is known of each coefficient beforehand, 1 / variance or zero, (P,)."""
        known = [np.resize(one.candidate.precision, self.part(one).size) for one in choices]
        return np.concatenate([np.zeros(0), *known])

    def expanded(self, choices: Sequence[Chosen], of: Array | None = None) -> Array:
        """Return a column for every coefficient of some choices, shape (m, P).

        `of` stands for other columns than the design's: whitened ones, shape (M, K + 1).
        """
        rows = len(self.data if of is None else of)
        block = np.resize(self.block, rows)
        out = [np.zeros((rows, 0))]
        for chosen in choices:
            groups = self.blocks.groups(chosen.scope)
            own = chosen.candidate.columns
            if of is None:
                columns = self.picked(own)
            else:
                # `take` would copy all of an array that lies column by column.
                columns = of.take(own, axis=1) if of.flags.c_contiguous else of[:, own]
            width = columns.shape[1]
            wide = np.zeros((rows, width * (int(groups.max()) + 1)))
            places = groups[block][:, None] * width + np.arange(width)
            np.put_along_axis(wide, places, columns, axis=1)
            out.append(wide)
        return np.concatenate(out, axis=1)


def confounded(problem: Problem, effect: Effect) -> bool:
    """Tell whether the noise may do what an effect does: it changes with time, or is a source's.

    In an array a change is each antenna's, and the others show what the noise does.
    """
    return bool(effect.changes_with or effect.belongs_to) and problem.blocks.antennas == 1


def measurements(problem: Problem) -> Codes:
    """Return the number of the pointing and axis of each reading, (m,): repeats have the same."""
    return 2 * problem.pointing + problem.stack.is_y
