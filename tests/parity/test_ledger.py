"""The ledger of deviations: every entry is still what the routines do, and still wrong."""

import equations
import numpy as np
import pytest
from mpmath import isnan, mpf

from pyport.parity import promise
from pyport.parity.answers import OUTPUTS, of_legacy, of_oracle, of_pointing
from pyport.parity.compare import hexadecimal
from pyport.parity.ledger import REGIONS, deviations, explained
from pyport.parity.points import points
from pyport.parity.stored import numbers

LEDGER = {entry.id: entry for entry in deviations()}


@pytest.fixture(params=LEDGER)
def entry(request):
    """Return an entry of the ledger."""
    return LEDGER[request.param]


def example(entry):
    """Return an entry's input as one point."""
    (az, alt), p = numbers([[entry.az, entry.alt]])[0], numbers([list(entry.p)])
    return points([az], [alt], p)


def test_legacy_port_shows_the_deviation(entry):
    """The legacy port gives the routine's answer, to the bit, with the deviation in it."""
    assert hexadecimal(of_legacy(example(entry))[0, entry.column]) == entry.oracle


@pytest.mark.oracle
def test_oracle_shows_the_deviation(entry, oracle):
    """The compiled routine gives the recorded answer."""
    assert hexadecimal(of_oracle(oracle, example(entry))[0, entry.column]) == entry.oracle


def test_true_value_is_that_of_the_equations(entry):
    """The recorded true value is the equations' in 50 digits."""
    at = example(entry)
    turned = not entry.id.startswith("tilt-in-plunge")
    true = equations.answers(at.az[0], at.alt[0], at.p[0], turned=turned)[entry.column]

    if entry.true == "nan":
        assert isnan(true)
    else:
        assert abs(true - mpf(entry.true)) <= abs(true) * mpf(10) ** -18


def test_deviation_has_not_disappeared(entry):
    """The routine's answer is not the true value rounded to REAL*4."""
    answer, true = np.float32(float.fromhex(entry.oracle)), np.float32(float(mpf(entry.true)))

    assert hexadecimal(answer) != hexadecimal(true)


def test_vectorised_port_follows_whom_the_ledger_says(entry):
    """The vectorised port gives the true value, or the routine's where the ledger says so."""
    port = of_pointing(example(entry))[0, entry.column]
    followed = float.fromhex(entry.oracle) if entry.port == "oracle" else float(mpf(entry.true))

    if np.isnan(followed):
        assert np.isfinite(port)
    else:
        assert abs(port - followed) <= max(np.spacing(np.abs(port)), promise.ABSOLUTE_DEG)


def test_regions_hold_the_examples_of_their_entries():
    """A region of the ledger covers the example of the entry that it is named after."""
    for name in REGIONS:
        at = example(LEDGER[name])
        mask = explained(at, of_legacy(at))[name]

        assert mask[0, LEDGER[name].column], name


def test_regions_leave_most_of_the_sky_alone():
    """Away from curve, plunge and zenith no region explains anything."""
    at = points([0.3, -2.0, 4.0], [0.2, 0.7, 0.9], np.full(12, 0.01))

    assert not any(mask.any() for mask in explained(at, of_legacy(at)).values())


def test_legacy_port_needs_no_entry():
    """No entry says that the legacy port leaves the oracle: it is equal bit for bit."""
    assert {entry.port for entry in LEDGER.values()} == {"true", "oracle"}
    assert {(entry.routine, entry.output) for entry in LEDGER.values()} <= set(OUTPUTS)
