"""Sufficient statistics: what least squares needs of the data, added up block by block.

For the rows of one block (an antenna in a session) and whitened columns
C = [c1 .. cK | data] the matrix C'C is all that any least-squares fit asks
for. A model picks columns and says for each whether its coefficient is one
for all blocks, one per session, one per antenna, or one per block.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes

#: A row whose length is below this share of its block's longest holds rounding and no more, each
#: column measured by its own length.
EMPTY = 1e-9


@dataclass(frozen=True)
class Slab:
    """Rows of one block that leave the same columns empty, without those columns."""

    block: int  #: the block
    #: `rows`, `columns`: where they stand in the whole, shapes (n,) and (k,).
    rows: Codes
    columns: Codes
    values: Array  #: what stands there, shape (n, k)


def slabs(whole: Array, blocks: Codes, kinds: Codes) -> list[Slab]:
    """Cut a matrix into slabs, block by block and kind by kind.

    `whole`: the columns, shape (m, K).
    `blocks`, `kinds`: the block of each row and, within it, the kind: rows of one kind (one axis,
      say) have much the same columns empty, shape (m,) each.
    """
    power = _lengths(whole, _per_length(np.einsum("nk,nk->k", whole, whole)))
    most = np.zeros(int(blocks.max(initial=-1)) + 1)
    np.maximum.at(most, blocks, power)
    there = power > EMPTY**2 * most[blocks]
    order = np.lexsort((kinds, blocks))
    order = order[there[order]]
    changes = np.any(np.diff(np.stack([blocks, kinds])[:, order]) != 0, axis=0)
    found = []
    for rows in np.split(order, np.flatnonzero(changes) + 1):
        if len(rows) == 0:
            continue
        values = whole[in_place(rows)]
        columns = np.flatnonzero(values.any(axis=0))
        if len(columns) < values.shape[1]:
            values = values.take(columns, axis=1)
        found.append(Slab(int(blocks[rows[0]]), rows, columns, values))
    return found


def in_place(rows: Codes) -> Codes | slice:
    """Return ascending rows as a slice where they follow each other: it copies nothing."""
    if len(rows) == 0 or rows[-1] - rows[0] >= len(rows):
        return rows
    return slice(int(rows[0]), int(rows[-1]) + 1)


def without(some: Sequence[Slab], last: int) -> list[Slab]:
    """Leave the last column out of a block's slabs, and the rows that are empty without it."""
    found = []
    for slab in some:
        kept = slab.columns != last
        values = slab.values if kept.all() else slab.values[:, : kept.sum()]
        found.append(Slab(slab.block, slab.rows, slab.columns[kept], values))
    length = np.zeros(last)
    for slab in found:
        length[slab.columns] += np.einsum("nk,nk->k", slab.values, slab.values)
    unit = _per_length(length)
    power = [_lengths(slab.values, unit[slab.columns]) for slab in found]
    least = EMPTY**2 * max((float(one.max(initial=0.0)) for one in power), default=0.0)
    return [
        slab
        if np.all(own > least)
        else Slab(slab.block, slab.rows[own > least], slab.columns, slab.values[own > least])
        for slab, own in zip(found, power, strict=True)
    ]


#: Rows of whitened columns that are worked on at a time: fewer stay in the processor's cache.
AT_A_TIME = 512


def _lengths(rows: Array, per: Array) -> Array:
    """Return the squared lengths of rows (n, k), each column's squares in units of its own."""
    starts = range(0, len(rows), AT_A_TIME)
    parts = [rows[low : low + AT_A_TIME] ** 2 @ per for low in starts]
    return np.concatenate([np.zeros(0), *parts])


def _per_length(power: Array) -> Array:
    """Return one over the squared lengths of columns, zero for empty ones."""
    return np.divide(1.0, power, out=np.zeros_like(power), where=power > 0)


#: Directions with less than this share of a column's length count as fitted already.
RANK_TOLERANCE = 1e-9
#: What must be left of a column's squared length for products alone to distinguish it.
PLAIN = 1e-4


@dataclass(frozen=True)
class Part:
    """Some columns of the Gram matrices, and which blocks share their coefficients."""

    columns: Codes  #: indices of the columns, shape (k,)
    groups: Codes  #: for each block the number of its set of coefficients, shape (blocks,)

    @property
    def size(self) -> int:
        """Return the number of coefficients."""
        return len(self.columns) * (int(self.groups.max()) + 1)

    def places(self) -> Codes:
        """Return where each block's coefficients stand among all of this part's, (blocks, k)."""
        k = len(self.columns)
        return self.groups[:, None] * k + np.arange(k)


@dataclass(frozen=True)
class Solution:
    """The least-squares solution of a choice of parts."""

    #: `values`, `covariance`: coefficients (P,) and their covariance (P, P) for unit weight.
    values: Array
    covariance: Array
    known: NDArray[np.bool_]  #: whether the data determine each coefficient, shape (P,)
    residual: float  #: sum of squares that is left
    rank: int  #: number of independent columns, of those known beforehand as many as they fit
    normal: Array  #: products of the columns, what is known beforehand added, shape (P, P)

    @classmethod
    def of(cls, products: Array, precision: Array | float = 0.0) -> Solution:
        """Return the solution from products (P + 1, P + 1) of the columns and, last, the data.

        `precision` (P,): what is known of each coefficient beforehand, one over the variance of a
        normal about zero; nothing where it is zero.
        """
        right = products[:-1, -1]
        precision = np.full(len(right), precision)
        normal = products[:-1, :-1] + np.diag(precision)
        inverse, rank, known = inverse_of(normal)
        values = inverse @ right
        left = float(products[-1, -1] - right @ values - precision @ values**2)
        rank -= round(float(precision @ np.diag(inverse)))
        return cls(values, inverse, known, left, rank, normal)

    @cached_property
    def condition(self) -> float:
        """Return the condition number of the columns, each scaled to unit length."""
        return inverted(self.normal)[2]


class Gram:
    """The Gram matrices of all blocks, shape (blocks, K + 1, K + 1); the data come last."""

    def __init__(self, matrices: Array):
        self.matrices = matrices

    @classmethod
    def of(cls, whitened: Array, blocks: Codes, n_blocks: int, kinds: Codes | None = None) -> Gram:
        """Return the matrices of whitened columns (m, K + 1) whose rows belong to `blocks` (m,).

        Rows of one of the `kinds` (m,) have the same columns empty: what is empty costs nothing.
        """
        kinds = np.zeros_like(blocks) if kinds is None else kinds
        return cls.summed(slabs(whitened, blocks, kinds), n_blocks, whitened.shape[1])

    @classmethod
    def summed(cls, cut: Sequence[Slab], n_blocks: int, size: int) -> Gram:
        """Return the matrices of whitened columns (m, size) that were cut into slabs."""
        out = np.zeros((n_blocks, size, size))
        for slab in cut:
            out[slab.block][np.ix_(slab.columns, slab.columns)] += slab.values.T @ slab.values
        return cls(out)

    def cross(self, left: Sequence[Part], right: Sequence[Part]) -> Array:
        """Return the assembled products of two choices of parts, shape (P, Q)."""
        (rows, row_columns), (places, columns) = self._index(left), self._index(right)
        shape = sum(p.size for p in left), sum(p.size for p in right)
        own = self.matrices[:, row_columns[:, None], columns]
        flat = rows[:, :, None] * shape[1] + places[:, None, :]
        total = np.bincount(flat.ravel(), own.ravel(), shape[0] * shape[1])
        return np.asarray(total, float).reshape(shape)

    def moments(self, parts: Sequence[Part], vectors: Array | None = None) -> Array:
        """Return the assembled products with the data, shape (P,).

        `vectors`, (blocks, K, draws), stands for other data than the recorded
        ones; the result is then (P, draws).
        """
        places, columns = self._index(parts)
        size = sum(p.size for p in parts)
        if vectors is None:
            own = self.matrices[:, columns, -1]
            return np.asarray(np.bincount(places.ravel(), own.ravel(), size), float)
        out = np.zeros((size, vectors.shape[2]))
        for block, own in zip(places, vectors, strict=True):
            out[block] += own[columns]
        return out

    def _index(self, parts: Sequence[Part]) -> tuple[Codes, Codes]:
        return index(parts, len(self.matrices))

    def total(self) -> float:
        """Return the sum of squares of the data."""
        return float(self.matrices[:, -1, -1].sum())

    def solve(self, parts: Sequence[Part], precision: Array | float = 0.0) -> Solution:
        """Return the least-squares solution for a choice of parts; `precision`: `Solution.of`."""
        right = self.moments(parts)[:, None]
        data = np.array([[self.total()]])
        products = np.block([[self.cross(parts, parts), right], [right.T, data]])
        return Solution.of(products, precision)


def index(parts: Sequence[Part], blocks: int) -> tuple[Codes, Codes]:
    """Return where each block's coefficients stand, (blocks, p), and the columns they multiply."""
    if not parts:
        return np.zeros((blocks, 0), np.intp), np.zeros(0, np.intp)
    starts = np.cumsum([0, *(part.size for part in parts[:-1])])
    places = [start + part.places() for start, part in zip(starts, parts, strict=True)]
    return np.concatenate(places, axis=1), np.concatenate([part.columns for part in parts])


def spanned(columns: Array) -> tuple[Array, Array, Array]:
    """Return orthonormal directions (n, r) that span columns (n, k), with their strengths (r,).

    Columns are scaled to unit length first, and what is left of them by rounding is no direction;
    last come their lengths (k,).
    """
    length = np.linalg.norm(columns, axis=0)
    unit = columns / np.where(length > 0, length, 1.0)
    basis, strength, _ = np.linalg.svd(unit, full_matrices=False)
    kept = strength > EMPTY * strength.max(initial=1e-300)
    return np.asarray(basis[:, kept]), strength[kept], length


def beyond(columns: Array, values: Array) -> Array:
    """Return what least squares on columns (n, k) leaves of values, (n,) or (n, K)."""
    return np.asarray(values - columns @ np.linalg.lstsq(columns, values, rcond=1e-9)[0])


def inverse_of(normal: Array) -> tuple[Array, int, NDArray[np.bool_]]:
    """Return what `inverted` returns but the condition number, sooner where columns differ well."""
    size = len(normal)
    length = np.sqrt(np.maximum(np.diag(normal), 0.0))
    if size and length.all():
        scale = np.outer(length, length)
        triangle = cholesky(normal / scale)
        if triangle is not None:
            root = np.linalg.solve(triangle, np.eye(size))
            return root.T @ root / scale, size, np.ones(size, bool)
    inverse, rank, _, known = inverted(normal)
    return inverse, rank, known


def solved(normal: Array, right: Array) -> Array:
    """Return the least-squares solution of normal equations (P, P) and (P,)."""
    length = np.sqrt(np.maximum(np.diag(normal), 0.0))
    if length.all():
        scaled = normal / length / length[:, None]
        if cholesky(scaled) is not None:
            return np.asarray(np.linalg.solve(scaled, right / length) / length)
    return np.asarray(inverted(normal)[0] @ right)


def cholesky(scaled: Array) -> Array | None:
    """Return the triangle of products of unit columns; None where some are nearly the others'.

    Columns whose squared lengths, each beside those before it, stay above
    `PLAIN` are distinguished by their products to ten digits and more.
    """
    try:
        triangle = np.linalg.cholesky(scaled)
    except np.linalg.LinAlgError:
        return None
    apart = np.diag(triangle).min(initial=1.0) ** 2 > PLAIN
    return np.asarray(triangle, float) if apart else None


def inverted(normal: Array) -> tuple[Array, int, float, NDArray[np.bool_]]:
    """Return the pseudo-inverse of a normal matrix, its rank, condition number and what is known.

    Columns are scaled to unit length first, so that units do not matter. A
    coefficient is known when no direction that the data leave open moves it.
    """
    size = len(normal)
    if size == 0:
        return np.zeros((0, 0)), 0, 1.0, np.zeros(0, bool)
    length = np.sqrt(np.maximum(np.diag(normal), 0.0))
    scale = np.divide(1.0, length, out=np.zeros(size), where=length > 0)
    eigenvalues, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    good = eigenvalues > RANK_TOLERANCE * max(float(eigenvalues[-1]), 1e-300)
    kept = vectors[:, good]
    inverse = (kept / eigenvalues[good]) @ kept.T * np.outer(scale, scale)
    known = (vectors[:, ~good] ** 2).sum(axis=1) < 1e-6
    rank = int(good.sum())
    condition = float(np.sqrt(eigenvalues[-1] / eigenvalues[good][0])) if rank else float("inf")
    return inverse, rank, condition, known & (length > 0)
