"""Cutting a matrix of columns where it is empty, so that nobody multiplies zeros."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import Array, Codes

#: A row whose length is below this share of its block's longest holds rounding and no more.
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
    power = np.einsum("nk,nk->n", whole, whole)
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
        first, last = int(rows[0]), int(rows[-1])
        values = whole[first : last + 1] if last - first == len(rows) - 1 else whole[rows]
        columns = np.flatnonzero(values.any(axis=0))
        if len(columns) < values.shape[1]:
            values = values.take(columns, axis=1)
        found.append(Slab(int(blocks[rows[0]]), rows, columns, values))
    return found


def without(some: Sequence[Slab], last: int) -> list[Slab]:
    """Leave the last column out of a block's slabs, and the rows that are empty without it."""
    found = []
    for slab in some:
        kept = slab.columns != last
        values = slab.values if kept.all() else slab.values[:, : kept.sum()]
        found.append(Slab(slab.block, slab.rows, slab.columns[kept], values))
    power = [np.einsum("nk,nk->n", slab.values, slab.values) for slab in found]
    least = EMPTY**2 * max((float(one.max(initial=0.0)) for one in power), default=0.0)
    return [
        slab
        if np.all(own > least)
        else Slab(slab.block, slab.rows[own > least], slab.columns, slab.values[own > least])
        for slab, own in zip(found, power, strict=True)
    ]
