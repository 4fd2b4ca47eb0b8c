"""The forms a nameless misfit may take: bumps over the sky, along a column, in time; waves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pyport.angles import DEG, Array
from pyport.diagnosis.case import Problem
from pyport.diagnosis.finding import Interval
from pyport.diagnosis.shapes import numbers
from pyport.effects import fields
from pyport.effects.fields import Bumps

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
    bumps, axes, which
        What its columns are made of, for any place in the sky: see `pyport.effects.fields.field`;
        no axes where both measure it alike.
    """

    family: str
    variant: str
    columns: Array
    choices: int = 1
    along: tuple[str, Array] | None = None
    region: tuple[Interval, ...] = ()
    of_time: bool = False
    bumps: Bumps = field(default_factory=dict)
    axes: tuple[int, ...] = ()
    which: tuple[int, ...] = ()


def families(setup: Problem) -> Iterator[tuple[int, Field]]:
    """Yield every field that these recordings could show, as if both axes measured it alike.

    With each comes how many there are of its kind.
    """
    sky = [
        _field(setup, "a smooth field over the sky", f"{w / DEG:.0f} deg wide", "sky", width_rad=w)
        for w in OVER_SKY
    ]
    waves = [
        _field(setup, "a wave over the sky", _wave_name(m, n), "wave", around=m, upward=n)
        for m in AROUND
        for n in UPWARD
    ]
    for kind in (sky, waves, [*_curves(setup), *_in_time(setup)]):
        for one in kind:
            yield len(kind), one


def _field(
    setup: Problem,
    family: str,
    variant: str,
    kind: str,
    *,
    along: tuple[str, Array] | None = None,
    of_time: bool = False,
    **numbers_of: Any,  # noqa: ANN401 - what tells the bumps of this kind
) -> Field:
    """Return a field with its bumps at the readings."""
    bumps = {"kind": kind, **numbers_of}
    columns = fields.values(bumps, setup.recordings.at)[setup.stack.row]
    return Field(family, variant, columns, along=along, of_time=of_time, bumps=bumps)


def _wave_name(m: int, n: int) -> str:
    return f"goes with {m} A" + (f" and {n} E" if n else "")


def _curves(setup: Problem) -> Iterator[Field]:
    """Yield bumps along azimuth, elevation and every column of numbers."""
    at, row = setup.recordings.at, setup.stack.row
    az, el = at.az[row], at.el[row]
    for width in ALONG_AZIMUTH:
        along = "az_deg", az % (2 * np.pi) / DEG
        yield _curve(setup, "azimuth", along, width_rad=width)
    for width in ALONG_ELEVATION:
        centres = np.arange(el.min(), el.max() + width, width).tolist()
        along = "el_deg", el / DEG
        yield _curve(setup, "elevation", along, width_rad=width, centres_rad=centres)
    for name, values in numbers(setup.recordings).items():
        if name not in ("az_deg", "el_deg", "time", "order"):
            ordered = np.sort(values).tolist()
            along = name, values[row]
            yield _curve(setup, "column", along, name=name, count=ALONG_COLUMN, values=ordered)


def _curve(setup: Problem, kind: str, along: tuple[str, Array], **numbers_of: Any) -> Field:  # noqa: ANN401
    return _field(setup, "a smooth curve", f"follows {along[0]}", kind, along=along, **numbers_of)


def _in_time(setup: Problem) -> Iterator[Field]:
    """Yield bumps in time, where there are recordings."""
    at, row = setup.recordings.at, setup.stack.row
    if "time" not in at or not np.isfinite(at.numbers("time")).all():
        return
    time = at.numbers("time")[row]
    for length in IN_TIME:
        centres = np.unique(np.round(time / length)) * length
        if 3 <= len(centres) <= MOST_BUMPS:
            how = f"follows time, over {length / 3600:.0f} h"
            told = {"length_s": length, "centres_s": centres.tolist()}
            yield _field(setup, "a smooth curve", how, "time", of_time=True, **told)
