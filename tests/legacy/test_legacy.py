"""The statement-by-statement port against the compiled Fortran and its stored answers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import any_real4, directions, parameters

from pyport.parity import points, promise, stored
from pyport.parity.answers import of_legacy, of_oracle
from pyport.parity.compare import compare
from pyport.parity.edges import edges


def assert_equal_bit_for_bit(expected, actual, at):
    """Fail with routine, output, worst input and distance wherever a bit differs."""
    differing = [str(c) for c in compare(expected, actual, at) if c.differing]

    assert not differing, "\n".join(["the legacy port left the oracle:", *differing])


@pytest.mark.parametrize("name", stored.SETS)
@pytest.mark.usefixtures("same_library")
def test_port_equals_stored_answers(name):
    """The port gives the oracle's stored answers, bit for bit, where no compiler is."""
    kept = stored.load(name)

    assert_equal_bit_for_bit(kept.answers, of_legacy(kept.at), kept.at)


@pytest.mark.parametrize("name", stored.SETS)
def test_port_is_the_program_with_any_c_library(name):
    """Wherever sines are rounded otherwise, the port stays within the oracle's own spread."""
    kept = stored.load(name)
    inside = promise.promised(kept.at)
    actual = of_legacy(kept.at)[inside]
    left, _ = promise.beyond(
        kept.answers[inside], actual, kept.spread[:, inside], kept.at.part(inside)
    )

    assert promise.kept(left.max(axis=0).tolist())


@pytest.mark.usefixtures("same_library")
def test_port_equals_the_whole_stored_table(table_answers):
    """At each of the table's 541 azimuths the port's answers have the stored digest."""
    expected = stored.load("table").digests

    assert expected == stored.digests(table_answers)


@pytest.mark.oracle
@pytest.mark.parametrize("seed", range(3))
def test_port_equals_oracle_at_random_points(oracle, seed):
    """The port equals the compiled routines at random points and parameters."""
    at = points.random(5000, seed)

    assert_equal_bit_for_bit(of_oracle(oracle, at), of_legacy(at), at)


@pytest.mark.oracle
def test_port_equals_oracle_at_edges(oracle):
    """The port equals the compiled routines where they branch, blow up or give in."""
    at = edges()

    assert_equal_bit_for_bit(of_oracle(oracle, at), of_legacy(at), at)


@pytest.mark.oracle
@settings(max_examples=500)
@given(direction=directions, p=parameters)
def test_port_equals_oracle(oracle, direction, p):
    """The port equals the compiled routines wherever Hypothesis looks."""
    at = points.points([direction[0]], [direction[1]], p)

    assert_equal_bit_for_bit(of_oracle(oracle, at), of_legacy(at), at)


@pytest.mark.oracle
@settings(max_examples=300)
@given(az=any_real4, alt=any_real4, p=st.lists(any_real4, min_size=12, max_size=12))
def test_port_equals_oracle_for_any_bits(oracle, az, alt, p):
    """Infinities, NaN, subnormals and overflow are answered as the compiled routines answer."""
    at = points.points([az], [alt], np.array(p))

    assert_equal_bit_for_bit(of_oracle(oracle, at), of_legacy(at), at)
