"""Misread files: the same numbers, taken for something else, fit the model much better.

What a column holds is the commonest thing to be wrong about: a circle that is counted in the
opposite sense, zenith distances for elevations, offsets of a coordinate for offsets on the sky,
axes in each other's place, a sign that was turned for a night. Both axes share the tilt, and the
other terms have shapes of their own, so that one reading of a file fits and the others do not.
Nights may differ in their zeros, so that means of sessions say nothing here, nor what goes as the
zero of the first angle does.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, Array, Codes
from pyport.fitting.fit import Fit, expanded
from pyport.fitting.readings import IN_USE, SIGN, Words, directions, offsets
from pyport.least_squares.gram import spanned
from pyport.models.model import Model
from pyport.noise.pointings import pointings
from pyport.recordings.schema import Recordings, Stack, group, stack
from pyport.thresholds import CONVINCING, ENOUGH, MOSTLY, NAME_PRICE, OUT_OF_REACH


@dataclass(frozen=True)
class Misread:
    """How a file may have been misread: ways to read it, and what the model leaves of the first.

    `if_so_arcsec` is that rms, `as_read_arcsec` that of the fit to the file as it stands; where
    offsets are scaled, both in the scale of the other reading. `of_given` says that the model is
    as it was given, nothing refitted.
    """

    ways: Sequence[Words]
    if_so_arcsec: float
    as_read_arcsec: float
    of_given: bool = False

    @property
    def of_findings(self) -> str:
        """Return it as a diagnosis says it."""
        if self.of_given:
            return f"The file may have been misread: {self._of_given}."
        return (
            f"The file may have been misread: if {self._so}, the model alone leaves "
            f"{self.if_so_arcsec:.3g} arcsec rms, where the model with all effects found leaves "
            f"{self.as_read_arcsec:.3g}: check that first."
        )

    @property
    def of_fit(self) -> str:
        """Return it as a fit says it, which does not know what the model lacks."""
        if self.of_given:
            return f"the file may have been misread: {self._of_given}"
        return (
            f"the file may have been misread, or the model lacks something: if {self._so}, the "
            f"fit leaves {self.if_so_arcsec:.3g} arcsec rms, where it leaves "
            f"{self.as_read_arcsec:.3g} as the file stands; pyport diagnose tells which"
        )

    @property
    def _of_given(self) -> str:
        return (
            f"if {self._so}, the model as it is given leaves {self.if_so_arcsec:.3g} arcsec rms, "
            f"where it leaves {self.as_read_arcsec:.3g} as the file stands: check that first"
        )

    @property
    def _so(self) -> str:
        return ", or if ".join(", and ".join(words) for words in self.ways)


@dataclass(frozen=True)
class Fitted:
    """A fit: what it leaves [rad], shape (m,), its coefficients beside the model's, and names.

    Each coefficient costs log m, each name what a name does.
    """

    left: Array
    coefficients: int = 0
    names: int = 0


def misread(
    recordings: Recordings,
    model: Model,
    refit: Collection[str] | None,
    used: NDArray[np.bool_],
    named: Fitted,
    every: Fitted | None = None,
) -> Misread | None:
    """Return how a file may have been misread, None where no other reading fits much better.

    Readings are compared by the likelihood of Laplace's distribution of either axis, that of a
    reading by the model alone with that of the model as the file stands, and of the model with all
    effects: a name costs as much as a thing that is read otherwise.

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
    numbers = _numbers(recordings, used)
    if len(np.unique(recordings.label("antenna"))) > 1:
        return None
    columns = expanded(recordings, numbers.stack, model.fitted(refit))[0][numbers.rows]
    if numbers.count - spanned(columns)[0].shape[1] < ENOUGH:
        return None
    as_it_stands, *others = _refitted(recordings, model, refit, numbers)
    best = min(others, key=lambda one: one.priced)
    gains = best.misfit <= as_it_stands.misfit - OUT_OF_REACH
    if not gains or best.priced > numbers.misfit_of(named) - CONVINCING:
        return _of_given(recordings, model, numbers)
    if every is not None and best.misfit > numbers.misfit_of(every):
        return None
    before = named.left[numbers.rows] * best.scale
    was, now = (float(np.sqrt(np.mean(one**2))) / ARCSEC for one in (before, best.left))
    ways: list[Words] = []
    for one in sorted(others, key=lambda one: one.priced):
        # What is read so and something else besides is no other way.
        if one.priced < best.priced + CONVINCING and not any({*w} <= {*one.words} for w in ways):
            ways.append(one.words)
    return Misread(ways, now, was)


def _of_given(recordings: Recordings, model: Model, numbers: _Numbers) -> Misread | None:
    """Return how a file may have been misread that refitted terms adapt to, whatever it holds.

    Offsets that the model left while it was in use are small; with the other sign they are small
    beside the model turned. Either must leave less than half of what the file leaves as it stands.
    """
    data, rows = numbers.stack, numbers.rows
    predicted = data.spread(*model.offsets(recordings.at))
    readings = ((), data.value - predicted), (IN_USE, data.value), (SIGN, data.value + predicted)
    left = [(words, numbers.centred(value[rows])) for words, value in readings]
    (_, stands), *others = left
    words, best = min(others, key=lambda one: numbers.misfit(one[1]))
    was, now = (float(np.sqrt(np.mean(one**2))) / ARCSEC for one in (stands, best))
    likelier = numbers.misfit(stands) - numbers.misfit(best) > OUT_OF_REACH
    return Misread([words], now, was, of_given=True) if likelier and now < MOSTLY * was else None


def of_fit(fit: Fit) -> Misread | None:
    """Return how the file of a fit may have been misread, as `misread` does."""
    refit = {one.term.effect.id for one in fit.coefficients}
    used = fit.noise.used
    return misread(fit.recordings, fit.model, refit, used, Fitted(np.nan_to_num(fit.residual)))


@dataclass(frozen=True)
class _Numbers:
    """Which k of the m readings count.

    `side` is the number of the axis in a session of each of them, `measured` that of the pointing
    and axis: repeats have the same; `zero` is what a zero of the first angle does, shape (k,) each.
    """

    stack: Stack
    rows: Codes
    side: Codes
    measured: Codes
    zero: Array

    @property
    def count(self) -> int:
        """Return how many numbers were measured, repeats counted once."""
        return int(self.measured.max(initial=-1)) + 1

    def averaged(self, values: Array) -> Array:
        """Return the mean over repeats of values (k,), one for each pointing and axis."""
        return np.bincount(self.measured, values) / np.bincount(self.measured)

    def centred(self, columns: Array) -> Array:
        """Return columns (k, P), or one (k,), without what zeros of each session would draw."""
        level = self._without(np.ones(len(self.side)), columns)
        return self._without(self._without(np.ones(len(self.side)), self.zero), level)

    def _without(self, shape: Array, columns: Array) -> Array:
        """Return columns less what a shape (k,) draws of them on each axis in each session."""
        one = shape.reshape(-1, *[1] * (columns.ndim - 1))
        drawn = np.zeros((int(self.side.max()) + 1, *columns.shape[1:]))
        np.add.at(drawn, self.side, one * columns)
        power = np.bincount(self.side, shape**2).reshape(-1, *[1] * (columns.ndim - 1))
        # What a session shows nothing of is not drawn.
        share = np.where(power > 1e-9, drawn / np.maximum(power, 1e-9), 0.0)
        return np.asarray(columns - one * share[self.side])

    def misfit(self, left: Array) -> float:
        """Return minus twice the log-likelihood of residuals (k,), each axis of its own scatter."""
        size, axis_of = np.abs(self.averaged(left)), self.averaged((self.side % 2).astype(float))
        sizes = (size[axis_of == axis] for axis in (0, 1))
        return sum(
            2 * len(one) * float(np.log(max(one.mean(), 1e-12))) for one in sizes if len(one)
        )

    def misfit_of(self, fitted: Fitted) -> float:
        """Return the same of a fit to the file as it stands, its coefficients paid for."""
        price = float(np.log(self.count))
        paid = fitted.coefficients * price + fitted.names * NAME_PRICE
        return self.misfit(self.centred(fitted.left[self.rows])) + paid


def _numbers(recordings: Recordings, used: NDArray[np.bool_]) -> _Numbers:
    """Return the readings that count: no outliers, which are few.

    Where most of an axis in a session are, it is the others that they lie out of.
    """
    data = stack(recordings)
    side = 2 * group(recordings, ("session",))[0][data.row] + data.is_y
    share = np.bincount(side, weights=used) / np.maximum(np.bincount(side), 1)
    rows = np.flatnonzero(used | (share[side] < MOSTLY))
    number = 2 * pointings(recordings)[data.row] + data.is_y
    measured = np.unique(number[rows], return_inverse=True)[1]
    zero = data.spread(recordings.at.onto_sky, np.zeros(len(recordings)))
    return _Numbers(data, rows, side[rows], measured, zero[rows])


@dataclass(frozen=True)
class _Reading:
    """A way to read the file, fitted by the model alone."""

    misfit: float  #: see `_Numbers.misfit`
    words: Words  #: what it takes for something else
    left: Array  #: what the model leaves [rad], shape (k,)
    scale: Array  #: by how much it scales the offsets, shape (k,)

    @property
    def priced(self) -> float:
        """Return the misfit with each thing paid for that it takes for something else."""
        return self.misfit + NAME_PRICE * len(self.words)


def _refitted(
    recordings: Recordings, model: Model, refit: Collection[str] | None, numbers: _Numbers
) -> Iterator[_Reading]:
    """Yield every reading, the file as it stands first."""
    data, rows = numbers.stack, numbers.rows
    for turned, at in directions(recordings.at):
        columns = expanded(replace(recordings, at=at), data, model.fitted(refit))[0][rows]
        basis = spanned(numbers.centred(columns))[0]
        predicted = data.spread(*model.offsets(at))
        for one in offsets(recordings, at, model):
            value = numbers.centred((data.spread(one.x, one.y) - predicted)[rows])
            left = value - basis @ (basis.T @ value)
            scales = (np.broadcast_to(s, len(recordings)) for s in (one.scale_x, one.scale_y))
            scale = data.spread(*scales)[rows]
            # Smaller numbers are likelier by as much as they were made smaller.
            misfit = numbers.misfit(left) - 2 * numbers.averaged(np.log(np.abs(scale))).sum()
            yield _Reading(misfit, (*turned, *one.words), left, scale)
