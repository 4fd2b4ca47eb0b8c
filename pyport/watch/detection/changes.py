"""What is watched for: a change of any effect of the catalogue, from some moment on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.effects import CATALOGUE, Circumstances, Effect, MissingColumn
from pyport.thresholds import IDENTICAL

#: Rms of a change before it is seen, over the scatter of a reading: the middle of the changes
#: that matter. One that is three times larger or smaller is seen about one pointing later.
EXPECTED = 3.0
#: What is done to a telescope may be far larger: taken apart, a correction switched off.
WORKED_ON = 30.0
#: Share of the alarms' budget for changes of what the model has (zeros, tilt, sag), and for
#: scatter and outliers; the other effects of the catalogue share what is left.
MOUNT_SHARE, SPREAD_SHARE = 0.4, 0.2
#: A change of more coefficients is not learnt within a night: each part of it is watched for.
MOST_TOGETHER = 8
#: Effects of which one draws this share of the other are one.
SAME = 1 - 1e-6
#: Directions of an effect's coefficients that move readings by less than this share of the
#: strongest are left to the prior.
WEAK = 1e-6


@dataclass(frozen=True)
class Change:
    """An effect whose coefficients may change."""

    effect: Effect  #: it, or the member of its family, as if it had always been there
    #: Ids of all effects that the past recordings cannot distinguish from it, itself first, and
    #: what they are called in a sentence.
    alike: tuple[str, ...]
    called: tuple[str, ...]
    of_model: bool  #: whether it is of what the model has: its terms, or what they stand for
    share: float  #: of the alarms' budget
    expected: float  #: rms that the prior gives to readings that it moves, over their scatter
    prior: Array  #: covariance of the change of its coefficients, internal units, shape (k, k)

    @property
    def names(self) -> list[str]:
        """Return the names of its coefficients, without the moment that they would hold from."""
        return [one.name.partition("[")[0] for one in self.effect.coefficients]


def called(effect: Effect) -> str:
    """Return what an effect is called in a sentence: what follows something says what."""
    follows = effect.driver and effect.change_of
    return effect.pattern if follows else effect.id.replace("_", " ")


def columns(effects: Sequence[Effect], at: Circumstances) -> tuple[Array, Array]:
    """Return the columns of some effects side by side, (n, C) in each axis.

    Zero where the rows lack what an effect needs: they say nothing of it.
    """
    blocks: list[tuple[Array, Array]] = [(np.zeros((len(at), 0)),) * 2]
    for effect in effects:
        try:
            blocks.append(effect.columns(at))
        except MissingColumn:
            blocks.append((np.zeros((len(at), len(effect.coefficients))),) * 2)
    return np.concatenate([x for x, _ in blocks], 1), np.concatenate([y for _, y in blocks], 1)


def members(at: Circumstances) -> list[Effect]:
    """Return the effects that recordings like these could show a change of.

    Changes from one epoch to another count as if they held from the beginning: when they began
    is what the watch asks. Slow polynomials in time are left out: they are drift. So is what
    looks back, for a watch is given row by row.
    """
    found: list[Effect] = []
    for effect in sorted(CATALOGUE.values(), key=lambda one: not one.is_change):
        if not effect.physical or effect.changes_with == "time":
            continue
        try:
            some = [effect.make(since_s=0.0)] if effect.make and effect.is_change else []
            found += some or [one for one in effect.variants(at) if not one.looks_back]
        except MissingColumn:
            continue
    return found


def together(some: Sequence[Effect]) -> Effect:
    """Return the change of several effects at once: the mount was worked on."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        return columns(some, at)

    return Effect(
        "several_terms",
        f"several terms changed at once: {', '.join(one.id for one in some)}",
        "",
        tuple(one for effect in some for one in effect.coefficients),
        basis,
        pattern="all over the sky",
    )


def possible(
    at: Circumstances,
    variance: Array,
    terms: Sequence[Effect] = (),
    departing: Collection[str] = (),
) -> tuple[Change, ...]:
    """Return the changes to watch for, in what the past pointings show.

    `variance` (n, 2) is that of their readings [rad^2], infinite where none was taken; the model's
    `terms` may also change all at once; what belongs to `departing` labels is noise. Two effects
    are one change where no change of the expected sizes shows which it is.
    """
    kept: list[_Kept] = []
    own = {one.id for one in terms}
    scale = 1 / np.sqrt(variance)
    several = [together(terms)] if len(terms) > 1 and _size(terms) <= MOST_TOGETHER else []
    for whole in [*several, *members(at)]:
        if _size([whole]) > MOST_TOGETHER or whole.belongs_to in departing:
            continue
        effect = _visible(whole, at, np.isfinite(variance))
        x, y = columns([effect], at)
        white = np.concatenate([x * scale[:, :1], y * scale[:, 1:]])
        if not np.isfinite(white).all() or not white.any():
            continue
        frame = _frame(white)
        same = next((one for one in kept if one.draws(frame) >= IDENTICAL), None)
        if same is None:
            of_model = effect.is_change or whole in several or effect.id in own
            kept.append(_Kept(effect, frame, [effect], of_model))
        elif same.of_model and same.draws(frame) > SAME and same.effect.is_change:
            # a tilt from some moment on is a tilt: the plain effect gives the name
            same.effect = same.alike[0] = effect
        else:
            same.alike.append(effect)
    count = Counter(one.effect.id for one in kept)
    mounts = sum(one.of_model for one in kept)
    others = len({one.effect.id for one in kept if not one.of_model})
    rest = 1 - SPREAD_SHARE - (MOUNT_SHARE if mounts else 0.0)
    found, sizes = [], (EXPECTED, WORKED_ON)
    for one in kept:
        share = MOUNT_SHARE / mounts if one.of_model else rest / others
        unit = _unit(*columns([one.effect], at), variance)
        share /= count[one.effect.id] * len(sizes)
        alike = tuple(dict.fromkeys(each.id for each in one.alike))
        names = alike, tuple(dict.fromkeys(map(called, one.alike)))
        found += [
            Change(one.effect, *names, one.of_model, share, size, size**2 * unit) for size in sizes
        ]
    return tuple(found)


@dataclass
class _Kept:
    """An effect that is watched for: its directions, and all those that look like it."""

    effect: Effect
    frame: Array
    alike: list[Effect]
    of_model: bool

    def draws(self, frame: Array) -> float:
        """Return which share of another's directions it draws; none of more or fewer."""
        if frame.shape != self.frame.shape:
            return 0.0
        return float(((frame.T @ self.frame) ** 2).sum()) / frame.shape[1]


def _visible(effect: Effect, at: Circumstances, measured: NDArray[np.bool_]) -> Effect:
    """Return an effect without the coefficients that moved nothing that was measured."""
    x, y = columns([effect], at)
    kept = (x[measured[:, 0]] != 0).any(axis=0) | (y[measured[:, 1]] != 0).any(axis=0)
    if kept.all():
        return effect

    def basis(there: Circumstances) -> tuple[Array, Array]:
        x, y = effect.basis(there)
        return x[:, kept], y[:, kept]

    some = tuple(one for one, is_kept in zip(effect.coefficients, kept, strict=True) if is_kept)
    return replace(effect, coefficients=some, basis=basis)


def _size(some: Sequence[Effect]) -> int:
    return sum(len(one.coefficients) for one in some)


def _frame(white: Array) -> Array:
    """Return orthonormal directions of some columns, those of no length left out."""
    length = np.linalg.norm(white, axis=0)
    left, size, _ = np.linalg.svd(white[:, length > 0] / length[length > 0], full_matrices=False)
    return np.asarray(left[:, size > np.sqrt(WEAK) * size[0]])


def _unit(x: Array, y: Array, variance: Array) -> Array:
    """Return the covariance of a change that moves the readings it acts on by one sigma."""
    products = (x / variance[:, :1]).T @ x + (y / variance[:, 1:]).T @ y
    length = np.sqrt(np.diag(products))
    length[length == 0] = 1.0
    power, vectors = np.linalg.eigh(products / np.outer(length, length))
    power = np.maximum(power, WEAK * power.max())
    acts = np.stack([(x != 0).any(axis=1), (y != 0).any(axis=1)], axis=1)
    moved = (acts & np.isfinite(variance)).sum()
    inverse = (vectors / power) @ vectors.T / np.outer(length, length)
    return np.asarray(moved / len(products) * inverse)
