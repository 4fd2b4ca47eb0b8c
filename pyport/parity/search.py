"""Let Hypothesis look for an input that breaks a promise; it makes what it finds simple itself."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from pyport.parity.batches import inputs_of
from pyport.parity.description import Batch, Description, Port, Routine, Variable
from pyport.parity.inputs import around, special
from pyport.parity.promise import Asker
from pyport.parity.shrink import Minimal, failing, minimal_of

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy

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
