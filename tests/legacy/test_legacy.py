"""The statement-by-statement port against the compiled Fortran and its stored answers."""

import numpy as np
import pytest
import rt32
from hypothesis import given, settings
from hypothesis import strategies as st
from rt32_inputs import edges, points, random
from strategies import any_real4, directions, parameters

from pyport.parity import promise
from pyport.parity.compare import Pair
from pyport.parity.described.functions import ask_port


def assert_equal_bit_for_bit(at):
    """Fail with routine, output, worst input and distance wherever a bit differs."""
    held = rt32.held(at)
    differing = [
        str(c) for (port, _), one in held.items() if port == "legacy" for c in one.plain if c.most
    ]

    assert len(held) == 6
    assert not differing, "\n".join(["the legacy port left the oracle:", *differing])


def pairs(name):
    """Yield the legacy port's answers with the stored ones."""
    for routine, known in rt32.known(name):
        actual = ask_port(rt32.DESCRIPTION, rt32.LEGACY, routine, known.batch)
        yield known, Pair(routine, known.batch, known.answers, actual, actual.raised)


@pytest.mark.parametrize("name", rt32.GROUPS)
@pytest.mark.usefixtures("same_library")
def test_port_equals_stored_answers(name):
    """The port gives the oracle's stored answers, bit for bit, where no compiler is."""
    compared = [one for _, pair in pairs(name) for one in pair.compare()]

    assert len(compared) == 5
    assert not [str(one) for one in compared if one.differing]


@pytest.mark.parametrize("name", rt32.GROUPS)
def test_port_is_the_program_with_any_c_library(name):
    """Wherever sines are rounded otherwise, the port stays within the oracle's own spread."""
    for known, pair in pairs(name):
        held = promise.hold(rt32.DESCRIPTION, rt32.VECTORISED, pair, known.spread)

        assert promise.kept(rt32.VECTORISED, pair.routine, held)


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle")
@pytest.mark.parametrize("seed", range(3))
def test_port_equals_oracle_at_random_points(seed):
    """The port equals the compiled routines at random points and parameters."""
    assert_equal_bit_for_bit(random(5000, seed))


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle")
def test_port_equals_oracle_at_edges():
    """The port equals the compiled routines where they branch, blow up or give in."""
    assert_equal_bit_for_bit(edges())


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle")
@settings(max_examples=500)
@given(direction=directions, p=parameters)
def test_port_equals_oracle(direction, p):
    """The port equals the compiled routines wherever Hypothesis looks."""
    assert_equal_bit_for_bit(points([direction[0]], [direction[1]], p))


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle")
@settings(max_examples=300)
@given(az=any_real4, alt=any_real4, p=st.lists(any_real4, min_size=12, max_size=12))
def test_port_equals_oracle_for_any_bits(az, alt, p):
    """Infinities, NaN, subnormals and overflow are answered as the compiled routines answer."""
    assert_equal_bit_for_bit(points([az], [alt], np.array(p)))
