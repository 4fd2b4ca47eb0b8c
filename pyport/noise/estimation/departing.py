"""What may depart: the zeros, the tilt and the sag of sessions, and the places of sources.

What nights do to the zeros, the tilts and the sag is noise to every other effect, and so is what
is wrong with the catalogue's places.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
from pyport.effects import CATALOGUE
from pyport.effects.base import Circumstances, MissingColumn
from pyport.effects.sky.astrometry import parallactic
from pyport.noise.pointings import pointings
from pyport.noise.series import Departures
from pyport.recordings.schema import Recordings, Stack, group
from pyport.thresholds import ENOUGH, FEWEST, PER_LABEL, SEVERAL

#: Of so many stretches a variance is known to 14 %. More of them cost memory and time alone.
MOST_STRETCHES = 100


def possible(recordings: Recordings, data: Stack) -> tuple[Departures, ...]:
    """Return the departures that the recordings of a single antenna could show, all of zero size.

    Sessions may depart in both zeros and, where they have more than a few readings, in the tilts
    and in the sag; so may stretches of rows where the order is all that is known of time; sources
    in the place that the catalogue gives them, or, where the sky's turn at the site is not known,
    in both offsets.
    """
    if len(np.unique(recordings.label("antenna").astype(str))) > 1:
        return ()
    antenna = str(recordings.label("antenna")[0]) if len(recordings) else ""
    found = [*_of_sessions(recordings, data, antenna), *_of_sources(recordings, data, antenna)]
    return tuple(one for one in found if one.columns.any())


def zeros(at: Circumstances) -> tuple[str, str]:
    """Return what the zeros of both axes are called."""
    across, along = at.mount.names
    return f"zero in {across}", f"zero in {along}"


def terms_of_sessions(at: Circumstances) -> dict[str, tuple[Array, Array]]:
    """Return what sessions may depart in: term -> both axes for departures of one, (n, k) each."""
    none, one = np.zeros((len(at), 1)), np.ones((len(at), 1))
    across, along = zeros(at)
    return {
        across: (one, none),
        along: (none, one),
        f"tilt of the {at.mount.fixed}": CATALOGUE["tilt"].columns(at),
        "sag": CATALOGUE["sag_cosine"].columns(at),
    }


def terms_of_sources(at: Circumstances) -> dict[str, tuple[Array, Array]]:
    """Return what sources may depart in: term -> both axes for departures of one, (n, k) each.

    In place, or, where the sky's turn is not known, in both offsets.
    """
    with contextlib.suppress(MissingColumn):
        turned = [np.stack(at.along_axes(*one), axis=0) for one in parallactic(at)]
        if np.isfinite(np.stack(turned)).all():
            x, y = np.stack(turned, axis=-1)
            return {"place in the catalogue": (x, y)}
    none, one = np.zeros((len(at), 1)), np.ones((len(at), 1))
    across, along = at.mount.names
    return {f"offset in {across}": (one, none), f"offset in {along}": (none, one)}


def _of_sessions(recordings: Recordings, data: Stack, antenna: str) -> list[Departures]:
    of, night, labels = _nights(recordings)
    if len(labels) < SEVERAL:
        return []
    inside = night[data.row][:, None] == np.arange(len(labels))
    terms = terms_of_sessions(recordings.at)
    if len(data) < FEWEST * len(labels):
        terms = {one: terms[one] for one in zeros(recordings.at)}
    return [_departures(one, of, antenna, labels, inside, data, terms) for one in terms]


def _nights(recordings: Recordings) -> tuple[str, Codes, tuple[str, ...]]:
    """Return what stands for nights, for each row its number (n,), and the label of each.

    Sessions; where there is one, and the order of the rows is all that tells of time, stretches
    of about `ENOUGH` pointings, `MOST_STRETCHES` of them at most, for nobody wrote down where a
    night ends. What makes fewer than `FEWEST` of them is one night.
    """
    session, names = group(recordings, ("session",))
    if len(names) > 1 or "order" not in recordings.at:
        return "session", session, tuple(name for (name,) in names)
    order = np.asarray(recordings.at.column("order")).argsort()
    begun = np.zeros(len(order), np.intp)
    begun[np.unique(pointings(recordings)[order], return_index=True)[1]] = 1
    place = np.empty(len(order), np.intp)
    place[order] = np.cumsum(begun) - 1
    there = int(begun.sum())
    count = min(round(there / ENOUGH), MOST_STRETCHES)
    if count < FEWEST:
        return "session", session, ("",)
    stretch = place * count // there
    rows = [np.flatnonzero(stretch[order] == one) + 1 for one in range(count)]
    return "stretch", stretch, tuple(f"rows {one[0]} to {one[-1]}" for one in rows)


def _of_sources(recordings: Recordings, data: Stack, antenna: str) -> list[Departures]:
    source, names = group(recordings, ("source",))
    number = pointings(recordings)
    there = len(np.unique(number))
    if len(names) < SEVERAL or there < PER_LABEL * len(names):
        return []
    pairs = np.unique(np.stack([source, number]), axis=1)[0]
    again = np.flatnonzero(np.bincount(pairs, minlength=len(names)) > 1)
    if len(again) < SEVERAL:
        return []
    inside = source[data.row][:, None] == again
    labels = tuple(names[one][0] for one in again)
    terms = terms_of_sources(recordings.at)
    return [_departures(one, "source", antenna, labels, inside, data, terms) for one in terms]


def _departures(
    term: str,
    of: str,
    antenna: str,
    labels: tuple[str, ...],
    inside: NDArray[np.bool_],
    data: Stack,
    terms: Mapping[str, tuple[Array, Array]],
) -> Departures:
    """Return the departures of some labels in a term; `inside` (m, labels) says whose is whose."""
    columns = data.spread(*terms[term]).T
    return Departures(
        term,
        of,
        antenna,
        labels * len(columns),
        np.concatenate([inside * column[:, None] for column in columns], axis=1),
    )
