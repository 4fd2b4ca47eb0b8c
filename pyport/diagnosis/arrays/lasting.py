"""What lasts in each antenna, what a session's antennas share, and what merely passes.

A shape's coefficient of antenna a in session s is

    own[a] + common[s] + passing[a, s]

with a common part only in shapes that a clock can move. The passing part is
random; how much it scatters is found for each shape by restricted maximum
likelihood, and its tails are heavy, so that a mount that was touched between
two days does not spoil the rest (Lange, Little & Taylor 1989, JASA 84, 881).
Where no antenna was seen twice nothing can be said to pass.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import ARCMIN, DEG, Array, Codes
from pyport.diagnosis.arrays.blocks import Block
from pyport.thresholds import WORSE

#: No mount and no clock is off by more [rad]: it ties down what recordings leave open.
BOUND = 1 * DEG
#: Degrees of freedom of the passing parts' Student distribution.
TAILS = 4.0
ROUNDS, SETTLED = 200, 1e-3
#: With a known scatter only the tails' weights are looked for: they settle soon.
FEW_ROUNDS = 4


@dataclass(frozen=True)
class Lasting:
    """The parts of an array's coefficients, k shapes, A antennas, S sessions.

    Attributes
    ----------
    antennas, sessions
        Their names.
    shared
        The shapes that have a common part.
    own, common
        Shape (A, k) and (S, k) [internal units]; own parts of shared shapes are zero on average
        over the antennas that are well known.
    covariance
        Of own (A k of them) and then of the shared shapes' common parts (S times those).
    scatter
        Of the passing parts, shape (k,).
    tails
        Each block's weight against heavy tails, shape (B, k).
    """

    antennas: tuple[str, ...]
    sessions: tuple[str, ...]
    shared: tuple[int, ...]
    own: Array
    common: Array
    covariance: Array
    scatter: Array
    tails: Array

    def own_covariance(self, shape: int) -> Array:
        """Return the covariance of one shape's own parts, shape (A, A)."""
        at = np.arange(len(self.antennas)) * self.own.shape[1] + shape
        return self.covariance[np.ix_(at, at)]

    def common_covariance(self, shape: int) -> Array:
        """Return the covariance of one shape's common parts, shape (S, S)."""
        width = len(self.shared)
        at = self.own.size + np.arange(len(self.sessions)) * width + self.shared.index(shape)
        return self.covariance[np.ix_(at, at)]

    def of(self, antenna: str, session: str) -> Array:
        """Return what is expected of an antenna in a session, shape (k,)."""
        found: Array = self.own[self.antennas.index(antenna)] + (
            self.common[self.sessions.index(session)] if session in self.sessions else 0.0
        )
        return found


@dataclass(frozen=True)
class _BlockData:
    """The blocks as arrays: whose, when, and what they say; shared shapes, A and S."""

    antenna: Codes
    session: Codes
    information: Array
    score: Array
    shared: Codes
    antennas: int
    sessions: int

    @property
    def places(self) -> Codes:
        """Return where each block's common parts stand, shape (B, c)."""
        width = len(self.shared)
        return self.session[:, None] * width + np.arange(width)

    def without(self, block: int) -> _BlockData:
        """Return them with one block less."""
        kept = np.arange(len(self.antenna)) != block
        return replace(
            self,
            antenna=self.antenna[kept],
            session=self.session[kept],
            information=self.information[kept],
            score=self.score[kept],
        )


@dataclass(frozen=True)
class _Solution:
    """A solution: parts, and the pieces of their covariance.

    `alone` (A, k, k) is that of own parts were the common ones known, `lever`
    (A, k, S c) how they follow the common ones, `shared` (S c, S c) that of the latter.
    """

    own: Array
    common: Array
    alone: Array
    lever: Array
    shared: Array

    def expected(self, data: _BlockData) -> Array:
        """Return what is expected of each block, shape (B, k)."""
        out = self.own[data.antenna].copy()
        out[:, data.shared] += self.common[data.places]
        return out

    def spread(self, data: _BlockData) -> Array:
        """Return the covariance of what is expected of each block, shape (B, k, k)."""
        follows = self.lever @ self.shared
        out = (self.alone + follows @ self.lever.transpose(0, 2, 1))[data.antenna]
        places, which = data.places, data.shared
        cross = np.take_along_axis(follows[data.antenna], places[:, None, :], axis=2)
        out[:, :, which] -= cross
        out[:, which, :] -= cross.transpose(0, 2, 1)
        rows = np.ix_(np.arange(len(out)), which, which)
        out[rows] += self.shared[places[:, :, None], places[:, None, :]]
        return out


def lasting(blocks: Sequence[Block], shared: Collection[int] = ()) -> Lasting:
    """Take the coefficients of an array apart.

    Parameters
    ----------
    blocks
        At least one.
    shared
        The shapes that have a part common to a session's antennas.
    """
    data, antennas, sessions = _together(blocks, shared)
    count, k = data.score.shape
    tails = np.ones((count, k))
    repeated = np.bincount(data.antenna).max() > 1
    variance = np.full(k, (ARCMIN / 2) ** 2 if repeated else 0.0)
    fit, square = _round(data, variance, tails)
    for _ in range(ROUNDS if repeated else 0):
        before = variance, tails
        variance = np.maximum((tails * square).mean(axis=0), (1e-3 * ARCMIN) ** 2)
        tails = (TAILS + 1) / (TAILS + square / variance)
        fit, square = _round(data, variance, tails)
        same = zip((variance, tails), before, strict=True)
        if all(np.allclose(now, was, rtol=SETTLED, atol=0) for now, was in same):
            break
    own, common, covariance = _levelled(data, fit)
    everywhere = np.zeros((len(sessions), k))
    everywhere[:, data.shared] = common.reshape(len(sessions), -1)
    return Lasting(
        antennas,
        sessions,
        tuple(data.shared.tolist()),
        own,
        everywhere,
        covariance,
        np.sqrt(variance),
        tails,
    )


def expected_without(blocks: Sequence[Block], whole: Lasting, held: int) -> Array:
    """Return what all other blocks expect of one, shape (k,).

    Parameters
    ----------
    blocks, whole
        All blocks, and their parts: the scatter of what passes is taken from them.
    held
        The number of the block that nothing else is used of.
    """
    some = list(range(len(blocks)))
    if not whole.shared:  # then other antennas have no say
        some = [n for n in some if blocks[n].antenna == blocks[held].antenna]
        held = some.index(held)
    full, *_ = _together([blocks[n] for n in some], whole.shared)
    data = full.without(held)
    variance = whole.scatter**2
    tails = np.delete(whole.tails[some], held, axis=0)
    # weights that the block itself had a say in
    tails[data.antenna == full.antenna[held]] = 1.0
    fit, square = _round(data, variance, tails)
    for _ in range(FEW_ROUNDS if variance.any() else 0):
        tails = (TAILS + 1) / (TAILS + square / variance)
        fit, square = _round(data, variance, tails)
    out = fit.own[full.antenna[held]].copy()
    out[full.shared] += fit.common[full.places[held]]
    return out


def _together(
    blocks: Sequence[Block], shared: Collection[int]
) -> tuple[_BlockData, tuple[str, ...], tuple[str, ...]]:
    """Return blocks as arrays, and the names of antennas and sessions."""
    antennas, antenna = np.unique([one.antenna for one in blocks], return_inverse=True)
    sessions, session = np.unique([one.session for one in blocks], return_inverse=True)
    data = _BlockData(
        antenna,
        session,
        np.stack([one.information for one in blocks]),
        np.stack([one.score for one in blocks]),
        np.array(sorted(shared), np.intp),
        len(antennas),
        len(sessions),
    )
    return data, tuple(map(str, antennas)), tuple(map(str, sessions))


def _round(data: _BlockData, variance: Array, tails: Array) -> tuple[_Solution, Array]:
    """Fit with given passing parts' variances; return it and their expected squares (B, k)."""
    power = variance / tails
    free = np.eye(power.shape[1]) + data.information * power[:, None, :]
    gain = np.asarray(np.linalg.solve(free, data.information), float)
    pull = np.asarray(np.linalg.solve(free, data.score[:, :, None])[:, :, 0], float)
    fit = _solve(data, gain, pull)
    part = power * (pull - (gain @ fit.expected(data)[:, :, None])[:, :, 0])
    inner = gain - gain @ fit.spread(data) @ gain
    left = power - power**2 * np.einsum("bii->bi", inner)
    return fit, part**2 + np.maximum(left, 0.0)


def _solve(data: _BlockData, gain: Array, pull: Array) -> _Solution:
    """Solve the normal equations, own parts eliminated antenna by antenna."""
    k, which, places = gain.shape[1], data.shared, data.places
    many = data.sessions * len(which)
    tie = BOUND**-2
    own = np.zeros((data.antennas, k, k)) + tie * np.eye(k)
    np.add.at(own, data.antenna, gain)
    own_right = np.zeros((data.antennas, k))
    np.add.at(own_right, data.antenna, pull)
    cross = np.zeros((data.antennas, k, many))
    at = (data.antenna[:, None, None], np.arange(k)[None, :, None], places[:, None, :])
    np.add.at(cross, at, gain[:, :, which])
    both = tie * np.eye(many)
    inner = gain[:, which][:, :, which]
    np.add.at(both, (places[:, :, None], places[:, None, :]), inner)
    right = np.zeros(many)
    np.add.at(right, places, pull[:, which])
    alone = np.asarray(np.linalg.inv(own), float)
    lever = alone @ cross
    value = (alone @ own_right[:, :, None])[:, :, 0]
    shared = np.linalg.inv(both - np.einsum("akc,akd->cd", lever, cross))
    common = shared @ (right - np.einsum("akc,ak->c", cross, value))
    return _Solution(value - lever @ common, common, alone, lever, shared)


def _levelled(data: _BlockData, fit: _Solution) -> tuple[Array, Array, Array]:
    """Return own (A, k), common (S c,) and covariance, own parts of shared shapes about zero."""
    antennas, k = fit.own.shape
    size = antennas * k
    lever = fit.lever.reshape(size, len(fit.common))
    follows = -lever @ fit.shared
    covariance = np.block([[-follows @ lever.T, follows], [follows.T, fit.shared]])
    for n in range(antennas):
        at = slice(n * k, (n + 1) * k)
        covariance[at, at] += fit.alone[n]
    value = np.concatenate([fit.own.ravel(), fit.common])
    width = len(data.shared)
    for n, shape in enumerate(data.shared):
        own = np.arange(antennas) * k + shape
        common = size + np.arange(data.sessions) * width + n
        well = well_known(covariance[np.ix_(own, own)])
        turn = np.eye(len(value))
        turn[np.ix_(own, own)] -= well / well.sum()
        turn[np.ix_(common, own)] += well / well.sum()
        value, covariance = turn @ value, turn @ covariance @ turn.T
    return value[:size].reshape(antennas, k), value[size:], covariance


def well_known(covariance: Array) -> Array:
    """Return one for antennas known nearly as well as the median one beside the others, else 0."""
    about = np.eye(len(covariance)) - 1 / len(covariance)
    variance = np.diag(about @ covariance @ about.T)
    return (variance <= WORSE**2 * np.median(variance)).astype(float)
