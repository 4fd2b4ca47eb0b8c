"""Fields: misfits of no particular form, smooth over the sky, along a column or in time.

A named effect predicts the form of a misfit; a field only says how quickly it
changes. Each field is a sum of bumps whose heights are drawn from one normal
distribution, so that its evidence, averaged over all the forms that it could
take, can be held against a name's. Where a field wins over every name and every
set of names, what was left out is none of them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pyport.angles import Array, Codes
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.naming.finding import Interval
from pyport.diagnosis.shapes.forms import Field, families
from pyport.diagnosis.trial import at_best, of_equal_prior
from pyport.diagnosis.weighing import View, WhitenedData, plain_view
from pyport.effects.empirical.fields import field as as_effect
from pyport.fitting.combinations import HIDDEN
from pyport.least_squares.gram import inverted, spanned
from pyport.runs.stages import stage
from pyport.thresholds import (
    FEWEST,
)

#: A stretch that holds more of the readings than this is no place.
WIDEST = 0.35
#: One that holds fewer is where a curve that swings everywhere happens to swing most.
NARROWEST = 0.02
#: Information on a direction, over its prior's, from which it is kept: fainter ones stay near zero.
FAINT = 0.3
#: Columns of fields that are whitened together: more only take more memory.
WHITENED = 128


@dataclass(frozen=True)
class Worth:
    """What a field is worth beside a model.

    Attributes
    ----------
    evidence
        Twice the logarithm of how much likelier the data are with the field, the choice
        among its kind paid for.
    gain
        By how much the whitened sum of squares of unseen readings should fall: what falls in the
        fit less what falls there of noise alone, each direction as far as the data tell of it.
    directions, values
        The directions among its bumps that the data determine, shape (K, dof), and how far
        the data go along each, shape (dof,).
    spread
        How far the bumps' heights, drawn, would go along each: a standard deviation, (dof,).
    """

    field: Field
    evidence: float
    gain: float
    directions: Array
    values: Array
    spread: Array


@dataclass(frozen=True)
class _Rows:
    """Some rows of the whitened data: which, the model's directions and what it leaves there."""

    rows: Codes | slice
    basis: Array
    left: Array


class Ground:
    """The data beside a model, as fields meet them: whitened, the model projected out."""

    def __init__(self, problem: Problem, weighed: WhitenedData, chosen: tuple[Chosen, ...]):
        model = problem.expanded((*problem.base, *chosen), of=weighed.white)
        self.basis = spanned(model[:, model.any(axis=0)])[0]
        self.problem, self.weighed, self.chosen = problem, weighed, chosen
        self.left = self._without(weighed.white[:, -1:])[:, 0]
        is_y = np.resize(problem.stack.is_y, len(self.left))
        there = np.any(self.basis != 0, axis=1) | (self.left != 0)
        self.whole = self._part(slice(None))
        self.axes = [self._part(np.flatnonzero((is_y == one) & there)) for one in (False, True)]

    @cached_property
    def plain(self) -> View:
        """Return the readings beside the model, each by itself."""
        return plain_view(self.problem, self.weighed.covariance, self.chosen)

    def _part(self, rows: Codes | slice) -> _Rows:
        return _Rows(rows, self.basis[rows], self.left[rows])

    def _without(self, columns: Array) -> Array:
        return np.asarray(columns - self.basis @ (self.basis.T @ columns))

    @stage("fields")
    def products(self, columns: Array) -> tuple[Array, Array, Array]:
        """Return the information on columns (m, K) beside the model, without it, and moments."""
        return self._products(self.weighed.covariance.whiten(columns), [self.whole])

    @stage("fields")
    def _products(self, white: Array, parts: Sequence[_Rows]) -> tuple[Array, Array, Array]:
        """Return what `products` does of whitened columns (M, K) that act on each part by itself.

        On the first of P parts first, then on the next: shapes (P K, P K), (P K, P K) and (P K,).
        """
        of_part, k = [white[part.rows] for part in parts], white.shape[1]
        own = np.zeros((len(parts) * k, len(parts) * k))
        for start, one in zip(range(0, len(own), k), of_part, strict=True):
            own[start : start + k, start : start + k] = one.T @ one
        shared = [part.basis.T @ one for part, one in zip(parts, of_part, strict=True)]
        seen = [part.left @ one for part, one in zip(parts, of_part, strict=True)]
        modelled = np.concatenate(shared, axis=1)
        information = own - modelled.T @ modelled
        excess = self.weighed.evidence.common.factor
        return information / excess, own / excess, np.concatenate(seen) / excess

    def gain(self, columns: Array) -> float:
        """Return what columns (m, K) gain beside the model."""
        information, _, moments = self.products(columns)
        return float(moments @ inverted(information)[0] @ moments)

    def evidence(self, columns: Array) -> float:
        """Return the evidence of columns (m, K) of equal prior beside the model."""
        information, _, moments = self.products(columns)
        return of_equal_prior(information, moments)[0]

    def worth_of(self, field: Field) -> Worth:
        """Return what a field is worth in the readings that it has columns for."""
        return worth(field, *self.products(field.columns))

    def worths(self, of_time: Collection[bool] = (False, True)) -> Iterator[Worth]:
        """Yield what every field is worth, in each axis and in both: that lasts, or is of time.

        With one width for both axes heights are no likelier than with a width for each: where that
        is worth nothing both are not tried.
        """
        is_y = self.problem.stack.is_y
        axes = {"xel": ~is_y, "el": is_y}
        measured = [name for name, there in axes.items() if there.any()]
        several = ["both axes"] if len(measured) > 1 else []
        wanted = (one for one in families(self.problem) if one[1].of_time in of_time)
        for kind, field, white in self._whitened(wanted):
            large = np.abs(field.values) > 0.1
            felt = [np.count_nonzero(large[there], axis=0) >= FEWEST for there in axes.values()]
            information, alone, moments = self._products(white, self.axes)
            most = 0.0
            for name in [*measured, *several]:
                own = np.flatnonzero(
                    np.concatenate(
                        [
                            one & (name in (axis, "both axes"))
                            for axis, one in zip(axes, felt, strict=True)
                        ]
                    )
                )
                if len(own) == 0:
                    continue
                one = replace(
                    field,
                    variant=f"{name}: {field.variant}",
                    axes=tuple((own // large.shape[1]).tolist()),
                    which=tuple((own % large.shape[1]).tolist()),
                    choices=kind * (len(measured) + len(several)),
                )
                price = 2 * float(np.log(one.choices))
                if name == "both axes" and most <= price:
                    continue
                some = np.ix_(own, own)
                found = worth(one, information[some], alone[some], moments[own])
                most += found.evidence + price
                yield found

    def _whitened(self, wanted: Iterable[tuple[int, Field]]) -> Iterator[tuple[int, Field, Array]]:
        """Yield fields with their whitened columns, many of which take one pass of all readings."""
        waiting = iter(wanted)
        while some := list(_up_to(WHITENED, waiting)):
            every = np.concatenate([field.values for _, field in some], axis=1)
            ends = np.cumsum([field.values.shape[1] for _, field in some])
            parts = np.split(self._white(every), ends[:-1], axis=1)
            yield from ((kind, field, own) for (kind, field), own in zip(some, parts, strict=True))

    @stage("fields")
    def _white(self, columns: Array) -> Array:
        return self.weighed.covariance.whiten(columns)


def _up_to(most: int, waiting: Iterator[tuple[int, Field]]) -> Iterator[tuple[int, Field]]:
    """Yield the next fields until they have so many columns, or more by the last one's."""
    count = 0
    while count < most and (one := next(waiting, None)) is not None:
        count += one[1].values.shape[1]
        yield one


def as_candidate(worth: Worth, places: Codes, unit: Array) -> Candidate:
    """Return the determined directions of a field as a candidate that nobody may name.

    `places` (dof,) are where its columns stand in the design, `unit` (dof,) what each direction
    was divided by there.
    """
    field = worth.field
    made = as_effect(
        field.bumps,
        field.axes,
        field.which,
        (worth.directions / unit).tolist(),
        field.family,
        field.variant,
        (worth.spread * unit).tolist(),
    )
    return Candidate(
        made,
        places,
        tuple(range(len(places))),
        field.choices,
        region(field, field.columns @ (worth.directions @ worth.values)),
        field.of_time,
    )


@stage("fields")
def worth(field: Field, information: Array, alone: Array, moments: Array) -> Worth:
    """Return what a field is worth, at the strength that suits it best.

    `information` (K, K) on its bumps is beside the model, `alone` without it. Directions
    that are nearly degenerate with the model are left out: their size is not determined.
    """
    power, vectors = np.linalg.eigh(information)
    # Rounding may leave less than nothing of either.
    seen = power > np.maximum(HIDDEN**2 * (vectors * (alone @ vectors)).sum(axis=0), 0.0)
    power, vectors = power[seen], vectors[:, seen]
    along = vectors.T @ moments
    evidence, variance = at_best(power, along)
    kept = variance * power > FAINT
    power, vectors, along = power[kept], vectors[:, kept], along[kept]
    known = variance * power / (1 + variance * power)
    return Worth(
        field,
        evidence - 2 * float(np.log(field.choices)),
        float((known * (along**2 / power - 1)).sum()),
        vectors / np.sqrt(power),
        along / np.sqrt(power),
        np.sqrt(variance * power),
    )


def region(field: Field, curve: Array) -> tuple[Interval, ...]:
    """Return the stretch of its column where a fitted curve (m,) stands out: beyond half its peak.

    Empty for a field of the sky, and for a curve that stands out nearly everywhere.
    """
    used = np.abs(curve) > 0
    if field.along is None or not used.any():
        return field.region
    name, values = field.along
    values, height = values[used], curve[used] - np.median(curve[used])
    peak = int(np.argmax(np.abs(height)))
    high = height * np.sign(height[peak]) > abs(height[peak]) / 2
    if name == "az_deg":
        values = (values - values[peak] + 180) % 360 - 180 + values[peak]
    order = np.argsort(values, kind="stable")
    low = up = int(np.flatnonzero(order == peak)[0])
    while low > 0 and high[order[low - 1]]:
        low -= 1
    while up < len(order) - 1 and high[order[up + 1]]:
        up += 1
    if not NARROWEST * len(order) <= up - low + 1 <= WIDEST * len(order):
        return ()
    turn = 360.0 if name == "az_deg" else np.inf
    return (Interval(name, *(float(values[order[one]]) % turn for one in (low, up))),)
