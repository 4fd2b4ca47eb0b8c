"""Boxes: a stretch of azimuth and of elevation inside which there is an offset."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from pyport.angles import DEG, Array
from pyport.diagnosis.naming.finding import Interval
from pyport.diagnosis.shapes.edges import climbed
from pyport.diagnosis.shapes.fields import Ground
from pyport.diagnosis.shapes.forms import Field
from pyport.effects.empirical import fields
from pyport.effects.empirical.fields import Bumps, inside
from pyport.thresholds import FEWEST

#: Cells that the sky is cut into: of equal width around, of equal counts upward.
AROUND, UPWARD = 24, 16
#: A box is at most so many cells wide.
WIDEST = 16
#: First step by which an edge is moved. [rad]
_FIRST = 6 * DEG

#: Edges in pairs, each the lower first: of azimuth, and of elevation where there are some. [rad]
Edges = Array


def boxes(ground: Ground) -> list[Field]:
    """Return the box of each axis whose offset explains most of what a model leaves."""
    problem, seen = ground.problem, ground.plain
    at, row = problem.recordings.at, problem.stack.row
    az, el = at.az % (2 * np.pi), at.el
    found = []
    for axis, is_y in (("xel", False), ("el", True)):
        of_axis = problem.stack.is_y[seen.rows] == is_y
        if of_axis.sum() < 4 * FEWEST:
            continue
        rows = row[seen.rows[of_axis]]
        weight = seen.root[of_axis] ** 2
        pull = seen.root[of_axis] * seen.left[of_axis]
        # A box is held against what is outside of it, whether a zero is fitted or not.
        pull -= weight * (pull.sum() / weight.sum())
        start, tried = _scanned(az[rows], el[rows], weight, pull)
        edges = _widest(_gain_of(az[rows], el[rows], weight, pull), start)
        there = inside(az[row], el[row], edges)
        left, right, low, high = (float(edge / DEG) for edge in edges)
        region = Interval("az_deg", left % 360, right % 360), Interval("el_deg", low, high)
        words = (
            f"{axis}: inside azimuth {left % 360:.1f} to {right % 360:.1f} deg, "
            f"elevation {low:.1f} to {high:.1f} deg"
        )
        exact = [float(edge) for edge in edges]
        bumps = {"kind": "box", "az_rad": exact[:2], "el_rad": exact[2:]}
        found.append(
            Field(
                "an offset",
                words,
                there[:, None].astype(float),
                problem.stack.is_y,
                tried,
                region=region,
                bumps=bumps,
                axes=(int(is_y),),
                which=(0,),
            )
        )
    return found


def sectors(ground: Ground) -> Iterator[Field]:
    """Yield the stretch of each axis in which its angle is off, wherever the other one stands.

    An encoder that slipped or lost a bit, a cable or a limit switch part a circle in two. What the
    first angle is off by falls on the sky as the cosine of the second.
    """
    is_y, at = ground.problem.stack.is_y, ground.problem.recordings.at
    first, second = (f"{axis.column}_deg" for axis in (at.mount.first, at.mount.second))
    around = np.arange(AROUND + WIDEST) * 2 * np.pi / AROUND
    upward = np.unique(np.quantile(at.axes.el, np.linspace(0, 1, UPWARD + 1)))
    if np.count_nonzero(~is_y) >= 4 * FEWEST:
        yield _sector(ground, "xel", first, around, _of_first)
    if np.count_nonzero(is_y) >= 4 * FEWEST and len(upward) > UPWARD // 2:
        yield _sector(ground, "el", second, upward, _of_second)


def _of_first(low: float, high: float) -> Bumps:
    return {"kind": "sector", "az_rad": [low, high], "in_axes": True}


def _of_second(low: float, high: float) -> Bumps:
    bumps = {"kind": "stretch", "name": "el_deg", "low_rad": low, "high_rad": high}
    return bumps | {"in_axes": True}


def _sector(
    ground: Ground, axis: str, name: str, cuts: Array, bumps_of: Callable[[float, float], Bumps]
) -> Field:
    """Return the stretch of one axis in which its angle is off, from one of some cuts to another.

    A stretch is much like what a model has, so that edges are looked for beside that.
    """
    problem = ground.problem
    own = problem.stack.is_y == (axis == "el")

    def column(bumps: Bumps) -> Array:
        return fields.values(bumps, problem.recordings.at)[problem.stack.row] * own[:, None]

    def between(edges: Edges) -> Bumps:
        return bumps_of(float(edges[0]), float(edges[1]))

    cells = len(cuts) - 1
    each = [column(between(cuts[n : n + 2])) for n in range(cells)]
    information, _, moments = ground.products(np.hstack(each))

    def gain(low: int, up: int) -> float:
        power = information[low:up, low:up].sum()
        return float(moments[low:up].sum() ** 2 / power) if power > 0 else 0.0

    tried = [
        (low, up)
        for low in range(min(AROUND, cells))
        for up in range(low + 1, min(low + WIDEST, cells) + 1)
        if up - low < cells
    ]
    best = max(tried, key=lambda ends: gain(*ends))
    edges = _widest(lambda one: ground.gain(column(between(one))), cuts[list(best)])
    bumps = between(edges)
    turn = 360.0 if axis == "xel" else np.inf
    low, high = (float(edge / DEG % turn) for edge in edges)
    return Field(
        "an offset of an angle",
        f"{axis}: {name} off from {low:.1f} to {high:.1f}",
        column(bumps),
        problem.stack.is_y,
        len(tried),
        region=(Interval(name, low, high),),
        bumps=bumps,
        axes=(int(axis == "el"),),
        which=(0,),
    )


def _scanned(az: Array, el: Array, weight: Array, pull: Array) -> tuple[Edges, int]:
    """Return the edges of the best box made of cells, and how many boxes were tried."""
    steps = np.unique(np.quantile(el, np.linspace(0, 1, UPWARD + 1)))
    if len(steps) == 1:  # one elevation for all: a box goes past it on both sides
        steps = steps[0] + _FIRST * np.array([-1.0, 1.0])
    column = np.minimum((az * AROUND / (2 * np.pi)).astype(int), AROUND - 1)
    line = np.clip(np.searchsorted(steps, el, side="right") - 1, 0, len(steps) - 2)
    sums = np.zeros((3, AROUND, len(steps) - 1))
    for total, values in zip(sums, (np.ones(len(az)), weight, pull), strict=True):
        np.add.at(total, (column, line), values)
    around = np.concatenate([sums, sums[:, :WIDEST]], axis=1)
    grown = np.pad(around, ((0, 0), (1, 0), (1, 0))).cumsum(axis=1).cumsum(axis=2)
    best, edges, tried = -1.0, np.zeros(4), 0
    whole = weight.sum()
    lows, highs = np.triu_indices(len(steps), 1)
    cell = 2 * np.pi / AROUND
    for width in range(1, WIDEST + 1):
        strip = grown[:, width : width + AROUND] - grown[:, :AROUND]
        count, mass, moved = strip[:, :, highs] - strip[:, :, lows]
        length = mass * (1 - mass / whole)
        gain = np.where(count >= FEWEST, moved**2 / np.maximum(length, 1e-12), 0.0)
        tried += gain.size
        if gain.max() > best:
            best = float(gain.max())
            first, pair = np.unravel_index(int(np.argmax(gain)), gain.shape)
            left = float(first) * cell
            edges = np.array([left, left + width * cell, steps[lows[pair]], steps[highs[pair]]])
    return edges, tried


def _gain_of(az: Array, el: Array, weight: Array, pull: Array) -> Callable[[Edges], float]:
    whole = weight.sum()

    def gain(edges: Edges) -> float:
        there = inside(az, el, edges)
        if there.sum() < FEWEST or edges[1] - edges[0] > 2 * np.pi:
            return 0.0
        mass = weight[there].sum()
        return float(pull[there].sum() ** 2 / max(mass * (1 - mass / whole), 1e-12))

    return gain


def _widest(gain: Callable[[Edges], float], start: Edges) -> Edges:
    """Return the edges whose gain is highest, moved from some."""

    def ordered(edges: Edges) -> float:
        return gain(edges) if np.all(edges[::2] < edges[1::2]) else -np.inf

    return climbed(ordered, start, np.full(len(start), _FIRST))
