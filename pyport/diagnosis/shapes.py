"""Shapes without a name: they stand for physics that the catalogue lacks.

Smooth curves in every column, waves over the sky, offsets confined to a stretch
of azimuth or elevation. When one of them explains the recordings better than
any effect does, the honest answer is `unknown`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import DEG, Array
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.finding import Interval
from pyport.effects import fields
from pyport.effects.base import Effect
from pyport.effects.fields import Bumps
from pyport.recordings.schema import Recordings, Stack
from pyport.thresholds import FEWEST

#: Order of the curve that is laid through a column.
ORDER = 4
#: Waves over the sky: this often around, and this often from the horizon to the zenith.
AROUND, UPWARD = range(1, 5), (1, 2)
#: Widths of the stretches that a misfit may be confined to, as shares of the recordings.
WIDTHS = (1 / 4, 1 / 8, 1 / 16)


@dataclass(frozen=True)
class Shape:
    """A shape before it is given to an axis.

    Attributes
    ----------
    family, variant
        What kind of shape it is, and which of its kind.
    bumps
        What its columns are made of, for any place in the sky: see `pyport.effects.fields.field`.
    choices
        How many of its kind are tried: the price of picking the best.
    region
        The stretch that it is confined to, none where it is everywhere.
    """

    family: str
    variant: str
    bumps: Bumps
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
        columns = fields.values(shape.bumps, recordings.at)
        for axis, measured in (("xel", ~stack.is_y), ("el", stack.is_y)):
            block = columns[stack.row] * measured[:, None]
            if np.count_nonzero(block.any(axis=1)) < FEWEST:
                continue
            width = block.shape[1]
            blocks.append(block)
            found.append(
                Candidate(
                    _effect(shape, axis, width),
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
        low, high = float(values.min()), float(values.max())
        curve = {"kind": "curve", "name": name, "low": low, "high": high, "order": ORDER}
        yield Shape("a smooth curve", f"follows {name}", curve, len(known))
    yield from _waves()
    yield from _stretches("az_deg", recordings.at.az % (2 * np.pi))
    yield from _stretches("el_deg", recordings.at.el)


def _waves() -> Iterator[Shape]:
    """Yield waves that go around the sky and up it, one by one and all low ones together."""
    every = [(m, n) for m in AROUND for n in UPWARD]
    for m, n in every:
        bumps = {"kind": "wave", "around": m, "upward": n}
        yield Shape("a wave over the sky", f"goes with {m} A and {n} E", bumps, len(every))
    low = {"kind": "waves", "each": [(m, n) for m, n in every if m in (1, 2)]}
    yield Shape("a smooth field over the sky", "of order two", low)


def _stretches(name: str, values: Array) -> Iterator[Shape]:
    """Yield offsets confined to a stretch of an angle [rad], in widths that overlap by half."""
    ordered = np.sort(values)
    # A step that goes on to the end of the sky is a jump, and has a name: one stays inside.
    starts = [(width, k * width / 2) for width in WIDTHS for k in range(1, round(2 / width) - 2)]
    for width, start in starts:
        low, high = (float(ordered[int(p * (len(values) - 1))]) for p in (start, start + width))
        if low == high:
            continue
        region = Interval(name, low / DEG, high / DEG)
        variant = f"for {region.column} from {region.low:.6g} to {region.high:.6g}"
        bumps = {"kind": "stretch", "name": name, "low_rad": low, "high_rad": high}
        yield Shape("an offset", variant, bumps, len(starts), (region,))


def _effect(shape: Shape, axis: str, width: int) -> Effect:
    """Return a shape as an effect that nobody may name."""
    variant = f"{axis}: {shape.family} {shape.variant}"
    axes, one = [int(axis == "el")] * width, np.eye(width).tolist()
    effect = fields.field(shape.bumps, axes, range(width), one, shape.family, variant)
    return replace(effect, sentence=f"{shape.family} {shape.variant}")
