"""The blocks of an array: what one antenna says of its mount's shapes in one session.

A block's readings are brought down to what they say of a few shapes (a tilt, a
sag, half the difference between scans up and down) with the encoders' zeros
left free: an information matrix and a score. Whatever is compared between
antennas and between sessions is made of these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
from pyport.diagnosis import joint
from pyport.diagnosis.case import Problem, measurements
from pyport.diagnosis.joint import rms
from pyport.effects import CATALOGUE, Effect, MissingColumn
from pyport.effects.base import LASTING, STEP, ZERO
from pyport.least_squares import robust
from pyport.recordings.sky import clock
from pyport.thresholds import FIRST_REACH, OUTLIER_WEIGHT

#: Pointings that a block must have beyond its shapes and zeros.
SPARE = 3
#: A block's scale is drawn towards the median of all as by so many pointings.
BORROWED = 4.0


@dataclass(frozen=True)
class Shape:
    """One coefficient of an effect: a number that a mount has."""

    effect: Effect
    coefficient: int

    @property
    def name(self) -> str:
        """Return the coefficient's name."""
        return self.effect.coefficients[self.coefficient].name


@dataclass(frozen=True)
class Block:
    """One antenna in one session: n pointings (means of their readings), k shapes, z zeros.

    Attributes
    ----------
    antenna, session
        Whose.
    row
        A recording of each pointing, shape (n,).
    value
        Offsets less what the model gives [rad], shape (n,).
    shapes, zeros
        Shape (n, k) and (n, z).
    weight
        Robust weights about the block's own fit, shape (n,).
    sigma
        Scatter of a pointing about that fit [rad].
    information, score
        What the block says of its shapes with its zeros free, shape (k, k) and (k,).
    """

    antenna: str
    session: str
    row: Codes
    value: Array
    shapes: Array
    zeros: Array
    weight: Array
    sigma: float
    information: Array
    score: Array

    @property
    def used(self) -> NDArray[np.bool_]:
        """Tell which pointings are no outliers, shape (n,)."""
        return self.weight >= OUTLIER_WEIGHT

    def alone(self) -> Array:
        """Return the shapes' coefficients by this block alone, shape (k,)."""
        return np.asarray(np.linalg.pinv(self.information, rcond=1e-9) @ self.score)

    def used_rms(self, left: Array) -> float:
        """Return the rms of something left over, outliers apart."""
        return rms(left[self.used])

    def left(self, coefficients: Array) -> Array:
        """Return what given coefficients leave with only the zeros fitted anew, shape (n,)."""
        rest = self.value - self.shapes @ coefficients
        root = np.sqrt(self.weight)
        level = np.linalg.lstsq(self.zeros * root[:, None], rest * root, rcond=1e-9)[0]
        return np.asarray(rest - self.zeros @ level)


def lasting_shapes(problem: Problem) -> tuple[Shape, ...]:
    """Return the lasting shapes that these recordings show."""
    return _shown(problem, _that_are(LASTING))


def _that_are(kind: str) -> list[Effect]:
    return [one for one in CATALOGUE.values() if one.in_arrays == kind]


def model_shapes(problem: Problem) -> tuple[Shape, ...]:
    """Return the shapes of the model itself, zeros apart."""
    return _shown(problem, [one.candidate.effect for one in problem.base])


def _shown(problem: Problem, effects: Sequence[Effect]) -> tuple[Shape, ...]:
    """Return the coefficients of some effects that move anything here, zeros apart."""
    found = []
    for effect in effects:
        if effect.in_arrays == ZERO:
            continue
        try:
            columns = problem.stack.columns(effect, problem.recordings.at)
        except MissingColumn:
            continue
        found += [Shape(effect, int(n)) for n in np.flatnonzero(np.any(columns != 0, axis=0))]
    return tuple(found)


def shared(problem: Problem, fit: joint.Joint) -> Array:
    """Return what the whole array shares of the effects found, but for clocks and zeros, (m,)."""
    total = np.zeros(len(problem.residual))
    for n, one in enumerate(fit.choices[len(problem.base) :], len(problem.base)):
        if "antenna" not in one.scope and not one.candidate.effect.in_arrays:
            total += joint.contribution(problem, fit, n)
    return total


def steps(fit: joint.Joint) -> list[float]:
    """Return the moments [s, UTC since 1970] at which the zeros were found to be set anew."""
    effects = [one.candidate.effect for one in fit.choices]
    return [e.parameter for e in effects if e.in_arrays == STEP and e.parameter is not None]


def blocks(problem: Problem, fit: joint.Joint, shapes: Sequence[Shape]) -> list[Block]:
    """Return every antenna's session that has enough pointings.

    Parameters
    ----------
    problem, fit
        The case, and the fit of all that was found: the steps in it part the zeros, and what
        the whole array shares is taken out.
    shapes
        What each block is asked for.
    """
    stack, at = problem.stack, problem.recordings.at
    columns = [stack.columns(one.effect, at)[:, one.coefficient] for one in shapes]
    zeros = np.concatenate([stack.columns(one, at) for one in _that_are(ZERO)], axis=1)
    since = _since(problem, steps(fit))
    zeros = np.concatenate([zeros * (since == k)[:, None] for k in np.unique(since)], axis=1)
    value = problem.residual - shared(problem, fit)
    antenna, session, number = problem.antenna, problem.session_names, measurements(problem)
    everything = np.stack([value, *columns, *zeros.T], axis=1)
    found = []
    for name, when in dict.fromkeys(zip(antenna.tolist(), session.tolist(), strict=True)):
        rows = np.flatnonzero((antenna == name) & (session == when))
        _, first, member = np.unique(number[rows], return_index=True, return_inverse=True)
        count = np.bincount(member)
        mean = np.stack([np.bincount(member, c) / count for c in everything[rows].T], axis=1)
        own = mean[:, 1 + len(shapes) :]
        own = own[:, np.any(own != 0, axis=0)]
        if len(first) >= len(shapes) + own.shape[1] + SPARE:
            floor = robust.rounding(value[rows]) / np.sqrt(np.median(count))
            row = stack.row[rows[first]]
            parts = (mean[:, 0], mean[:, 1 : 1 + len(shapes)], own)
            found.append(_block(name, when, row, *parts, floor))
    return _informed(found)


def _since(problem: Problem, moments: Sequence[float]) -> Codes:
    """Return for each reading how many of some moments, or rows, were past, shape (m,)."""
    if not moments:
        return np.zeros(len(problem.stack), np.intp)
    time = clock(problem.recordings.at)[problem.stack.row]
    return np.searchsorted(np.sort(moments), np.nan_to_num(time), side="right")


def _block(
    antenna: str, session: str, row: Codes, value: Array, shapes: Array, zeros: Array, floor: float
) -> Block:
    """Return a block with its robust weights and scatter; `_informed` adds what it says."""
    columns = np.concatenate([zeros, shapes], axis=1)
    weight, residual, _ = robust.weights(columns, value, FIRST_REACH, floor)
    spare = max(1.0, float(weight.sum()) - np.linalg.matrix_rank(columns))
    sigma = max(float(np.sqrt((weight * residual**2).sum() / spare)), floor, 1e-12)
    nothing = np.zeros(0)
    return Block(antenna, session, row, value, shapes, zeros, weight, sigma, nothing, nothing)


def _informed(found: Sequence[Block]) -> list[Block]:
    """Add what blocks say of their shapes, few pointings believing less in their own scatter."""
    usual = float(np.median([one.sigma for one in found])) if found else 0.0
    out = []
    for one in found:
        spare = max(1.0, one.weight.sum() - one.shapes.shape[1] - one.zeros.shape[1])
        sigma = np.sqrt((spare * one.sigma**2 + BORROWED * usual**2) / (spare + BORROWED))
        root = np.sqrt(one.weight)[:, None] / sigma
        basis = np.linalg.qr(one.zeros * root)[0]
        shapes, value = one.shapes * root, one.value * root[:, 0]
        shapes = shapes - basis @ (basis.T @ shapes)
        out.append(
            replace(one, sigma=float(sigma), information=shapes.T @ shapes, score=shapes.T @ value)
        )
    return out
