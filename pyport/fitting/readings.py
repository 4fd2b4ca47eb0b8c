"""Readings of a file: the same numbers, taken for something else than they were read as."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.effects.base import Circumstances
from pyport.models.model import Model
from pyport.mounts import ALTAZ
from pyport.mounts.equatorial import EQUATORIAL
from pyport.recordings.schema import Recordings, group

Words = tuple[str, ...]
#: Readings that show where terms are held to what the model gives.
IN_USE: Words = ("the offsets were measured with this model in use (--in-use)",)
SIGN: Words = ("all offsets have the other sign",)
#: Seconds of arc in a second of time.
TIME = 15.0
#: Units of angles that are mistaken for each other, the larger over the smaller: mdeg, seconds of
#: time or arcmin for arcsec, mrad, deg, rad.
UNITS = (3.6, TIME, 60.0, 206.265, 3600.0, 206265.0)
#: So many of them are tried: offsets of one session may be several times as large as another's.
UNITS_TRIED = 3


class Reading(NamedTuple):
    """What is read otherwise, the offsets that it makes (n,), and by how much these are scaled."""

    words: Words
    x: Array
    y: Array
    scale_x: Array | float = 1.0
    scale_y: Array | float = 1.0


def directions(at: Circumstances) -> Iterator[tuple[Words, Circumstances]]:
    """Yield the directions as they were read, and with zenith distances for elevations."""
    yield (), at
    if at.mount is ALTAZ and at.fine is None and np.all((at.el > 0) & (at.el < np.pi / 2)):
        yield ("the elevations are zenith distances",), replace(at, el=np.pi / 2 - at.el)


def offsets(recordings: Recordings, here: Circumstances, model: Model) -> Iterator[Reading]:
    """Yield the offsets as they were read and otherwise, for the directions that are read."""
    x, y, first = recordings.x, recordings.y, recordings.at.mount.first.name
    cosine, read = (
        np.where(np.abs(one) > 1e-3, one, 1e-3) for one in (here.onto_sky, recordings.at.onto_sky)
    )
    opposite = (
        f"{first} is counted in the opposite sense, or the offsets of one axis, of which these "
        f"recordings cannot tell, have the other sign"
    )
    for signed, turned in ((x, ()), (-x, (opposite,))):
        yield Reading(turned, signed, y)
        if here is recordings.at:
            lacking = f"the offsets across lack the cosine that brings {first} onto the sky"
            yield Reading((*turned, lacking), signed * cosine, y, cosine)
            already = f"the offsets of {first} are on the sky already"
            yield Reading((*turned, already), signed * (1 / cosine), y, 1 / cosine)
            if first == EQUATORIAL.first.name:
                time = (
                    f"the offsets of {first} are in seconds of time where seconds of arc are read"
                )
                yield Reading((*turned, time), signed * TIME, y, TIME)
        else:
            yield Reading(turned, signed * (cosine / read), y, cosine / read)
        if np.array_equal(np.isfinite(x), np.isfinite(y)):
            swapped = (*turned, "the offsets of the axes are in each other's place")
            yield Reading(swapped, -y if turned else y, x)
    if here is recordings.at:
        yield Reading(SIGN, -x, -y)
        model_x, model_y = model.offsets(here)
        yield Reading(IN_USE, x + model_x, y + model_y)
        yield from _of_sessions(recordings)


def _of_sessions(recordings: Recordings) -> Iterator[Reading]:
    """Yield the offsets with the sign of one session turned, or read in another unit.

    In either axis or in both.
    """
    x, y, (across, along) = recordings.x, recordings.y, recordings.at.mount.names
    session, names = group(recordings, ("session",))
    for code, (name,) in enumerate(names if len(names) > 1 else ()):
        sign = np.where(session == code, -1.0, 1.0)
        sides = (across, x * sign, y), (along, x, y * sign), ("both axes", x * sign, y * sign)
        for axes, of_x, of_y in sides:
            how = f"the offsets in {axes} of session {name} have the sign opposite to the others'"
            yield Reading((how,), of_x, of_y)
        for times in _units(x, y, session == code):
            scale = np.where(session == code, times, 1.0)
            size = f"{times:.4g} times as large as" if times > 1 else f"1/{1 / times:.4g} of"
            how = f"the offsets of session {name} are in a unit {size} the others'"
            yield Reading((how,), x * scale, y * scale, scale, scale)


def _units(x: Array, y: Array, own: NDArray[np.bool_]) -> list[float]:
    """Return the ratios of units that make a session's offsets most like the others' in size."""
    size, usual = (_spread(x, y, rows) for rows in (own, ~own))
    if not (size > 0 and usual > 0):
        return []
    ratios = [*UNITS, *(1 / one for one in UNITS)]
    return sorted(ratios, key=lambda one: abs(np.log(one * size / usual)))[:UNITS_TRIED]


def _spread(x: Array, y: Array, rows: NDArray[np.bool_]) -> float:
    """Return the median distance of offsets from their axis' median, 0 where there are none."""
    measured = (one[rows & np.isfinite(one)] for one in (x, y))
    away = [np.abs(one - np.median(one)) for one in measured if len(one)]
    return float(np.median(np.concatenate(away))) if away else 0.0
