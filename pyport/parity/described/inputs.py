"""Where ports are held to the oracle: edges, random points, and what a description's code makes."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.parity.compare import neighbour
from pyport.parity.described.description import Batch, Description, Group, Routine, Variable
from pyport.parity.described.functions import inputs_of, joined, resolve, size

#: Random points are drawn in this many to one beside a threshold.
FAR_TO_NEAR = 4
#: A random point near a threshold is at most so many ulp from it: close by, or some way off.
NEAR_ULP = (3, 300)
#: Edges are pairs of inputs' special values, the others in the middle; of more than this only so
#: many are taken, evenly.
MOST_EDGES = 2000


def points(
    description: Description, group: Group, routine: Routine, n: int, seed: int | list[int]
) -> Batch:
    """Return the points of a group for a routine; n and seed count where the group draws."""
    if group.make == "edges":
        return edges(routine)
    if group.make == "random":
        return random(routine, n, seed)
    function = resolve(description, group.make)
    made = function(n, seed) if group.draws else function()
    return inputs_of(routine, lower(made, group.make))


def sample(description: Description, group: Group, routine: Routine) -> Batch:
    """Return those points of a group whose answers are stored."""
    if group.sample:
        return inputs_of(routine, lower(resolve(description, group.sample)(), group.sample))
    return points(description, group, routine, group.keep, group.seed)


def lower(made: Any, name: str) -> Batch:  # noqa: ANN401 - whatever the function returned
    """Return what a function of a description made as a batch."""
    if not isinstance(made, dict) or not made:
        raise BadInput(f"{name} returned no points: expected a dict of arrays by input")
    batch = {str(key).lower(): np.asarray(values) for key, values in made.items()}
    if len({len(values) for values in batch.values()}) != 1:
        raise BadInput(f"{name} returned arrays of different lengths")
    return batch


def around(value: float, dtype: np.dtype, steps: int = 2) -> list[Any]:
    """Return a number of a kind and its neighbours, up to `steps` either side."""
    if dtype.kind != "f":
        return [dtype.type(value + step) for step in range(-steps, steps + 1)]
    with np.errstate(over="ignore"):
        below = above = np.asarray(value, dtype)
    result = [below]
    for _ in range(steps):
        below, above = neighbour(below, -np.inf), neighbour(above, np.inf)
        result += [below, above]
    return [one[()] for one in result]


def special(one: Variable) -> list[Any]:
    """Return the values of a variable that a test must not miss, the most usual one first."""
    dtype = one.type.dtype()
    if one.values:
        return [one.type.value(value)[()] for value in one.values]
    base = one.type.base
    if base == "logical":
        return list(np.array([False, True]))
    if base == "character":
        return [one.type.value(text)[()] for text in ("", "A", "z" * one.type.size, "0")]
    middle = (one.low + one.high) / 2 if base == "real" else (int(one.low) + int(one.high)) // 2
    if one.logarithmic:
        middle = math.sqrt(one.low * one.high)
    found = [dtype.type(middle)]
    ends = [one.low, one.high] + ([-one.low, -one.high] if one.logarithmic else [])
    for value in ends:
        # neighbours inside the range only: what is beyond it nobody promised
        found += [v for v in around(value, dtype) if one.logarithmic or one.low <= v <= one.high]
    if one.low <= 0 <= one.high or one.logarithmic:
        zeros = [0.0, -0.0, 1e-6, -1e-6] if base == "real" else [0, 1, -1]
        found += [dtype.type(v) for v in zeros if one.logarithmic or one.low <= v <= one.high]
    for threshold in one.thresholds:
        found += around(threshold, dtype)
    return list({np.asarray(v).tobytes(): v for v in found}.values())


def edges(routine: Routine) -> Batch:
    """Return each pair of inputs at each pair of their special values, the others usual."""
    if not routine.inputs:
        return inputs_of(routine, {})
    lists = {one.key: special(one) for one in routine.inputs}
    usual = {key: values[0] for key, values in lists.items()}
    keys = list(lists)
    pairs = itertools.combinations(keys, 2) if len(keys) > 1 else [(keys[0], keys[0])]
    rows = [usual | {a: x, b: y} for a, b in pairs for x in lists[a] for y in lists[b]]
    step = max(1, math.ceil(len(rows) / MOST_EDGES))
    rows = rows[::step] if step > 1 else rows
    result = {}
    for one in routine.inputs:
        values = np.array([row[one.key] for row in rows], dtype=one.type.dtype())
        # an array has the special value in one place after the other, and then everywhere
        wide = np.repeat(values[:, None], math.prod(one.shape), axis=1) if one.shape else values
        if one.shape:
            place = np.arange(len(rows)) % (wide.shape[1] + 1)
            elsewhere = (np.arange(wide.shape[1]) != place[:, None]) & (place != wide.shape[1])[
                :, None
            ]
            wide = np.where(elsewhere, usual[one.key], wide)
        result[one.key] = wide.reshape(len(rows), *one.shape)
    return inputs_of(routine, result)


def random(routine: Routine, n: int, seed: int | list[int]) -> Batch:
    """Return n random points: four in five anywhere in the ranges, the others near thresholds."""
    rng = np.random.default_rng(seed)
    drawn = {one.key: _drawn(one, n, rng) for one in routine.inputs}
    return inputs_of(routine, drawn or {"": np.zeros(n, np.int8)})


def _drawn(one: Variable, n: int, rng: np.random.Generator) -> NDArray:
    shape = (n, *one.shape)
    dtype = one.type.dtype()
    base = one.type.base
    if one.values:
        return np.array([one.type.value(v)[()] for v in one.values], dtype)[
            rng.integers(0, len(one.values), shape)
        ]
    if base == "logical":
        return rng.random(shape) < 0.5
    if base == "character":
        letters = rng.integers(32, 127, (n, one.type.size), dtype=np.uint8)
        return np.ascontiguousarray(letters).view(f"S{one.type.size}").reshape(shape)
    values: NDArray
    if base == "integer":
        values = rng.integers(int(one.low), int(one.high), shape, endpoint=True)
    elif one.logarithmic:
        values = 10 ** rng.uniform(math.log10(one.low), math.log10(one.high), shape)
        values = values * rng.choice([-1, 1], shape) * (rng.random(shape) >= 0.1)
    else:
        values = rng.uniform(one.low, one.high, shape)
    values = values.astype(dtype)
    turns = [t for t in (*one.thresholds, 0.0) if one.low <= t <= one.high]
    near = rng.random(shape) < 1 / (FAR_TO_NEAR + 1)
    if one.thresholds and near.any():
        values[near] = nudged(rng.choice(turns, near.sum()).astype(dtype), rng)
    return values


def nudged(values: NDArray, rng: np.random.Generator) -> NDArray:
    """Return numbers moved by a few ulp, half of them by some hundreds; integers by one or two."""
    if values.dtype.kind != "f":
        return values + rng.integers(-2, 2, values.shape, endpoint=True).astype(values.dtype)
    scale = rng.choice(NEAR_ULP, values.shape)
    steps = np.rint(rng.uniform(-1, 1, values.shape) * scale).astype(values.dtype)
    # around zero an ulp is too little to matter: that of a thousandth
    spacing = np.spacing(np.maximum(np.abs(values), values.dtype.type(1e-3)))
    return values + steps * spacing


def sizes(description: Description, random_points: int) -> dict[str, dict[str, int]]:
    """Return for each group and routine how many points a live run has."""
    return {
        group.name: {
            routine.name: random_points
            if group.draws
            else size(points(description, group, routine, 0, 0))
            for routine in description.routines
        }
        for group in description.groups
    }


def some(description: Description, routine: Routine, n: int, seed: int) -> Batch:
    """Return the points of all groups for a routine, n of each that draws."""
    return joined([points(description, group, routine, n, seed) for group in description.groups])
