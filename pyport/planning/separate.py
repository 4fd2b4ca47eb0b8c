"""Which effects some recordings can distinguish, from the model and from each other."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, Array
from pyport.diagnosis.candidates import Candidate
from pyport.least_squares.gram import RANK_TOLERANCE, inverted
from pyport.planning.design import Design
from pyport.thresholds import ALIKE, VISIBLE


@dataclass(frozen=True)
class Sight:
    """How well an effect would be seen."""

    #: `effect`, `variant`: its id, and the member of its family that stands in the middle, by its
    #: error.
    effect: str
    variant: str
    #: `sigma`, `unit`: error of its coefficient, of the worst if it has several, the model fitted
    #: too.
    sigma: float
    unit: str
    inflation: float  #: how many times larger that is than without the model
    #: Effects that it could not be distinguished from, and the share of its curves that each draws.
    alike: tuple[tuple[str, float], ...]
    #: Of an effect whose size physics gives: how many sigmas that is, and what the model's
    #: coefficients would take of it, in arcsec.
    known_sigmas: float | None = None
    taken_for: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Pair:
    """Two members of families that can hardly be distinguished, by their places in the design."""

    one: Candidate
    other: Candidate
    share: float


@dataclass(frozen=True)
class Separation:
    """What recordings could show: effects seen, effects that the model takes up, classes, pairs."""

    seen: tuple[Sight, ...]
    hidden: tuple[str, ...]
    classes: tuple[tuple[str, ...], ...]
    pairs: tuple[Pair, ...]


def separate(design: Design) -> Separation:
    """Return which effects show beside the model, and which of them look alike.

    Two effects look alike when one draws 0.95 or more (a cosine) of what the
    other shows beside the model, for at least half of its family's members.
    """
    model = orthonormal(design.model)
    own = {column.term.effect.id for column in design.columns}
    there: list[tuple[Candidate, Array, Array]] = []
    shown: set[str] = set()
    for candidate in design.candidates:
        columns = design.of(candidate)
        left = columns - model @ (model.T @ columns)
        if candidate.effect.id not in own and (left**2).sum() > VISIBLE**2 * (columns**2).sum():
            there.append((candidate, columns, left))
            shown.add(candidate.effect.id)
    frames = [orthonormal(left) for *_, left in there]
    shares = _shares(frames)
    ids = [candidate.effect.id for candidate, *_ in there]
    alike, pairs = _alike(there, ids, shares)
    names = list(dict.fromkeys(ids))
    seen = []
    for name in names:
        likeness = tuple(alike[name].items())
        members = [one for one in there if one[0].effect.id == name]
        sights = [_sight(*one, likeness) for one in members]
        middle = sorted(range(len(sights)), key=lambda n: sights[n].sigma)[len(sights) // 2]
        seen.append(_of_known_size(sights[middle], design, *members[middle][:2]))
    every = dict.fromkeys(one.effect.id for one in design.candidates if one.effect.id not in own)
    return Separation(
        tuple(seen),
        tuple(name for name in every if name not in shown),
        classes(alike),
        tuple(pairs),
    )


def orthonormal(columns: Array) -> Array:
    """Return an orthonormal basis of some columns, those of no length left out."""
    length = np.linalg.norm(columns, axis=0)
    scaled = columns[:, length > 0] / length[length > 0]
    if scaled.shape[1] == 0:
        return np.zeros((len(columns), 0))
    left, size, _ = np.linalg.svd(scaled, full_matrices=False)
    found: Array = left[:, size > np.sqrt(RANK_TOLERANCE) * size[0]]
    return found


def _shares(frames: list[Array]) -> Array:
    """Return which share of each frame's curves each other frame draws, shape (n, n)."""
    width = np.array([frame.shape[1] for frame in frames])
    if len(frames) == 0:
        return np.zeros((0, 0))
    starts = np.concatenate([[0], np.cumsum(width)[:-1]])
    whole = np.concatenate(frames, axis=1)
    squares = (whole.T @ whole) ** 2
    summed = np.add.reduceat(np.add.reduceat(squares, starts, axis=0), starts, axis=1)
    shares: Array = summed / width[:, None]
    # Whatever has many more coefficients can draw any curve; that is no likeness.
    shares[width[None, :] > 2 * width[:, None]] = 0.0
    np.fill_diagonal(shares, 0.0)
    return shares


def _alike(
    there: list[tuple[Candidate, Array, Array]], ids: list[str], shares: Array
) -> tuple[dict[str, dict[str, float]], list[Pair]]:
    """Return for each effect what it looks like, and a pair of members for each likeness."""
    names = list(dict.fromkeys(ids))
    members = {name: np.flatnonzero(np.array(ids) == name) for name in names}
    found: dict[str, dict[str, float]] = {name: {} for name in names}
    pairs: list[Pair] = []
    for n, one in enumerate(names):
        for other in names[n + 1 :]:
            both = [
                _likeness(shares, members[a], members[b]) for a, b in ((one, other), (other, one))
            ]
            if not any(half for half, _ in both):
                continue
            best = shares[np.ix_(members[one], members[other])]
            i, j = np.unravel_index(int(np.argmax(best)), best.shape)
            pair = Pair(
                there[members[one][i]][0],
                there[members[other][j]][0],
                max(share for _, share in both),
            )
            pairs.append(pair)
            for (alike, share), a, b in zip(both, (one, other), (other, one), strict=True):
                if alike:
                    found[a][b] = share
    return found, pairs


def _likeness(shares: Array, own: NDArray[np.intp], rivals: NDArray[np.intp]) -> tuple[bool, float]:
    """Tell whether half of a family's members look like some of another's, and how much."""
    best = shares[np.ix_(own, rivals)].max(axis=1)
    return bool(2 * (best >= ALIKE).sum() >= len(own)), float(np.median(best))


def classes(alike: dict[str, dict[str, float]]) -> tuple[tuple[str, ...], ...]:
    """Return groups of effects that hang together by their likeness, two or more in each."""
    group = {name: {name} for name in alike}
    for one, others in alike.items():
        for other in others:
            merged = group[one] | group[other]
            for name in merged:
                group[name] = merged
    found = {tuple(name for name in alike if name in one) for one in group.values()}
    return tuple(sorted(one for one in found if len(one) > 1))


def _sight(
    candidate: Candidate, columns: Array, left: Array, alike: tuple[tuple[str, float], ...]
) -> Sight:
    # Of what the model takes up whole, rounding leaves columns that say nothing.
    shows = (left**2).sum(axis=0) > VISIBLE**2 * (columns**2).sum(axis=0)
    sigma, alone = (sigmas(one)[0] for one in (np.where(shows, left, 0.0), columns))
    worst = int(np.argmax(np.where(np.isfinite(sigma), sigma, -1.0)))
    coefficient = candidate.effect.coefficients[candidate.coefficients[worst]]
    return Sight(
        candidate.effect.id,
        candidate.effect.variant,
        float(sigma[worst] / abs(coefficient.scale)),
        coefficient.unit,
        float(sigma[worst] / alone[worst]) if np.isfinite(alone[worst]) else np.inf,
        tuple(sorted(alike, key=lambda one: -one[1])),
    )


def _of_known_size(sight: Sight, design: Design, candidate: Candidate, columns: Array) -> Sight:
    """Return a sight with what becomes of its effect at the size that physics gives, if any."""
    (one, *others) = (candidate.effect.coefficients[n] for n in candidate.coefficients)
    if others or one.expected is None or not np.isfinite(sight.sigma):
        return sight
    moved = columns[:, 0] * one.expected * one.scale
    values = np.linalg.lstsq(design.model, moved, rcond=RANK_TOLERANCE)[0] / ARCSEC
    taken = [
        (column.name, float(value))
        for column, value in zip(design.columns, values, strict=True)
        if column.of.unit == "arcsec"
    ]
    taken.sort(key=lambda each: -abs(each[1]))
    return replace(sight, known_sigmas=abs(one.expected) / sight.sigma, taken_for=tuple(taken))


def sigmas(columns: Array) -> tuple[Array, float]:
    """Return the errors of coefficients whose columns were divided by the noise, the condition."""
    inverse, _, condition, known = inverted(columns.T @ columns)
    return np.where(known, np.sqrt(np.maximum(np.diag(inverse), 0)), np.inf), condition
