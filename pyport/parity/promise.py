"""What a port promises: equal bits, N ulp, N ulp beyond the oracle's own spread, a tolerance.

The oracle's own spread is how far apart its answers are when nothing that matters changes:
computing with more digits (another build), and moving an input to the next number. A port that
keeps more digits than the Fortran cannot be held to anything narrower than what these answers span.

Its file has a row for each cause: an input, the routine's answer and the true value. A row with a
`region`, ``module:function``, says at which points its cause is at work: there a port that follows
the equations may leave the routine by more than its own spread.
"""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cache
from operator import add
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pyport.errors import BadInput
from pyport.parity.compare import UNLIKE, Comparison, Pair, distances, neighbour
from pyport.parity.described.description import Batch, Description, Port, Routine, Variable
from pyport.parity.described.functions import Spelling, part, resolve, size

#: Asks one of the builds: (build, routine, batch) -> answers.
Asker = Callable[[str, Routine, Batch], Batch]

#: The least and the greatest of an output's answers.
Spread = dict[str, tuple[NDArray, NDArray]]


def spread(port: Port, routine: Routine, batch: Batch, answers: Batch, ask: Asker) -> Spread:
    """Return the least and greatest answer, NaN left out, among

    - the reference's `answers`;
    - those of the port's other builds at the same points, rounded to the kind of the reference;
    - the reference's with one of the port's moved inputs one ulp up or down.
    """  # noqa: D400 - the sentence goes on as a list
    all_answers = [answers]
    all_answers += [ask(build, routine, batch) for build in port.builds]
    for key in port.moved:
        if key in routine.by_key and routine.by_key[key].is_input:
            for side in (-np.inf, np.inf):
                moved = batch | {key: neighbour(batch[key], side)}
                all_answers.append(ask("reference", routine, moved))
    result = {}
    for one in routine.outputs:
        with np.errstate(over="ignore"):  # what REAL*8 holds may be infinite in REAL*4
            values = [each[one.key].astype(one.type.dtype()) for each in all_answers]
        if one.type.base == "real":
            result[one.key] = np.fmin.reduce(values), np.fmax.reduce(values)
        else:
            result[one.key] = answers[one.key], answers[one.key]
    return result


def promised(routine: Routine, batch: Batch) -> NDArray[np.bool_]:
    """Tell at which points a promise of less than bits holds: where inputs are in their limits."""
    inside = np.ones(len(next(iter(batch.values()))), dtype=bool)
    for one in routine.inputs:
        if one.limits is not None:
            good = (batch[one.key] >= one.limits[0]) & (batch[one.key] <= one.limits[1])
            inside &= good.reshape(len(good), -1).all(axis=1)
    return inside


def apart(port: Port, one: Variable, expected: NDArray, actual: NDArray) -> NDArray[np.int64]:
    """Return the distances of a port's answers.

    Zero where REALs are ``port.absolute`` apart, and where both are half a turn: 180 and -180 deg
    are one angle.
    """
    found = distances(expected, actual)
    if one.type.base != "real" or port.promise == "bits":
        return found
    with np.errstate(invalid="ignore"):
        same = np.abs(expected.astype(float) - actual) <= port.absolute
    same |= expected == actual  # zeros of either sign
    if one.turn is not None:
        half = expected.dtype.type(one.turn / 2)
        same |= (np.abs(expected) == half) & (np.abs(actual) == half)
    return np.where(same, 0, found)


def bound(port: Port, one: Variable) -> int:
    """Return the greatest distance that keeps a port's promise."""
    if port.promise in {"bits", "within"} or one.type.base != "real":
        return 0
    return port.ulp if one.ulp is None else one.ulp


def tolerance(port: Port, one: Variable) -> float:
    """Return the tolerance of a port that promises one, in the output's unit."""
    return port.within if one.within is None else one.within


@dataclass(frozen=True)
class Held:
    """One port of one routine held to the oracle; a comparison for each output."""

    plain: list[Comparison]  #: the port's answers, where it promises anything
    outside: list[Comparison]  #: the same without the points that the ledger explains
    #: The same, counting only what the promise does not allow already: the spread, a tolerance.
    beyond: list[Comparison]
    #: Entry of the ledger -> number of answers beyond the promise that it explains.
    explained: Counter[str]

    def __add__(self, other: Held) -> Held:
        """Return the same over both sets of points."""
        lists = {
            k: [add(*pair) for pair in zip(getattr(self, k), getattr(other, k), strict=True)]
            for k in _LISTS
        }
        numbers = {k: self.explained[k] + other.explained[k] for k in self.explained}
        return Held(**lists, explained=Counter(numbers))

    def as_json(self) -> dict[str, object]:
        """Return it as plain data."""
        lists = {k: [one.as_json() for one in getattr(self, k)] for k in _LISTS}
        return {**lists, "explained": self.explained}

    @classmethod
    def from_json(cls, content: dict) -> Held:
        """Return what `as_json` gave."""
        lists = {k: [Comparison.from_json(one) for one in content[k]] for k in _LISTS}
        return cls(**lists, explained=Counter(content["explained"]))


_LISTS = [one.name for one in fields(Held) if one.name != "explained"]


def hold(
    description: Description, port: Port, pair: Pair, own_spread: Spread | None = None
) -> Held:
    """Compare a port's answers with the oracle's; `own_spread` where the promise goes beyond it."""
    if port.promise == "bits":
        plain = pair.compare()
        return Held(plain, plain, plain, Counter())
    routine = pair.routine
    inside = promised(routine, pair.batch)
    kept = np.flatnonzero(inside)
    raised = {n: pair.raised[i] for n, i in enumerate(kept.tolist()) if i in pair.raised}
    there = Pair(
        routine,
        part(pair.batch, inside),
        part(pair.expected, inside),
        part(pair.actual, inside),
        raised,
    )
    masks = explained(description, routine, there.batch, there.expected)
    plain_, outside, left = {}, {}, {}
    numbers = dict.fromkeys(masks, 0)
    for one in routine.outputs:
        expected, actual = there.both(one)
        plain_[one.key] = there.over(one, apart(port, one, expected, actual))
        ledger = [mask[one.key] for mask in masks.values() if one.key in mask]
        outside[one.key] = plain_[one.key] * ~np.any([np.zeros(len(kept), bool), *ledger], axis=0)
        rest = there.over(one, _left(port, one, expected, actual, own_spread, inside))
        for name, mask in masks.items():
            if one.key in mask:
                numbers[name] += int(((rest > bound(port, one)) & mask[one.key]).sum())
                rest = np.where(mask[one.key], 0, rest)
        left[one.key] = rest
    return Held(
        there.compare(plain_), there.compare(outside), there.compare(left), Counter(numbers)
    )


def _left(
    port: Port,
    one: Variable,
    expected: NDArray,
    actual: NDArray,
    own_spread: Spread | None,
    inside: NDArray[np.bool_],
) -> NDArray[np.int64]:
    """Return the distance of each element beyond what the promise allows anyway."""
    if one.type.base != "real":
        return distances(expected, actual)
    if port.promise == "spread" and own_spread is not None:
        low, high = own_spread[one.key]
        return apart(port, one, np.clip(actual, low[inside], high[inside]), actual)
    found = apart(port, one, expected, actual)
    if port.promise == "within":
        with np.errstate(invalid="ignore"):
            gap = np.abs(expected.astype(float) - actual)
        if one.turn is not None:
            gap = np.minimum(gap, np.abs(one.turn - gap))
        unlike = (found == UNLIKE) & ~np.isfinite(gap)
        found = np.where((gap <= tolerance(port, one)) & ~unlike, 0, np.maximum(found, 1))
        found = np.where(np.isnan(expected) & np.isnan(actual), 0, found)
    return found


def kept(port: Port, routine: Routine, held: Held) -> bool:
    """Tell whether a port's answers keep its promise."""
    return all(
        comparison.most <= bound(port, one)
        for comparison, one in zip(held.beyond, routine.outputs, strict=True)
    )


Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Deviation:
    """One cause: what `routine` does for the example, and what its equations say."""

    #: `id`, `routine`, `output`, `fortran`, `cause`: its name, where it is seen, the Fortran line,
    #: and why.
    id: str
    routine: str
    output: str
    fortran: str
    cause: str
    port: str  #: whom the ports that follow the equations follow here: "true" or "oracle"
    #: The example: a hexadecimal literal for each argument, a list for an array.
    input: dict[str, Spelling]
    #: `oracle`, `true`: what the routine answers (hexadecimal) and the equations (decimal).
    oracle: str
    true: str
    #: ``module:function`` of (inputs, the oracle's answers by output) that tells where the cause is
    #: at work, "" where no distance is explained by it.
    region: str = ""
    outputs: tuple[str, ...] = ()  #: "ROUTINE OUTPUT" for each answer that the region explains


def deviations(description: Description) -> tuple[Deviation, ...]:
    """Return the ledger of a description, read once; none where it has no ledger."""
    return () if description.ledger is None else _read(description.ledger)


@cache
def _read(path: Path) -> tuple[Deviation, ...]:
    try:
        rows = tomllib.loads(path.read_text(encoding="utf-8")).get("deviation", [])
    except (OSError, ValueError) as error:
        raise BadInput(f"cannot be read ({error}): expected a ledger of deviations", path) from None
    known = {one.name for one in fields(Deviation)}
    found = []
    for row in rows:
        name = row.get("id", "without id")
        for key in set(row) - known:
            raise BadInput(f"deviation {name}: `{key}` is not known", path)
        missing = known - set(row) - {"region", "outputs"}
        if missing:
            raise BadInput(f"deviation {name}: `{min(missing)}` is missing", path)
        found.append(Deviation(**{**row, "outputs": tuple(row.get("outputs", ()))}))
    return tuple(found)


def explained(
    description: Description, routine: Routine, batch: Batch, expected: Batch
) -> dict[str, dict[str, Mask]]:
    """Return for each region which of the oracle's answers it explains, by output."""
    labels = {f"{routine.name} {one.label}": one.key for one in routine.outputs}
    masks = {}
    for entry in deviations(description):
        keys = [labels[name] for name in entry.outputs if name in labels]
        if entry.region and keys:
            mask = np.asarray(resolve(description, entry.region)(batch, expected), dtype=bool)
            if mask.shape != (size(batch),):
                raise BadInput(
                    f"{entry.region} returned shape {mask.shape}, expected one truth a point"
                )
            masks[entry.id] = dict.fromkeys(keys, mask)
    return masks
