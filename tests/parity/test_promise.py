"""The vectorised port against the oracle: its own spread, N ulp beyond it, arcseconds."""

import numpy as np
import pytest
import rt32
from hypothesis import example, given, settings
from rt32_inputs import points, random, table
from strategies import at_the_rim, directions, parameters

from pyport.parity import promise
from pyport.parity.compare import UNLIKE, Pair
from pyport.parity.described.functions import ask_port
from pyport.parity.run import hold_live

PORT = rt32.VECTORISED
MODEL, MODELA, HJUMP = rt32.ROUTINES

#: Half the distance of neighbouring REAL*4 at 360 deg: what storing dAz before its turn is taken
#: off may cost [arcsec]; see wrap-in-single in the ledger.
HALF_A_STEP_ARCSEC = 2**-16 * 3600

#: Azimuth, altitude and parameters where the zenith is on the rim and tilt and box offset cancel.
TANGENT = (
    float.fromhex("0x1.2d97c8p+2"),
    float.fromhex("0x1.92p+0"),
    np.eye(12)[3] + np.eye(12)[4],
)


def assert_promise_kept(routine, held):
    """Fail with routine, output, worst input and distance where the port leaves its promise."""
    broken = [
        str(comparison)
        for comparison, one in zip(held.beyond, routine.outputs, strict=True)
        if comparison.most > promise.bound(PORT, one)
    ]

    assert not broken, "\n".join(["the vectorised port breaks its promise:", *broken])


@pytest.mark.parametrize("name", rt32.GROUPS)
def test_promise_at_stored_answers(name):
    """The vectorised port keeps its promise at the stored points, where no compiler is."""
    for routine, known in rt32.known(name):
        actual = ask_port(rt32.DESCRIPTION, PORT, routine, known.batch)
        pair = Pair(routine, known.batch, known.answers, actual)

        assert_promise_kept(routine, promise.hold(rt32.DESCRIPTION, PORT, pair, known.spread))


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle")
@settings(max_examples=300)
@given(direction=directions, p=parameters)
def test_promise_wherever_hypothesis_looks(direction, p):
    """The vectorised port keeps its promise at thresholds, their neighbours and anywhere else."""
    held = rt32.held(points([direction[0]], [direction[1]], p))
    for routine in rt32.ROUTINES:
        assert_promise_kept(routine, held["vectorised", routine.name])


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle")
@settings(max_examples=150)
@given(point=at_the_rim())
@example(point=TANGENT)
def test_promise_at_the_rim_of_the_blind_spot(point):
    """Where the arcsine magnifies what DASIN lost, only what the ledger derives is left out."""
    az, alt, p = point
    held = hold_live(rt32.DESCRIPTION, MODEL, points([az], [alt], p))

    assert_promise_kept(MODEL, held["vectorised", "Model"])


def outside_the_ledger(routine, at):
    """Compare both ports of a routine, leaving out what the ledger explains."""
    expected, actual = (ask_port(rt32.DESCRIPTION, one, routine, at) for one in (rt32.LEGACY, PORT))
    span = {key: (values, values) for key, values in expected.items()}
    return promise.hold(rt32.DESCRIPTION, PORT, Pair(routine, at, expected, actual), span).outside


@pytest.mark.slow
@pytest.mark.parametrize("routine", [MODEL, MODELA], ids=["Model", "ModelA"])
def test_arcseconds_on_the_sky_over_the_whole_table(routine):
    """Over the 51,395 points no offset is farther off on the sky than half a step of REAL*4."""
    for comparison in outside_the_ledger(routine, table()):
        assert comparison.physical <= HALF_A_STEP_ARCSEC, str(comparison)


@pytest.mark.parametrize("routine", [MODEL, MODELA], ids=["Model", "ModelA"])
def test_altitudes_without_the_turn_are_closer(routine):
    """Altitude offsets are never stored a turn too large: they agree to 3 milliarcseconds."""
    _, altitude = outside_the_ledger(routine, random(20_000, 7))

    assert altitude.unit == "arcsec"
    assert altitude.physical <= 3e-3, str(altitude)


@pytest.mark.oracle
def test_plunge_is_off_by_no_more_than_its_cause(oracle):
    """In plunge ModelA's altitude leaves the port by no more than the turn's error explains."""
    at = random(30_000, 8)
    regions = promise.explained(rt32.DESCRIPTION, MODELA, at, oracle.ask(MODELA, at))
    turned, curve = (regions[name]["dalt"] for name in ("turn-in-single", "curve-in-single"))
    at = rt32.part(at, turned & ~curve)
    port = ask_port(rt32.DESCRIPTION, PORT, MODELA, at)["dalt"]
    apart = np.abs(oracle.ask(MODELA, at)["dalt"].astype(float) - port)
    turn_error = 3.5e-7 + np.spacing(np.float32(8)) / 2
    p = np.abs(at["p"])
    slope = p[:, 4] + p[:, 5] + 2 * p[:, 10]
    roundings = 8 * np.spacing(p[:, [1, 4, 5, 6, 7, 10, 11]].sum(axis=1))

    assert len(p) > 500
    assert (apart <= turn_error * slope + roundings).all()


def beyond(expected, actual, span):
    """Return how far Hjump's answers at one point are beyond a spread."""
    at = {"az": np.float32([0.3]), "alt": np.float32([0.7])}
    pair = Pair(HJUMP, at, {"hjump": np.float32([expected])}, {"hjump": np.float32([actual])})
    low, high = np.float32([[span[0]], [span[1]]])
    return promise.hold(rt32.DESCRIPTION, PORT, pair, {"hjump": (low, high)})


def test_absolute_term_does_not_hide_a_difference():
    """Less than the absolute term is equal, ten times as much is not; NaN equals only NaN."""
    zero, output = np.zeros(1, np.float32), HJUMP.outputs[0]

    def apart(value):
        return promise.apart(PORT, output, zero, zero + np.float32(value)).tolist()

    assert apart(0.9 * PORT.absolute) == [0]
    assert apart(10 * PORT.absolute) > [0]
    assert apart(np.nan) == [UNLIKE]


@pytest.mark.parametrize(
    ("steps", "low", "high", "left"),
    [(5, -1, 0, 5), (5, -1, 4, 1), (5, -1, 5, 0), (5, -1, np.inf, 0), (-1, 1, 9, 3)],
)
def test_distance_within_the_spread_counts_as_nothing(steps, low, high, left):
    """Only what goes beyond the oracle's own spread is counted against the port."""
    step = 2**-23  # two REAL*4 below 1 fit into one step above it
    held = beyond(1, 1 + steps * step, (1 + low * step, 1 + high * step))

    assert held.beyond[0].most == left
    assert promise.kept(PORT, HJUMP, held) == (left <= 4)
    assert not held.explained.total()


def test_bounds_are_those_of_the_derivation():
    """1 ulp for Model and ModelA, 4 for Hjump: by routine, in the order of the outputs."""
    bounds = [promise.bound(PORT, one) for routine in rt32.ROUTINES for one in routine.outputs]

    assert bounds == [1, 1, 1, 1, 4]
