"""The ledger of deviations: every entry is still what the routines do, and still wrong."""

import equations
import numpy as np
import pytest
import rt32
from mpmath import isnan, mpf
from rt32_inputs import points

from pyport.parity import promise
from pyport.parity.described.functions import ask_port, hexadecimal, unspell

LEDGER = {entry.id: entry for entry in promise.deviations(rt32.DESCRIPTION)}
#: Entries whose region sets a part of the sky aside.
REGIONS = {entry.id: entry.outputs for entry in LEDGER.values() if entry.region}


@pytest.fixture(params=LEDGER)
def entry(request):
    """Return an entry of the ledger."""
    return LEDGER[request.param]


def example(entry):
    """Return an entry's input as one point, and its routine and output."""
    routine = rt32.DESCRIPTION.routine(entry.routine)
    output = next(one for one in routine.outputs if one.label == entry.output)
    given = {key.lower(): value for key, value in entry.input.items()}
    at = {one.key: unspell([given[one.key]], one.type, one.shape) for one in routine.inputs}
    return routine, output, at


def answer(port, entry):
    """Return what a port answers at an entry's example."""
    routine, output, at = example(entry)
    return ask_port(rt32.DESCRIPTION, port, routine, at)[output.key][0]


def regions(at):
    """Return where each region is at work, by its name and output."""
    found = {}
    for routine, answers in ((r, legacy_of(r, at)) for r in rt32.ROUTINES):
        masks = promise.explained(rt32.DESCRIPTION, routine, at, answers)
        labels = {one.key: one.label for one in routine.outputs}
        found |= {
            (name, f"{routine.name} {labels[key]}"): mask
            for name, by_output in masks.items()
            for key, mask in by_output.items()
        }
    return found


def legacy_of(routine, at):
    """Return what the legacy port of a routine answers."""
    return ask_port(rt32.DESCRIPTION, rt32.LEGACY, routine, at)


def test_legacy_port_shows_the_deviation(entry):
    """The legacy port gives the routine's answer, to the bit, with the deviation in it."""
    assert hexadecimal(answer(rt32.LEGACY, entry)) == entry.oracle


@pytest.mark.oracle
def test_oracle_shows_the_deviation(entry, oracle):
    """The compiled routine gives the recorded answer."""
    routine, output, at = example(entry)

    assert hexadecimal(oracle.ask(routine, at)[output.key][0]) == entry.oracle


def test_true_value_is_that_of_the_equations(entry):
    """The recorded true value is the equations' in 50 digits."""
    _, _, at = example(entry)
    turned = not entry.id.startswith("tilt-in-plunge")
    p = at["p"][0] if "p" in at else np.zeros(12, np.float32)
    true = equations.answers(at["az"][0], at["alt"][0], p, turned=turned)
    true = true[rt32.OUTPUTS.index((entry.routine, entry.output))]

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
    port = answer(rt32.VECTORISED, entry)
    followed = float.fromhex(entry.oracle) if entry.port == "oracle" else float(mpf(entry.true))

    if np.isnan(followed):
        assert np.isfinite(port)
    else:
        assert abs(port - followed) <= max(np.spacing(np.abs(port)), rt32.VECTORISED.absolute)


def test_regions_hold_the_examples_of_their_entries():
    """A region of the ledger covers the example of the entry that it is named after."""
    assert len(REGIONS) == 7
    for name, outputs in REGIONS.items():
        routine, output, at = example(LEDGER[name])
        masks = promise.explained(rt32.DESCRIPTION, routine, at, legacy_of(routine, at))

        assert f"{routine.name} {output.label}" in outputs
        assert masks[name][output.key][0], name


def test_regions_leave_most_of_the_sky_alone():
    """Away from curve, plunge and zenith no region explains anything."""
    at = points([0.3, -2.0, 4.0], [0.2, 0.7, 0.9], np.full(12, 0.01))

    assert len(regions(at)) == sum(map(len, REGIONS.values()))
    assert not any(mask.any() for mask in regions(at).values())


def test_legacy_port_needs_no_entry():
    """No entry says that the legacy port leaves the oracle: it is equal bit for bit."""
    assert {entry.port for entry in LEDGER.values()} == {"true", "oracle"}
    assert {(entry.routine, entry.output) for entry in LEDGER.values()} <= set(rt32.OUTPUTS)
