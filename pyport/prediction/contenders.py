"""Who predicts: models refitted, the choice for prediction, terms picked automatically.

The list holds every harmonic of azimuth and elevation and every product of the two, in
each result. Terms are added one by one, always the one that lowers the rms
most. It stands here to be judged: picked anew without the readings that it
is to predict, it shows what picking costs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.effects.base import Circumstances
from pyport.errors import BadInput
from pyport.least_squares import robust
from pyport.least_squares.gram import spanned
from pyport.models.model import Model
from pyport.noise.pointings import pointings
from pyport.prediction import shrunk
from pyport.recordings.schema import Recordings, Stack, stack, term_columns
from pyport.thresholds import FIRST_REACH

#: Multiples of azimuth and of elevation in the list.
MOST = 8
#: A term must keep this share of its length beside those picked before it.
NEW = 1e-3


def listed_columns(at: Circumstances, row: NDArray[np.intp], is_y: NDArray[np.bool_]) -> Array:
    """Return the terms in azimuth, in cross-elevation and in elevation, shape (m, 3 K)."""
    turns = np.arange(1, MOST + 1)
    around = np.concatenate([np.sin(turns * at.az[:, None]), np.cos(turns * at.az[:, None])], 1)
    up = np.concatenate([np.sin(turns * at.el[:, None]), np.cos(turns * at.el[:, None])], 1)
    both = (around[:, :, None] * up[:, None, :]).reshape(len(at), -1)
    shapes = np.concatenate([around, up, both], axis=1)[row]
    results = at.onto_sky[row] * ~is_y, ~is_y * 1.0, is_y * 1.0
    return np.concatenate([shapes * one[:, None] for one in results], axis=1)


def pick(model: Array, terms: Array, value: Array, count: int) -> list[int]:
    """Return which terms (m, K) lower the rms most beside a model (m, p), one after another."""
    basis = spanned(model)[0]
    left = value - basis @ (basis.T @ value)
    terms = terms / np.maximum(np.linalg.norm(terms, axis=0), 1e-300)
    terms = terms - basis @ (basis.T @ terms)
    found: list[int] = []
    for _ in range(min(count, len(value) - basis.shape[1] - 1)):
        length = np.linalg.norm(terms, axis=0)
        drop = np.where(length > NEW, np.abs(terms.T @ left) / np.maximum(length, NEW), 0.0)
        best = int(np.argmax(drop))
        if drop[best] == 0:
            break
        found.append(best)
        own = terms[:, best] / length[best]
        left = left - own * (own @ left)
        terms = terms - np.outer(own, own @ terms)
    return found


Rows = NDArray[np.bool_]


class Contender(Protocol):
    """Whoever is fitted to some readings and predicts others.

    `name`: what it is called.
    `terms`: its coefficients; of shrunk ones, how many free ones they amount to.
    """

    name: str
    terms: float

    def residual(self, train: Rows, other: Night | None = None) -> Array:
        """Return what predictions leave of all readings, or of another night's, shape (m,).

        `train` are the readings of its own night that it is fitted to, shape (m,).
        """
        ...


@dataclass(frozen=True)
class Night:
    """Recordings that are predicted, and their readings as one list."""

    recordings: Recordings
    stack: Stack

    @classmethod
    def of(cls, recordings: Recordings) -> Night:
        """Return the readings of recordings of one antenna.

        Raises `BadInput`: there are several antennas.
        """
        names = np.unique(recordings.label("antenna").astype(str))
        if len(names) > 1:
            raise BadInput(
                f"{len(names)} antennas, expected one: choose with "
                f"--where 'antenna == \"{names[0]}\"'",
                recordings.file,
            )
        return cls(recordings, stack(recordings))

    @cached_property
    def pointings(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return the first row of each pointing, and the pointing of each reading, shape (m,)."""
        of_row = pointings(self.recordings)
        first = np.sort(np.unique(of_row, return_index=True)[1])
        return first, np.argsort(of_row[first])[of_row[self.stack.row]]

    def columns(self, model: Model) -> Array:
        """Return the columns of a model's free terms, shape (m, p).

        Raises `BadInput`: a term needs more than these recordings tell.
        """
        parts = [term_columns(self.stack, term.effect, self.recordings) for term in model.fitted()]
        return np.concatenate([np.zeros((len(self.stack), 0)), *parts], axis=1)

    def value(self, model: Model) -> Array:
        """Return the offsets less what a model gives before any fit, shape (m,) [rad]."""
        return self.stack.value - self.stack.spread(*model.offsets(self.recordings.at))


def solved(columns: Array, value: Array, is_y: Rows, rows: Rows) -> tuple[Array, Array]:
    """Return coefficients (p,) of a robust fit to some rows, and the weights of those, (m,).

    Each axis is weighted by its own scatter.
    """
    weight, scatter = np.zeros(len(value)), np.ones(len(value))
    for axis in (False, True):
        own = rows & (is_y == axis)
        if not own.any():
            continue
        there = columns[own][:, np.any(columns[own] != 0, axis=0)]
        floor = robust.rounding(value[own])
        weight[own], left, _ = robust.weights(there, value[own], FIRST_REACH, floor)
        spare = max(1.0, float(weight[own].sum()) - there.shape[1])
        size = float(np.sqrt((weight[own] * left**2).sum() / spare))
        scatter[own] = max(size, floor, 1e-12)
    root = np.sqrt(weight) / scatter
    length = np.maximum(np.linalg.norm(columns[rows], axis=0), 1e-300)
    white = (columns / length * root[:, None])[rows]
    values = np.linalg.lstsq(white, (value * root)[rows], rcond=1e-10)[0]
    return values / length, weight


class Refitted:
    """A model with its terms held and their coefficients fitted."""

    def __init__(self, night: Night, model: Model):
        self.night, self.model, self.name = night, model, model.name
        self.columns, self.value = night.columns(model), night.value(model)
        self.terms = float(self.columns.shape[1])

    def residual(self, train: Rows, other: Night | None = None) -> Array:
        """Return what predictions leave of all readings, or of another night's."""
        values, _ = solved(self.columns, self.value, self.night.stack.is_y, train)
        if other is None:
            return self.value - self.columns @ values
        return other.value(self.model) - other.columns(self.model) @ values


class AsItStands:
    """A model with the coefficients that it has: nothing is fitted."""

    terms = 0.0

    def __init__(self, refitted: Refitted):
        self.night, self.model, self.value = refitted.night, refitted.model, refitted.value
        self.name = f"{refitted.name} as it stands"

    @property
    def has_coefficients(self) -> bool:
        """Tell whether the model gives any offset before it is fitted."""
        return bool(np.any(self.value != self.night.stack.value))

    def residual(self, train: Rows, other: Night | None = None) -> Array:  # noqa: ARG002
        """Return what it leaves of all readings, or of another night's."""
        return self.value if other is None else other.value(self.model)


class OwnChoice:
    """The model and waves, shrunk as far as the readings that it is fitted to say."""

    name = "model with waves"

    def __init__(self, night: Night, model: Model):
        self.night, self.model = night, model
        self.known = self._known(night)
        self.whole = shrunk.fit(self.known)
        self.terms = self.known.model.shape[1] + self.whole.freed

    def _known(self, night: Night) -> shrunk.Known:
        shapes = shrunk.columns(night.recordings.at)[night.stack.row]
        columns, value = night.columns(self.model), night.value(self.model)
        return shrunk.Known(columns, shapes, night.stack.is_y, value)

    def residual(self, train: Rows, other: Night | None = None) -> Array:
        """Return what predictions leave of all readings, or of another night's."""
        found = self.whole
        if not train.all():
            found = shrunk.fit(self.known.take(train), self.whole.logs)
        at = self.known if other is None else self._known(other)
        return at.value - found.predict(at)


class Picked:
    """A model and terms picked automatically: anew in each fit, or once from all readings.

    Terms that were picked once have seen what is left out afterwards.
    """

    def __init__(self, night: Night, model: Model, terms: int, *, anew: bool):
        self.night, self.model, self.terms = night, model, float(terms)
        self.name = f"{terms} terms picked {'anew each time' if anew else 'once, then held'}"
        self.value, self.columns = night.value(model), night.columns(model)
        self.listed = listed_columns(night.recordings.at, night.stack.row, night.stack.is_y)
        self.held = None if anew else self._pick(np.ones(len(self.value), bool))

    def _pick(self, rows: Rows) -> list[int]:
        more = int(self.terms) - self.columns.shape[1]
        return pick(self.columns[rows], self.listed[rows], self.value[rows], more)

    def residual(self, train: Rows, other: Night | None = None) -> Array:
        """Return what predictions leave of all readings, or of another night's."""
        kept = self._pick(train) if self.held is None else self.held
        columns = np.concatenate([self.columns, self.listed[:, kept]], axis=1)
        values, _ = solved(columns, self.value, self.night.stack.is_y, train)
        if other is None:
            return self.value - columns @ values
        listed = listed_columns(other.recordings.at, other.stack.row, other.stack.is_y)
        columns = np.concatenate([other.columns(self.model), listed[:, kept]], axis=1)
        return other.value(self.model) - columns @ values
