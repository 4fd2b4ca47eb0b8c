"""Candidates: the effects that these recordings could show, and shapes that have no name.

Smooth curves in every column, waves over the sky, offsets confined to a stretch
of azimuth or elevation. When one of them explains the recordings better than
any effect does, the honest answer is `unknown`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import orth

from pyport.angles import DEG, Array, Codes
from pyport.diagnosis.naming.finding import Interval
from pyport.effects import CATALOGUE, Circumstances, Effect, MissingColumn, catalogue
from pyport.effects.circumstances import mostly_known
from pyport.effects.empirical import fields
from pyport.effects.empirical.fields import Bumps
from pyport.effects.telescope.rotation import MEASURED
from pyport.least_squares.gram import RANK_TOLERANCE
from pyport.recordings.schema import Recordings, Stack
from pyport.thresholds import FEWEST, VISIBLE


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


#: Order of the curve that is laid through a column.
CURVE_ORDER = 4
#: Waves over the sky: this often around, and this often from the horizon to the zenith.
WAVES_AROUND, WAVES_UPWARD = range(1, 5), (1, 2)
#: Widths of the stretches that a misfit may be confined to, as shares of the recordings.
STRETCH_WIDTHS = (1 / 4, 1 / 8, 1 / 16)


@dataclass(frozen=True)
class Shape:
    """A shape before it is given to an axis.

    Attributes
    ----------
    family, variant
        What kind of shape it is, and which of its kind.
    bumps
        What its columns are made of, for any place in the sky: see `empirical.fields.field`.
    choices
        How many of its kind are tried: the price of picking the best.
    region
        The stretch that it is confined to, none where it is everywhere.
    """

    family: str
    variant: str
    bumps: Bumps
    choices: int = 1
    region: tuple[Interval, ...] = ()


def numbers(recordings: Recordings) -> dict[str, Array]:
    """Return the numbers that a misfit may follow: the direction and every numeric column.

    Columns that the file's header calls `bookkeeping` say how a row was
    written down, not what the telescope met, and are passed over. So are offsets, by their name,
    and what a model left of them: a misfit would follow itself.
    """
    at = conditions(recordings)
    found: dict[str, Array] = {}
    for name, column in {"az_deg": at.az, "el_deg": at.el, **at.columns}.items():
        if name == "order" or MEASURED & {*name.split("_")} or column.dtype.kind not in "fiu":
            continue
        values = np.asarray(column, float)
        several = len(np.unique(values[np.isfinite(values)])) > CURVE_ORDER + 1
        if mostly_known(values) and several:
            found[name] = values
    return found


def shapes_of(recordings: Recordings, stack: Stack) -> tuple[Array, list[Candidate]]:
    """Return the columns of all shapes and what they are, axis by axis."""
    blocks = [np.zeros((len(stack), 0))]
    found: list[Candidate] = []
    start = 0
    for shape in _shapes(recordings):
        columns = fields.values(shape.bumps, recordings.at)[stack.row]
        for axis, measured in (("xel", ~stack.is_y), ("el", stack.is_y)):
            block = columns * measured[:, None]
            if np.count_nonzero(block.any(axis=1)) < FEWEST:
                continue
            width = block.shape[1]
            blocks.append(block)
            found.append(
                Candidate(
                    _effect(shape, axis, width),
                    np.arange(start, start + width),
                    tuple(range(width)),
                    shape.choices,
                    shape.region,
                )
            )
            start += width
    return np.concatenate(blocks, axis=1), found


def _shapes(recordings: Recordings) -> Iterator[Shape]:
    known = numbers(recordings)
    for name, values in known.items():
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        curve = {"kind": "curve", "name": name, "low": low, "high": high, "order": CURVE_ORDER}
        yield Shape("a smooth curve", f"follows {name}", curve, len(known))
    yield from _waves()
    yield from _stretches("az_deg", recordings.at.az % (2 * np.pi))
    yield from _stretches("el_deg", recordings.at.el)


def _waves() -> Iterator[Shape]:
    """Yield waves that go around the sky and up it, one by one and all low ones together."""
    every = [(m, n) for m in WAVES_AROUND for n in WAVES_UPWARD]
    for m, n in every:
        bumps = {"kind": "wave", "around": m, "upward": n}
        yield Shape("a wave over the sky", f"goes with {m} A and {n} E", bumps, len(every))
    low = {"kind": "waves", "each": [(m, n) for m, n in every if m in (1, 2)]}
    yield Shape("a smooth field over the sky", "of order two", low)


def _stretches(name: str, values: Array) -> Iterator[Shape]:
    """Yield offsets confined to a stretch of an angle [rad], in widths that overlap by half."""
    ordered = np.sort(values)
    # A step that goes on to the end of the sky is a jump, and has a name: one stays inside.
    starts = [
        (width, k * width / 2) for width in STRETCH_WIDTHS for k in range(1, round(2 / width) - 2)
    ]
    for width, start in starts:
        low, high = (float(ordered[int(p * (len(values) - 1))]) for p in (start, start + width))
        if low == high:
            continue
        region = Interval(name, low / DEG, high / DEG)
        variant = f"for {region.column} from {region.low:.6g} to {region.high:.6g}"
        bumps = {"kind": "stretch", "name": name, "low_rad": low, "high_rad": high}
        yield Shape("an offset", variant, bumps, len(starts), (region,))


def _effect(shape: Shape, axis: str, width: int) -> Effect:
    """Return a shape as an effect that nobody may name."""
    variant = f"{axis}: {shape.family} {shape.variant}"
    axes, one = [int(axis == "el")] * width, np.eye(width).tolist()
    effect = fields.field(shape.bumps, axes, range(width), one, shape.family, variant)
    return replace(effect, sentence=f"{shape.family} {shape.variant}")
