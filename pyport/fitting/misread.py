"""Misread files: the same numbers, taken for something else, fit the model much better.

What a column holds is the commonest thing to be wrong about: a circle that is counted the other
way, zenith distances for elevations, offsets of a coordinate for offsets on the sky, axes in each
other's place, a sign that was turned for a night. Both axes share the tilt, and the other terms
have shapes of their own, so that one reading of a file fits and the others do not. Nights may
differ in their zeros, so that means of sessions say nothing here.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, Array, Codes
from pyport.effects.base import Circumstances
from pyport.fitting.fit import expanded
from pyport.least_squares.gram import spanned
from pyport.models.model import Model
from pyport.mounts import ALTAZ
from pyport.recordings.schema import Recordings, group, stack
from pyport.thresholds import MOSTLY, OUT_OF_REACH

#: What is read otherwise, in words; the offsets x and y that it makes (n,), and how x grows.
Reading = tuple[tuple[str, ...], Array, Array, Array | float]


def misread(
    recordings: Recordings,
    model: Model,
    refit: Collection[str] | None,
    used: NDArray[np.bool_],
    named: Fitted,
    every: Fitted | None = None,
) -> str | None:
    """Return how a file may have been misread, None where no other reading fits much better.

    Readings are compared by the likelihood of Laplace's distribution of either axis, that of a
    reading by the model alone with that of the model and all effects as the file stands.

    Parameters
    ----------
    recordings, model, refit
        As for `pyport.fitting.fit.fit`; of one antenna.
    used
        Which numbers are no outliers, shape (m,).
    named
        What the model leaves with every effect that was found.
    every
        And with curves without a name, too: a reading that is worse than they explains nothing.
    """
    several = "antenna" in recordings.at and len(np.unique(recordings.label("antenna"))) > 1
    data = stack(recordings)
    session, names = group(recordings, ("session",))
    # Outliers are few: where most of a session are, it is the others that they lie out of.
    side = 2 * session[data.row] + data.is_y
    share = np.bincount(side, weights=used) / np.maximum(np.bincount(side), 1)
    rows = np.flatnonzero(used | (share[side] < MOSTLY))
    if several or not len(rows):
        return None
    sides = _Sides(data.is_y[rows], session[data.row[rows]])

    def lack_of(fitted: Fitted) -> float:
        price = float(np.log(len(rows)))
        return sides.lack(sides.centred(fitted.left[rows])) + fitted.coefficients * price

    as_it_stands = lack_of(named)
    others: list[tuple[float, tuple[str, ...], Array, Array]] = []
    for height, at in _heights(recordings.at):
        columns = expanded(replace(recordings, at=at), data, model.fitted(refit))[0][rows]
        basis = spanned(sides.centred(columns))[0]
        given = model.offsets(at)
        ways = [*_offsets(recordings, at)]
        if not height:
            ways += _all_of(recordings, *given)
            ways += _turned(recordings, session, [name for (name,) in names])
        for words, x, y, grown in ways:
            value = sides.centred((data.spread(x, y) - data.spread(*given))[rows])
            rest = value - basis @ (basis.T @ value)
            size = np.where(
                sides.is_y, 1.0, np.broadcast_to(grown, len(recordings))[data.row[rows]]
            )
            lack = sides.lack(rest) - 2 * float(np.log(size).sum())
            if height or words:
                others.append((lack, (*height, *words), rest, size))
            else:
                as_it_stands = min(as_it_stands, lack)
    lack, words, rest, size = min(others, key=lambda one: one[0])
    if lack > as_it_stands - OUT_OF_REACH or (every is not None and lack > lack_of(every)):
        return None
    was, now = (float(np.sqrt(np.mean(one**2))) / ARCSEC for one in (named.left[rows] * size, rest))
    return (
        f"The file may have been misread: if {', and '.join(words)}, the model alone leaves "
        f"{now:.3g} arcsec rms, where the model with all effects found leaves {was:.3g}: check "
        "that first."
    )


@dataclass(frozen=True)
class Fitted:
    """A fit: what it leaves [rad], shape (m,), and its coefficients beside the model's.

    Each of them costs log m.
    """

    left: Array
    coefficients: int = 0


@dataclass(frozen=True)
class _Sides:
    """The readings that count: which are of the second axis, and their sessions, shape (k,)."""

    is_y: NDArray[np.bool_]
    session: Codes

    def centred(self, columns: Array) -> Array:
        """Return columns (k, P), or one (k,), less the mean of each axis in each session."""
        of = 2 * self.session + self.is_y
        total = np.zeros((int(of.max()) + 1, *columns.shape[1:]))
        np.add.at(total, of, columns)
        count = np.maximum(np.bincount(of), 1).reshape(-1, *[1] * (columns.ndim - 1))
        return np.asarray(columns - (total / count)[of])

    def lack(self, left: Array) -> float:
        """Return minus twice the log-likelihood of residuals (k,), each axis of its own scatter."""
        sizes = (np.abs(left[self.is_y == axis]) for axis in (False, True))
        return sum(
            2 * len(one) * float(np.log(max(one.mean(), 1e-12))) for one in sizes if len(one)
        )


def _heights(at: Circumstances) -> Iterator[tuple[tuple[str, ...], Circumstances]]:
    """Yield the directions as they were read, and with zenith distances for elevations."""
    yield (), at
    if at.mount is ALTAZ and at.fine is None and np.all((at.el > 0) & (at.el < np.pi / 2)):
        yield ("the elevations are zenith distances",), replace(at, el=np.pi / 2 - at.el)


def _offsets(recordings: Recordings, here: Circumstances) -> Iterator[Reading]:
    """Yield the offsets as they were read and otherwise, for the directions that are read."""
    x, y, mount = recordings.x, recordings.y, recordings.at.mount
    first = mount.first.name
    cosine, read = (np.maximum(np.cos(one.axes.el), 1e-3) for one in (here, recordings.at))
    sizes: list[tuple[tuple[str, ...], Array | float]] = [((), 1.0)]
    if here is recordings.at:
        sizes.append(
            ((f"the offsets across lack the cosine that brings {first} onto the sky",), cosine)
        )
        sizes.append(((f"the offsets of {first} are on the sky already",), 1 / cosine))
    else:
        sizes.append(((), cosine / read))
    swapped = ("the offsets of the axes are in each other's place",)
    other = (f"{first} is counted the other way, or its offsets have the other sign",)
    for sign, turned in ((1, ()), (-1, other)):
        for words, size in sizes:
            yield (*turned, *words), sign * x * size, y, size
        if np.array_equal(np.isfinite(x), np.isfinite(y)):
            yield (*turned, *swapped), sign * y, x, 1.0


def _all_of(recordings: Recordings, model_x: Array, model_y: Array) -> Iterator[Reading]:
    """Yield all offsets otherwise: it shows where the model's terms are not all refitted."""
    x, y = recordings.x, recordings.y
    yield ("all offsets have the other sign",), -x, -y, 1.0
    yield ("the offsets were measured with this model in use",), x + model_x, y + model_y, 1.0


def _turned(recordings: Recordings, session: Codes, names: list[str]) -> Iterator[Reading]:
    """Yield the offsets with the sign of one session turned, in either axis or in both."""
    x, y = recordings.x, recordings.y
    across, along = recordings.at.mount.names
    for code, name in enumerate(names if len(names) > 1 else ()):
        sign = np.where(session == code, -1.0, 1.0)
        for words, of_x, of_y in (
            (across, sign, 1.0),
            (along, 1.0, sign),
            ("both axes", sign, sign),
        ):
            told = f"the offsets in {words} of session {name} have the sign opposite to the others'"
            yield (told,), x * of_x, y * of_y, 1.0
