"""Candidates: the effects that these recordings could show."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import orth

from pyport.angles import Array, Codes
from pyport.diagnosis.naming.finding import Interval
from pyport.effects import CATALOGUE, Circumstances, Effect, MissingColumn, catalogue
from pyport.least_squares.gram import RANK_TOLERANCE
from pyport.recordings.schema import Recordings, Stack
from pyport.thresholds import VISIBLE


@dataclass(frozen=True)
class Blocks:
    """The blocks of the data: one for each antenna in each session."""

    antenna: NDArray[np.str_]
    session: NDArray[np.str_]

    def __len__(self) -> int:
        """Return the number of blocks."""
        return len(self.antenna)

    @cached_property
    def antennas(self) -> int:
        """Return the number of antennas."""
        return len(np.unique(self.antenna))

    @cached_property
    def sessions(self) -> int:
        """Return the number of sessions."""
        return len(np.unique(self.session))

    def groups(self, scope: str) -> Codes:
        """Give blocks that share a coefficient the same number."""
        if scope == "all":
            return np.zeros(len(self), np.intp)
        if scope == "antenna and session":
            return np.arange(len(self))
        return np.unique(getattr(self, scope), return_inverse=True)[1]

    def count(self, scope: str) -> int:
        """Return the number of groups of a scope."""
        counts = {"all": 1, "antenna": self.antennas, "session": self.sessions}
        return counts.get(scope, len(self))

    def names(self, scope: str) -> list[str]:
        """Name the groups of a scope, in their order."""
        if scope == "all":
            return [""]
        if scope == "antenna and session":
            return [f"{a} {s}".strip() for a, s in zip(self.antenna, self.session, strict=True)]
        return [str(one) for one in np.unique(getattr(self, scope))]

    def scopes(self) -> list[str]:
        """Return the scopes that differ from each other here, the smallest first."""
        several = self.antennas > 1, self.sessions > 1
        wanted = {"all": True, "session": several[1], "antenna": several[0]}
        found = [scope for scope, there in wanted.items() if there]
        return [*found, "antenna and session"] if all(several) else found


@dataclass(frozen=True)
class Candidate:
    """A member of an effect's family and where its columns stand in the design matrix."""

    effect: Effect
    columns: Codes
    #: Which of the effect's coefficients those columns are: constant zero ones are left out.
    coefficients: tuple[int, ...]
    #: How many members of its family are tried: the price of picking the best of them.
    choices: int = 1
    #: The stretch of the recordings that it is confined to, if it is.
    region: tuple[Interval, ...] = ()
    #: Whether its columns belong to the moments of these recordings: no other session has them.
    of_time: bool = False

    @property
    def precision(self) -> Array:
        """Return what is known of each coefficient beforehand, 1 / variance or zero, (k,)."""
        return self.effect.precision[list(self.coefficients)]

    @property
    def price(self) -> float:
        """Return what its choice among its family costs, in twice the log odds."""
        return 2 * float(np.log(self.choices))


@dataclass(frozen=True)
class Untestable:
    """An effect that these recordings cannot show, and what it would need."""

    effect: str
    reason: str


def design(
    recordings: Recordings, stack: Stack, beside: Array | None = None
) -> tuple[Array, list[Candidate], list[Untestable]]:
    """Return the columns of all candidates, what they are, and what cannot be tested.

    Columns are in internal units, one for a coefficient of one. What the fitted terms, columns
    `beside` (m, p), draw nearly all of is no candidate: the rest is what directions err by. What
    they draw all of is one, for it may differ from session to session.

    Returns
    -------
    columns
        Shape (m, K).
    candidates
        One for each member of each family.
    untestable
        Effects for which the recordings lack something, each once: none of its members shows.
    """
    blocks: list[Array] = []
    candidates: list[Candidate] = []
    untestable: list[Untestable] = []
    start = 0
    recorded = conditions(recordings)
    drawn = orth(np.zeros((len(stack), 1)) if beside is None else beside)
    for effect in catalogue(recordings.at.mount).values():
        if not effect.physical:
            continue
        try:
            variants = effect.variants(recorded)
            bases = [stack.columns(variant, recordings.at) for variant in variants]
        except MissingColumn as lack:
            untestable.append(Untestable(effect.id, f"needs {lack.column}"))
            continue
        first, reasons = start, []
        for variant, basis in zip(variants, bases, strict=True):
            kept = np.flatnonzero(np.any(basis != 0, axis=0) & np.all(np.isfinite(basis), axis=0))
            if len(kept) == 0:
                reasons.append("it moves nothing that was measured here")
                continue
            own = basis[:, kept]
            share = np.linalg.norm(own - drawn @ (drawn.T @ own)) / np.linalg.norm(own)
            if RANK_TOLERANCE < share <= VISIBLE:
                reasons.append("the fitted terms draw nearly all of it")
                continue
            blocks.append(own)
            places = np.arange(start, start + len(kept))
            which = tuple(int(one) for one in kept)
            candidates.append(Candidate(variant, places, which, len(variants)))
            start += len(kept)
        if start == first and reasons:
            untestable.append(Untestable(effect.id, reasons[0]))
    columns = np.concatenate(blocks, axis=1) if blocks else np.zeros((len(stack), 0))
    return columns, candidates, untestable


def conditions(recordings: Recordings) -> Circumstances:
    """Return the circumstances without the columns that the header calls `bookkeeping`.

    They say how a row was written down, so that no effect may follow them.
    """
    at, kept = recordings.at, set(recordings.at.columns)
    kept -= set(recordings.meta.get("bookkeeping", "").split())
    return replace(at, columns={name: at.columns[name] for name in at.columns if name in kept})


def but_of_every_session(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return candidates without changes that have coefficients of their own in every session.

    Among sessions that depart at random those are no change but their scatter. The choice among
    a family is one among those that are left.
    """
    kept = [one for one in candidates if not _of_every_session(one.effect)]
    left = Counter(one.effect.id for one in kept)
    return [
        replace(one, choices=left[one.effect.id]) if one.effect.is_change else one for one in kept
    ]


def _of_every_session(effect: Effect) -> bool:
    return effect.is_change and len(effect.coefficients) > len(
        CATALOGUE[effect.on_altaz].coefficients
    )
