"""Shapes without a name: they stand for physics that the catalogue lacks.

Smooth curves in every column, waves over the sky, offsets confined to a stretch
of azimuth or elevation. When one of them explains the recordings better than
any effect does, the honest answer is `unknown`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pyport.angles import DEG, Array
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.finding import Interval
from pyport.effects.base import Circumstances, Coefficient, Effect
from pyport.recordings.schema import Recordings
from pyport.recordings.stacking import Stack

#: Order of the curve that is laid through a column.
ORDER = 4
#: Waves over the sky: this often around, and this often from the horizon to the zenith.
AROUND, UPWARD = range(1, 5), (1, 2)
#: Widths of the stretches that a misfit may be confined to, as shares of the recordings.
WIDTHS = (1 / 4, 1 / 8, 1 / 16)
#: A stretch of fewer recordings than this is a handful of outliers.
FEWEST_INSIDE = 12


@dataclass(frozen=True)
class Shape:
    """A shape before it is given to an axis.

    Attributes
    ----------
    family, variant
        What kind of shape it is, and which of its kind.
    columns
        Shape (n, k).
    choices
        How many of its kind are tried: the price of picking the best.
    region
        The stretch that it is confined to, none where it is everywhere.
    """

    family: str
    variant: str
    columns: Array
    choices: int = 1
    region: tuple[Interval, ...] = ()


def numbers(recordings: Recordings) -> dict[str, Array]:
    """Return the numbers that a misfit may follow: the direction and every numeric column.

    Columns that the file's header calls `bookkeeping` say how a row was
    written down, not what the telescope met, and are passed over.
    """
    at = recordings.at
    found: dict[str, Array] = {}
    passed_over = recordings.meta.get("bookkeeping", "").split()
    for name, column in {"az_deg": at.az, "el_deg": at.el, **at.columns}.items():
        if name in (*passed_over, "order") or column.dtype.kind not in "fiu":
            continue
        values = np.asarray(column, float)
        if np.isfinite(values).all() and len(np.unique(values)) > ORDER + 1:
            found[name] = values
    return found


def design(recordings: Recordings, stack: Stack) -> tuple[Array, list[Candidate]]:
    """Return the columns of all shapes and what they are, axis by axis."""
    blocks = [np.zeros((len(stack), 0))]
    found: list[Candidate] = []
    start = 0
    for shape in _shapes(recordings):
        for axis, measured in (("xel", ~stack.is_y), ("el", stack.is_y)):
            block = shape.columns[stack.row] * measured[:, None]
            if np.count_nonzero(block.any(axis=1)) < FEWEST_INSIDE:
                continue
            width = block.shape[1]
            blocks.append(block)
            found.append(
                Candidate(
                    _effect(shape, axis),
                    np.arange(start, start + width),
                    tuple(range(width)),
                    shape.choices,
                    shape.region,
                )
            )
            start += width
    return np.concatenate(blocks, axis=1), found


def _shapes(recordings: Recordings) -> Iterator[Shape]:
    known = numbers(recordings)
    for name, values in known.items():
        yield Shape("a smooth curve", f"follows {name}", _curve(values), len(known))
    yield from _waves(recordings.at)
    yield from _stretches("az_deg", recordings.at.az % (2 * np.pi))
    yield from _stretches("el_deg", recordings.at.el)


def _curve(values: Array) -> Array:
    """Return Legendre polynomials of a column, scaled to its range."""
    spread = 2 * (values - values.min()) / np.ptp(values) - 1
    return np.polynomial.legendre.legvander(spread, ORDER)[:, 1:]


def _waves(at: Circumstances) -> Iterator[Shape]:
    """Yield waves that go around the sky and up it, one by one and all low ones together."""
    waves = {}
    for m in AROUND:
        for n in UPWARD:
            around = np.stack([np.cos(m * at.az), np.sin(m * at.az)], axis=1)
            upward = np.stack([np.cos(n * at.el), np.sin(n * at.el)], axis=1)
            waves[m, n] = (around[:, :, None] * upward[:, None, :]).reshape(len(at), 4)
    for (m, n), columns in waves.items():
        where = f"goes with {m} A and {n} E"
        yield Shape("a wave over the sky", where, columns, len(waves))
    low = np.concatenate([waves[m, n] for m in (1, 2) for n in UPWARD], axis=1)
    yield Shape("a smooth field over the sky", "of order two", low)


def _stretches(name: str, values: Array) -> Iterator[Shape]:
    """Yield offsets confined to a stretch of an angle [rad], in widths that overlap by half."""
    ordered = np.sort(values)
    # A step that goes on to the end of the sky is a jump, and has a name: one stays inside.
    starts = [(width, k * width / 2) for width in WIDTHS for k in range(1, round(2 / width) - 2)]
    for width, low in starts:
        edges = [ordered[int(share * (len(values) - 1))] for share in (low, low + width)]
        if edges[0] == edges[1]:
            continue
        inside = (values >= edges[0]) & (values <= edges[1])
        region = Interval(name, float(edges[0] / DEG), float(edges[1] / DEG))
        variant = f"for {region.column} from {region.low:.6g} to {region.high:.6g}"
        column = inside[:, None].astype(float)
        yield Shape("an offset", variant, column, len(starts), (region,))


def _effect(shape: Shape, axis: str) -> Effect:
    """Return a shape as an effect that nobody may name."""
    return Effect(
        "unknown",
        f"{shape.family} {shape.variant}",
        "a shape, no physics",
        tuple(Coefficient(f"shape_{n + 1}") for n in range(shape.columns.shape[1])),
        _no_basis,
        physical=False,
        variant=f"{axis}: {shape.family} {shape.variant}",
    )


def _no_basis(at: Circumstances) -> tuple[Array, Array]:
    """Return nothing: a shape's columns are made for one set of recordings only."""
    return np.zeros((len(at), 0)), np.zeros((len(at), 0))
