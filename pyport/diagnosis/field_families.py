"""The forms a nameless misfit may take: bumps over the sky, along a column, in time; waves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pyport.angles import DEG, Array
from pyport.diagnosis.case import Setup
from pyport.diagnosis.finding import Interval
from pyport.diagnosis.shapes import numbers

#: Widths of the bumps over the sky, and along azimuth and elevation. [rad]
OVER_SKY = (20 * DEG, 45 * DEG)
ALONG_AZIMUTH = (6 * DEG, 20 * DEG)
ALONG_ELEVATION = (5 * DEG,)
#: Bumps along a column: so many over the ranks of its values.
ALONG_COLUMN = 10
#: Lengths of bumps in time. [s]
IN_TIME = (6 * 3600.0, 86400.0)
#: More bumps in time than this say that the campaign is too long for them.
MOST_BUMPS = 160
#: Waves: this often around and this often up.
AROUND, UPWARD = range(1, 6), range(4)


@dataclass(frozen=True)
class Field:
    """A family of forms that a misfit may take.

    Attributes
    ----------
    family, variant
        What kind of field it is, and which of its kind.
    columns
        Its bumps, shape (m, K).
    choices
        How many of its kind are tried.
    along
        The column that it follows, and the column's values, shape (m,); none for the sky's.
    region
        Where it is confined to, where that is known beforehand.
    of_time
        Whether it belongs to the moments of its recordings: no other session has it.
    """

    family: str
    variant: str
    columns: Array
    choices: int = 1
    along: tuple[str, Array] | None = None
    region: tuple[Interval, ...] = ()
    of_time: bool = False


def families(setup: Setup) -> Iterator[tuple[int, Field]]:
    """Yield every field that these recordings could show, as if both axes measured it alike.

    With each comes how many there are of its kind.
    """
    at, row = setup.recordings.at, setup.stack.row
    az, el = at.az[row], at.el[row]
    sky = [
        Field("a smooth field over the sky", f"{w / DEG:.0f} deg wide", _over_sky(az, el, w))
        for w in OVER_SKY
    ]
    waves = [
        Field("a wave over the sky", _wave_name(m, n), _wave(az, el, m, n))
        for m in AROUND
        for n in UPWARD
    ]
    for kind in (sky, waves, [*_curves(setup, az, el), *_in_time(setup)]):
        for one in kind:
            yield len(kind), one


def _over_sky(az: Array, el: Array, width: float) -> Array:
    """Return bumps on the sphere, as far apart as they are wide, shape (m, K)."""
    bumps = []
    for height in np.arange(width / 2, np.pi / 2 + width / 2, width):
        around = max(1, round(2 * np.pi * abs(np.cos(height)) / width))
        for centre in np.arange(around) * 2 * np.pi / around:
            cosine = np.sin(el) * np.sin(height) + np.cos(el) * np.cos(height) * np.cos(az - centre)
            bumps.append(np.exp((cosine - 1) / width**2))
    return np.stack(bumps, axis=1)


def _wave_name(m: int, n: int) -> str:
    return f"goes with {m} A" + (f" and {n} E" if n else "")


def _wave(az: Array, el: Array, m: int, n: int) -> Array:
    around = [np.cos(m * az), np.sin(m * az)]
    upward = [np.cos(n * el), np.sin(n * el)] if n else [np.ones(len(el))]
    return np.stack([a * e for a in around for e in upward], axis=1)


def _curves(setup: Setup, az: Array, el: Array) -> Iterator[Field]:
    """Yield bumps along azimuth, elevation and every column of numbers."""
    row = setup.stack.row
    for width in ALONG_AZIMUTH:
        centres = np.arange(0, 2 * np.pi, width)
        bumps = np.exp((np.cos(az[:, None] - centres) - 1) / width**2)
        yield _curve("az_deg", bumps, az % (2 * np.pi) / DEG)
    for width in ALONG_ELEVATION:
        centres = np.arange(el.min(), el.max() + width, width)
        yield _curve("el_deg", _bumps(el, centres, width), el / DEG)
    for name, values in numbers(setup.recordings).items():
        if name in ("az_deg", "el_deg", "time", "order"):
            continue
        rank = np.searchsorted(np.sort(values), values) / len(values)
        centres = np.linspace(0, 1, ALONG_COLUMN)
        bumps = _bumps(rank, centres, 1 / (ALONG_COLUMN - 1))
        yield _curve(name, bumps[row], values[row])


def _curve(name: str, bumps: Array, values: Array) -> Field:
    return Field("a smooth curve", f"follows {name}", bumps, along=(name, values))


def _in_time(setup: Setup) -> Iterator[Field]:
    """Yield bumps in time, where there are recordings."""
    at, row = setup.recordings.at, setup.stack.row
    if "time" not in at or not np.isfinite(at.numbers("time")).all():
        return
    time = at.numbers("time")[row]
    for length in IN_TIME:
        centres = np.unique(np.round(time / length)) * length
        if 3 <= len(centres) <= MOST_BUMPS:
            bumps = _bumps(time, centres, length)
            how = f"follows time, over {length / 3600:.0f} h"
            yield Field("a smooth curve", how, bumps, of_time=True)


def _bumps(values: Array, centres: Array, width: float) -> Array:
    return np.asarray(np.exp(-0.5 * ((values[:, None] - centres) / width) ** 2))
