"""Cells: readings that share labels, a patch of sky, a stretch of time and a direction of scan."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array
from pyport.errors import BadInput
from pyport.recordings.stream.chunk import Chunk

Codes = NDArray[np.int64]

#: The finest cells: patches of this width [deg], stretches of this length [s].
PATCH_DEG, STRETCH_S = 1.0, 900.0
#: How cells grow when there are too many: patches and stretches, as powers of two of the finest.
LEVELS: tuple[tuple[int, int], ...] = (
    (0, 0), (0, 1), (0, 2), (1, 2), (1, 3), (1, 4), (2, 4), (2, 5), (2, 7), (2, 9), (2, 11),
    (2, 13), (2, 62), (3, 62), (4, 62), (5, 62),
)  # fmt: skip
#: Stretches of this power take in all times.
ALWAYS = 62

#: Bits of a cell's key: elevation, azimuth, direction of scan; time takes what is left.
_EL, _AZ, _DIRECTION = 8, 12, 2
#: Bits that a key needs in this century, and bits left above it for the label.
_KEY, _LABELS = 44, 19
_LOWEST_DEG, _FIRST_DEG = -16.0, -1024.0


@dataclass(frozen=True)
class Cells:
    """Sums over the rows of each cell.

    `level`: how large they are: which of `LEVELS`.
    `names`, `label_names`: the sets of labels, and which labels these are values of.
    `label`, `key`: which set of labels each cell has, and its place in sky and time, shape (c,);
      sorted.
    `sums`, `totals`: what is summed, by name, and the sums, shape (c, T).
    """

    level: int
    label_names: tuple[str, ...]
    names: list[tuple[str, ...]]
    label: Codes
    key: Codes
    sums: tuple[str, ...]
    totals: Array

    def __len__(self) -> int:
        """Return c."""
        return len(self.key)

    def directions(self) -> Array:
        """Return the direction of the scans of each cell, +1, -1 or 0, shape (c,)."""
        number = (self.key >> (_EL + _AZ)) & ((1 << _DIRECTION) - 1)
        return number.astype(float) - 1


def key_of(chunk: Chunk, level: int) -> Codes:
    """Return the place of each row in sky, time and direction of scan, shape (n,)."""
    patch, stretch = LEVELS[level]
    el = ((chunk.el / DEG - _LOWEST_DEG) / PATCH_DEG).astype(np.int64)
    az = ((chunk.az / DEG - _FIRST_DEG) / PATCH_DEG).astype(np.int64)
    time = np.floor(chunk.time / STRETCH_S).astype(np.int64)
    return _packed(time >> stretch, chunk.direction.astype(np.int64) + 1, az >> patch, el >> patch)


def _packed(time: Codes, direction: Codes, az: Codes, el: Codes) -> Codes:
    return ((((time << _DIRECTION) | direction) << _AZ | az) << _EL) | el


def grown(key: Codes, before: int, after: int) -> Codes:
    """Return the keys of the larger cells that cells lie in."""
    (patch, stretch), (wider, longer) = LEVELS[before], LEVELS[after]
    el = key & ((1 << _EL) - 1)
    az = (key >> _EL) & ((1 << _AZ) - 1)
    direction = (key >> (_EL + _AZ)) & ((1 << _DIRECTION) - 1)
    time = key >> (_EL + _AZ + _DIRECTION)
    more = wider - patch
    return _packed(time >> (longer - stretch), direction, az >> more, el >> more)


def grouped(label: Codes, key: Codes) -> tuple[Codes, Codes]:
    """Return the first row of each cell, in the order of labels and keys, and each row's cell."""
    if len(key) == 0:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    # Rows that follow each other mostly share a cell: only runs of such rows are put in order.
    runs = _starts(label, key)
    labels, keys = label[runs], key[runs]
    if int(labels.max()) < 1 << _LABELS:
        order = np.argsort((labels << _KEY) + keys)
    else:
        order = np.lexsort((keys, labels))
    starts = _starts(labels[order], keys[order])
    cell = np.empty(len(runs), np.int64)
    cell[order] = np.repeat(np.arange(len(starts)), np.diff(starts, append=len(runs)))
    return runs[order[starts]], np.repeat(cell, np.diff(runs, append=len(key)))


def _starts(label: Codes, key: Codes) -> Codes:
    """Return the rows whose label or key is not that of the row before."""
    changed = (np.diff(key) != 0) | (np.diff(label) != 0)
    return np.flatnonzero(np.concatenate([[True], changed]))


def merged(some: Sequence[Cells], level: int) -> Cells:
    """Return the sums of several tables in cells of a level, their labels in alphabetic order."""
    sums = some[0].sums
    for one in some:
        if one.sums != sums:
            odd = sorted({name.partition(":")[0] for name in {*one.sums} ^ {*sums}})
            raise BadInput(f"some files of the data set have no column {', '.join(odd)}")
    label_names = tuple(sorted({name for one in some for name in one.label_names}))
    every: dict[tuple[str, ...], int] = {}
    wide = [[_spread(words, one.label_names, label_names) for words in one.names] for one in some]
    for words in sorted({words for table in wide for words in table}):
        every[words] = len(every)
    label = np.concatenate(
        [
            np.array([every[words] for words in table], np.int64)[one.label]
            for one, table in zip(some, wide, strict=True)
        ]
    )
    key = np.concatenate([grown(one.key, one.level, level) for one in some])
    totals = np.concatenate([one.totals for one in some])
    first, cell = grouped(label, key)
    added = np.stack([np.bincount(cell, one, len(first)) for one in totals.T], axis=1).astype(float)
    return Cells(level, label_names, list(every), label[first], key[first], sums, added)


def _spread(
    words: tuple[str, ...], names: tuple[str, ...], wanted: tuple[str, ...]
) -> tuple[str, ...]:
    """Return labels in the order of all labels, blank where these do not tell one."""
    of = dict(zip(names, words, strict=True))
    return tuple(of.get(name, "") for name in wanted)


def shrunk(cells: Cells, most: int, size: Callable[[Cells], int] = len) -> Cells:
    """Return the cells, grown until their size is `most` or less, or as far as they can grow."""
    while size(cells) > most and cells.level + 1 < len(LEVELS):
        cells = merged([cells], cells.level + 1)
    return cells


class Gathered:
    """A running sum of tables of cells, never of more than so many cells.

    Tables are added up in the order in which they come, a few at a time, so
    that the same tables give the same sums to the last digit whoever made them.
    """

    def __init__(self, most: int):
        self.most = most
        self.sum: Cells | None = None
        self.waiting: list[Cells] = []

    def add(self, cells: Cells) -> None:
        """Add a table."""
        self.waiting.append(cells)
        if sum(map(len, self.waiting)) > max(self.most // 4, len(self.sum or ()) // 2):
            self.total()

    @property
    def anything(self) -> bool:
        """Tell whether any table was added."""
        return self.sum is not None or bool(self.waiting)

    def as_state(self) -> tuple[list[dict[str, Any]], dict[str, NDArray[Any]]]:
        """Return what it holds, table by table, so that `of_state` goes on to the last digit."""
        kept: list[dict[str, Any]] = []
        arrays: dict[str, NDArray[Any]] = {}
        for n, one in enumerate([*([] if self.sum is None else [self.sum]), *self.waiting]):
            words = {"level": one.level, "labels": one.label_names, "names": one.names}
            kept.append(words | {"sums": one.sums, "waits": one is not self.sum})
            arrays |= {f"label{n}": one.label, f"key{n}": one.key, f"totals{n}": one.totals}
        return kept, arrays

    @classmethod
    def of_state(
        cls, most: int, kept: list[dict[str, Any]], arrays: Mapping[str, NDArray[Any]]
    ) -> Gathered:
        """Return the running sum that `as_state` kept."""
        found = cls(most)
        for n, words in enumerate(kept):
            one = Cells(
                words["level"],
                tuple(words["labels"]),
                [tuple(name) for name in words["names"]],
                arrays[f"label{n}"],
                arrays[f"key{n}"],
                tuple(words["sums"]),
                arrays[f"totals{n}"],
            )
            if words["waits"]:
                found.waiting.append(one)
            else:
                found.sum = one
        return found

    def total(self) -> Cells:
        """Return the sum of all tables so far."""
        some = [*([self.sum] if self.sum is not None else []), *self.waiting]
        level = max(one.level for one in some)
        self.sum, self.waiting = shrunk(merged(some, level), self.most), []
        return self.sum
