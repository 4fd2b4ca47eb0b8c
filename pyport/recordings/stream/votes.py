"""The second pass: means of the readings near their cell's middle, the others having no vote."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.columns import COLUMNS, angle_of
from pyport.least_squares import robust
from pyport.recordings.stream.cells import Cells, Codes
from pyport.recordings.stream.chunk import Chunk
from pyport.recordings.stream.middles import Middle
from pyport.recordings.stream.points import SUMMED

#: Readings beyond this many sigmas of their cell's middle lose weight as Tukey takes it from them.
REACH = 6.0
#: A reading of less weight than this is an outlier.
OUTLIER = 0.05
#: Angles whose mean is that of directions.
CIRCULAR = frozenset(one.name for one in COLUMNS if one.circular)


def second_totals(
    chunk: Chunk, label: Codes, key: Codes, cell: Codes, middle: Middle
) -> tuple[tuple[str, ...], Array]:
    """Return weighted sums on each axis, and sums of everything else, as `points` names them."""
    count = len(key)
    own_label = _labels_in(chunk, middle.cells)
    place = places_of(middle.cells, own_label[label], key)
    out = [np.bincount(cell, minlength=count)]
    for axis, values in enumerate((chunk.x, chunk.y)):
        off = values - middle.cells.totals[place, axis][cell]
        there = ~np.isnan(off)
        weight = there.astype(float)
        sigma = middle.scale[own_label, axis][chunk.label]
        far = np.flatnonzero(np.abs(off) > 3 * sigma)
        weight[far] = robust.flat_weight(off[far] / sigma[far], 1.0, REACH)
        known = np.where(there, values, 0.0)
        pulled = weight * known
        out += [
            np.bincount(cell, there, count),
            np.bincount(cell, weight, count),
            np.bincount(cell, pulled, count),
            np.bincount(cell, pulled * known, count),
            np.bincount(cell[far], weight[far] < OUTLIER, count),
        ]
    out += [np.bincount(cell, one, count) for one in (chunk.az, chunk.el, chunk.time)]
    sums = list(SUMMED)
    for name, values in chunk.numbers.items():
        there = ~np.isnan(values)
        for what, one in _linear(name, np.where(there, values, 0.0)).items():
            sums.append(f"{name}:{what}")
            out.append(np.bincount(cell, one * there, count))
    return tuple(sums), np.stack(out, axis=1).astype(float)


def _linear(name: str, values: Array) -> dict[str, Array | float]:
    """Return what a column's mean is taken of: itself, or sine and cosine of a direction."""
    angle = angle_of(name)
    if angle is None or angle[0] not in CIRCULAR:
        return {"count": 1.0, "sum": values}
    radians = values * angle[1]
    return {"count": 1.0, "sine": np.sin(radians), "cosine": np.cos(radians)}


def _labels_in(chunk: Chunk, cells: Cells) -> Codes:
    """Return the number that each set of labels of a chunk has among a table's."""
    number = {words: n for n, words in enumerate(cells.names)}
    found = []
    for words in chunk.names:
        of = dict(zip(chunk.label_names, words, strict=True))
        found.append(number[tuple(of.get(name, "") for name in cells.label_names)])
    return np.array(found, np.int64)


def places_of(cells: Cells, label: Codes, key: Codes) -> Codes:
    """Return where cells stand in a sorted table that has them all."""
    low = np.searchsorted(cells.label, label, side="left")
    place = np.empty(len(key), np.int64)
    for one in np.unique(label):
        mine = label == one
        start = int(low[np.argmax(mine)])
        stop = int(np.searchsorted(cells.label, one, side="right"))
        place[mine] = start + np.searchsorted(cells.key[start:stop], key[mine])
    return place
