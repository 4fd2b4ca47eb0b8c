"""Make an input that breaks a promise as simple as it can be made while it still breaks it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pyport.parity.compare import Pair, one_text
from pyport.parity.described.description import Batch, Description, Port, Routine, Variable
from pyport.parity.described.functions import (
    Function,
    Spelling,
    ask_port,
    inputs_of,
    joined,
    part,
    size,
    spell,
    spelled,
    unspell,
)
from pyport.parity.described.inputs import around, special
from pyport.parity.promise import Asker, Held, bound, hold, spread

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy


#: Tells the output that breaks a port's promise at each point, "" where none does, and the answers.
Fails = Callable[[Port, Routine, Batch], tuple[NDArray[np.str_], Pair]]

#: Rounds over all inputs; each makes at least one of them simpler.
MOST_ROUNDS = 40


@dataclass(frozen=True)
class Minimal:
    """The simplest input found at which a port breaks its promise.

    `inputs` are hexadecimal literals; `expected` and `actual` those of the output that differs.
    """

    routine: str
    output: str
    inputs: dict[str, Spelling]
    expected: Spelling
    actual: Spelling

    def __str__(self) -> str:
        """Return a line that a person can type in again."""
        at = ", ".join(f"{name}={one_text(value)}" for name, value in self.inputs.items())
        return (
            f"{self.routine}({at}): {self.output} is {one_text(self.expected)}, "
            f"the port says {one_text(self.actual)}"
        )


def failing(
    description: Description,
    ask: Asker,
    port: Port,
    routine: Routine,
    batch: Batch,
    function: Function | None = None,
) -> tuple[NDArray[np.str_], Pair]:
    """Return the output that breaks a port's promise at each point of a batch, "" where none does.

    The answers come with it.
    """
    expected = ask("reference", routine, batch)
    actual = ask_port(description, port, routine, batch, function)
    span = spread(port, routine, batch, expected, ask) if port.promise == "spread" else None
    broken = []
    for i in range(size(batch)):
        at = slice(i, i + 1)
        raised = {0: actual.raised[i]} if i in actual.raised else {}
        one, theirs, ours = (part(each, at) for each in (batch, expected, actual))
        pair = Pair(routine, one, theirs, ours, raised)
        here = span and {k: (low[at], high[at]) for k, (low, high) in span.items()}
        held = hold(description, port, pair, here)
        both = zip(held.beyond, routine.outputs, strict=True)
        broken.append(next((v.key for c, v in both if c.most > bound(port, v)), ""))
    return np.array(broken, dtype=np.str_), Pair(routine, batch, expected, actual, actual.raised)


def minimal(
    port: Port,
    routine: Routine,
    held: Held,
    fails: Fails | None,
) -> Minimal:
    """Return the simplest input that breaks the promise, from the worst one that was found.

    `fails` asks the compiled routine; without it the worst input stays what it is.
    """
    worst, output = next(
        (c.worst, c.output)
        for c, one in zip(held.beyond, routine.outputs, strict=True)
        if c.worst is not None and c.most > bound(port, one)
    )
    found = Minimal(routine.name, output, worst.inputs, worst.expected, worst.actual)
    # what remembers answers a point by what came before it: alone the input says nothing
    if fails is None or not routine.inputs or routine.sequence:
        return found
    batch = {
        one.key: unspell([worst.inputs[one.name]], one.type, one.shape) for one in routine.inputs
    }
    if not fails(port, routine, batch)[0][0]:
        return found
    return minimal_of(port, routine, batch, fails)


def minimal_of(port: Port, routine: Routine, batch: Batch, fails: Fails) -> Minimal:
    """Return the simplest input that breaks the promise, from one point that does."""
    batch = shrunk(routine, batch, lambda many: fails(port, routine, many)[0] != "")
    broken, pair = fails(port, routine, batch)
    one = routine.by_key[str(broken[0])]
    expected, actual = pair.both(one)
    return Minimal(
        routine.name,
        one.label,
        spelled(routine, batch, 0),
        spell(expected[0]),
        pair.raised.get(0) or spell(actual[0]),
    )


def shrunk(routine: Routine, batch: Batch, wrong: Callable[[Batch], NDArray[np.bool_]]) -> Batch:
    """Return one point made as simple as possible, each number in turn, while it stays wrong."""
    for _ in range(MOST_ROUNDS):
        simpler = False
        for one in routine.inputs:
            for place in range(max(1, math.prod(one.shape))):
                candidates = [
                    _with(batch, one, place, value)
                    for value in _simpler(one, batch[one.key].reshape(-1)[place])
                ]
                if not candidates:
                    continue
                still = wrong(joined(candidates))
                if still.any():
                    batch, simpler = candidates[int(np.argmax(still))], True
        if not simpler:
            break
    return batch


def _with(batch: Batch, one: Variable, place: int, value: Any) -> Batch:  # noqa: ANN401
    changed = batch[one.key].copy()
    changed.reshape(-1)[place] = value
    return batch | {one.key: changed}


def _simpler(one: Variable, value: Any) -> Iterator[Any]:  # noqa: ANN401 - of any kind
    """Yield the simpler values of a variable, simplest first, none beyond its range."""
    dtype, base = one.type.dtype(), one.type.base
    if one.values:
        texts = [one.type.value(v)[()] for v in one.values]
        yield from texts[: texts.index(value) if value in texts else None]
    elif base == "logical":
        yield from np.array([False])[: int(value)]
    elif base == "character":
        text = bytes(value).ljust(one.type.size)
        for k in range(len(text)):
            if text[k : k + 1] != b" ":
                yield text[:k] + b" " + text[k + 1 :]
    else:
        for candidate in _numbers(base, float(value) if base == "real" else int(value)):
            with np.errstate(over="ignore"):
                number = dtype.type(candidate)
            limits = (-one.high, one.high) if one.logarithmic else (one.low, one.high)
            inside = limits[0] <= number <= limits[1] or not limits[0] <= value <= limits[1]
            if inside and _cost(number) < _cost(value):
                yield number


def _numbers(base: str, value: float) -> Iterator[float]:
    if base == "integer":
        yield from (0, 1, 2, -1, int(value / 2), value - 1 if value > 0 else value + 1)
        return
    yield from (0.0, 1.0, 0.5, 2.0, -1.0, -0.5)
    if not math.isfinite(value):
        yield from (1e6, -1e6)
        return
    yield abs(value)
    yield float(math.trunc(value))
    mantissa, exponent = math.frexp(value)
    for bits in (1, 2, 3, 4, 6, 8, 12, 16, 20, 24, 32, 40, 48):
        yield math.ldexp(round(math.ldexp(mantissa, bits)), exponent - bits)


def _cost(value: Any) -> tuple[int, int, float]:  # noqa: ANN401 - a number
    """Return how simple a number is: the digits of its literal, its sign, its size."""
    if isinstance(value, np.integer):
        return 0, int(value < 0), abs(int(value))
    if not np.isfinite(value):
        return 99, int(value < 0), 0.0
    return len(str(spell(value)).lstrip("-")), int(np.signbit(value)), abs(float(value))


#: Numbers this many ulp from a threshold are drawn as often as numbers anywhere.
NEAR_ULP = 3


def strategy(one: Variable) -> SearchStrategy[Any]:
    """Return what draws a value of a variable: anywhere in its range, and where branches turn."""
    from hypothesis import strategies as st

    if one.shape:
        n = math.prod(one.shape)
        return st.lists(_scalar(one), min_size=n, max_size=n)
    return _scalar(one)


def _scalar(one: Variable) -> SearchStrategy[Any]:
    from hypothesis import strategies as st

    base = one.type.base
    if one.values:
        return st.sampled_from([one.type.value(value)[()] for value in one.values])
    if base == "logical":
        return st.booleans()
    if base == "character":
        printable = st.characters(min_codepoint=32, max_codepoint=126)
        text = st.text(printable, max_size=one.type.size)
        return text.map(lambda t: t.ljust(one.type.size).encode("ascii"))
    if base == "integer":
        anywhere: SearchStrategy[Any] = st.integers(int(one.low), int(one.high))
    else:
        real = one.type.dtype().type
        low, high = float(real(one.low)), float(real(one.high))
        low = -high if one.logarithmic else low
        anywhere = st.floats(low, high, width=32 if one.type.size == 4 else 64)
    near = [value for t in one.thresholds for value in around(t, one.type.dtype(), NEAR_ULP)]
    return anywhere | st.sampled_from([*special(one), *near])


def search(
    description: Description, port: Port, routine: Routine, ask: Asker, examples: int
) -> Minimal | None:
    """Return the simplest input that Hypothesis finds to break a promise, None where it finds none.

    The same examples each time: a search that fails can be repeated.
    """
    from hypothesis import HealthCheck, given, settings
    from hypothesis import strategies as st

    found: list[Batch] = []
    fails = partial(failing, description, ask)

    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        derandomize=True,
        suppress_health_check=list(HealthCheck),
    )
    @given(st.fixed_dictionaries({one.key: strategy(one) for one in routine.inputs}))
    def kept(values: dict[str, Any]) -> None:
        batch = inputs_of(
            routine,
            {
                one.key: np.array(values[one.key], one.type.dtype()).reshape(1, *one.shape)
                for one in routine.inputs
            },
        )
        broken = str(fails(port, routine, batch)[0][0])
        if broken:
            found.append(batch)
        assert not broken  # noqa: S101 - this is how Hypothesis is told

    try:
        kept()
    except AssertionError:
        return minimal_of(port, routine, found[-1], fails)
    return None
