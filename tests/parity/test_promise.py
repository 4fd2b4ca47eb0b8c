"""The vectorised port against the oracle: its own spread, N ulp beyond it, arcseconds."""

import numpy as np
import pytest
from hypothesis import given, settings
from strategies import directions, parameters

from pyport.parity import promise, stored
from pyport.parity.answers import OUTPUTS, of_legacy, of_oracle, of_pointing
from pyport.parity.ledger import explained
from pyport.parity.points import points, random, table
from pyport.parity.run import hold
from pyport.parity.spread import spread
from pyport.parity.ulp import UNLIKE

#: Half the distance of neighbouring REAL*4 at 360 deg: what storing dAz before its turn is taken
#: off may cost [arcsec]; see wrap-in-single in the ledger.
HALF_A_STEP_ARCSEC = 2**-16 * 3600


def assert_promise_kept(held):
    """Fail with routine, output, worst input and distance where the port leaves its promise."""
    broken = [
        str(comparison)
        for comparison, bound in zip(held.beyond, promise.PROMISED_ULP, strict=True)
        if comparison.most > bound
    ]

    assert not broken, "\n".join(["the vectorised port breaks its promise:", *broken])


@pytest.mark.parametrize("name", stored.SETS)
def test_promise_at_stored_answers(name):
    """The vectorised port keeps its promise at the stored points, where no compiler is."""
    kept = stored.load(name)

    assert_promise_kept(
        hold(kept.at, kept.answers, kept.spread, of_legacy(kept.at), of_pointing(kept.at))
    )


@pytest.mark.oracle
@settings(max_examples=300)
@given(direction=directions, p=parameters)
def test_promise_wherever_hypothesis_looks(oracle, direction, p):
    """The vectorised port keeps its promise at thresholds, their neighbours and anywhere else."""
    at = points([direction[0]], [direction[1]], p)
    expected = of_oracle(oracle, at)

    assert_promise_kept(hold(at, expected, spread(oracle, at, expected), expected, of_pointing(at)))


@pytest.fixture(scope="module")
def whole_table(table_answers):
    """Return both ports' answers over the table."""
    at = table()
    return at, table_answers, of_pointing(at)


@pytest.fixture(scope="module")
def anywhere():
    """Return both ports' answers at random points."""
    at = random(20_000, 7)
    return at, of_legacy(at), of_pointing(at)


def outside_the_ledger(at, expected, actual):
    """Compare both ports, leaving out what the ledger explains."""
    return hold(at, expected, np.stack([expected, expected]), expected, actual).sky


@pytest.mark.parametrize("column", range(4))
def test_arcseconds_on_the_sky_over_the_whole_table(whole_table, column):
    """Over the 51,395 points no offset is farther off on the sky than half a step of REAL*4."""
    comparison = outside_the_ledger(*whole_table)[column]

    assert comparison.arcsec <= HALF_A_STEP_ARCSEC, str(comparison)


@pytest.mark.parametrize("column", [1, 3])
def test_altitudes_without_the_turn_are_closer(anywhere, column):
    """Altitude offsets are never stored a turn too large: they agree to 3 milliarcseconds."""
    comparison = outside_the_ledger(*anywhere)[column]

    assert comparison.arcsec <= 3e-3, str(comparison)


@pytest.mark.oracle
def test_plunge_is_off_by_no_more_than_its_cause(oracle):
    """In plunge ModelA's altitude leaves the port by no more than the turn's error explains."""
    at = random(30_000, 8)
    regions = explained(at, of_oracle(oracle, at))
    at = at.part((regions["turn-in-single"] & ~regions["curve-in-single"])[:, 3])
    apart = np.abs(of_oracle(oracle, at)[:, 3].astype(float) - of_pointing(at)[:, 3])
    turn_error = 3.5e-7 + np.spacing(np.float32(8)) / 2
    p = np.abs(at.p)
    slope = p[:, 4] + p[:, 5] + 2 * p[:, 10]
    roundings = 8 * np.spacing(p[:, [1, 4, 5, 6, 7, 10, 11]].sum(axis=1))

    assert len(at) > 500
    assert (apart <= turn_error * slope + roundings).all()


def test_absolute_term_does_not_hide_a_difference():
    """Less than the absolute term is equal, ten times as much is not; NaN equals only NaN."""
    expected = np.zeros((1, 5), dtype=np.float32)

    assert (
        promise.distances(expected, expected + np.float32(0.9 * promise.ABSOLUTE_DEG)) == 0
    ).all()
    assert (promise.distances(expected, expected + np.float32(10 * promise.ABSOLUTE_DEG)) > 0).all()
    assert (promise.distances(expected, expected + np.float32(np.nan)) == UNLIKE).all()


def test_distance_within_the_spread_counts_as_nothing():
    """Only what goes beyond the oracle's own spread is counted against the port."""
    at = points([0.3], [0.7], np.full(12, 0.01))
    step = np.float32(2**-23)
    expected = np.ones((1, 5), dtype=np.float32)
    actual = expected + 5 * step
    span = np.stack([expected - step, expected + step * np.float32([[0, 4, 5, 9, np.inf]])])
    left, numbers = promise.beyond(expected, actual, span, at)

    assert left.tolist() == [[5, 1, 0, 0, 0]]
    assert promise.beyond(expected, expected - 3 * step, span, at)[0].tolist() == [[4] * 5]
    assert not any(numbers.values())
    assert not promise.kept([5, 1, 0, 0, 0])
    assert promise.kept([1, 1, 0, 0, 4])


def test_outputs_and_bounds_go_together():
    """There is one bound for each output."""
    assert len(promise.PROMISED_ULP) == len(OUTPUTS)
