"""SLALIB against pyerfa: two programs that nobody here wrote.

Its Fortran is fetched, not kept: `make parity-slalib`, or PYPORT_SLALIB=FOLDER to fetch it into.
"""

import os
import runpy
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from pyport.parity.compare import Pair
from pyport.parity.described import inputs
from pyport.parity.described.functions import ask_port, resolve
from pyport.parity.described.loading import load
from pyport.parity.evidence.shrink import failing, minimal
from pyport.parity.promise import hold, kept
from pyport.parity.run import asker, run

HERE = Path(__file__).parent / "slalib"

pytestmark = [pytest.mark.oracle, pytest.mark.usefixtures("oracle")]

#: A dozen of those that agree to rounding.
EXACT = ("DCS2C", "DSEP", "DBEAR", "DE2H", "DH2E", "PA", "GMST", "NUTC80", "PREC", "ECMAT", "FK5HZ")
EXACT += ("GEOC", "EPV", "REFCOQ", "DTP2S")


@pytest.fixture(scope="module")
def slalib():
    """Return the description beside the fetched Fortran."""
    folder = os.environ.get("PYPORT_SLALIB")
    if not folder:
        pytest.skip("SLALIB is fetched by make parity-slalib (PYPORT_SLALIB names the folder)")
    return load(runpy.run_path(str(HERE / "fetch.py"))["fetch"](Path(folder)))


def test_it_agrees_with_erfa_as_the_notes_say(slalib):
    """Forty routines: the same to rounding, or as far apart as their models."""
    parity = run(slalib, 2000, jobs=1)
    port = slalib.ports[0]
    worst = {
        one.routine: max(c.physical for c in parity.comparisons(port) if c.routine == one.routine)
        for one in parity.comparisons(port)
    }

    assert parity.promise_kept, [str(one) for one in parity.minimal.values()]
    assert len(worst) == 40
    # rounding is 2e-8 arcsec at most, of GMST: days since 1950 have that many digits
    apart = {name for name, value in worst.items() if value > 1e-7}
    assert apart == {f"sla_{name}" for name in ("EQEQX", "NUTC", "EQGAL", "GALEQ", "PVOBS")}
    assert apart <= {one.name for one in slalib.routines if one.note}


def slips(function):
    """Return a function with its sign turned, and with its numbers kept in REAL*4."""

    def each(change):
        def call(*arguments):
            found = function(*arguments)
            return tuple(map(change, found)) if isinstance(found, tuple) else change(found)

        return call

    return each(np.negative), each(lambda values: np.float32(values).astype(float))


@pytest.mark.parametrize("name", EXACT)
@pytest.mark.parametrize("slip", [0, 1], ids=["sign", "REAL*4"])
def test_slip_is_caught_with_a_minimal_input(slalib, name, slip):
    """A sign turned, or REAL*8 kept REAL*4, is caught, with a simple input."""
    port, routine = slalib.ports[0], slalib.routine(f"sla_{name}")
    function = slips(resolve(slalib, routine.ports[port.name]))[slip]
    ask = asker(slalib)
    batch = inputs.random(routine, 200, 1)
    actual = ask_port(slalib, port, routine, batch, function)
    held = hold(slalib, port, Pair(routine, batch, ask("reference", routine, batch), actual))

    assert not kept(port, routine, held)
    found = minimal(port, routine, held, partial(failing, slalib, ask, function=function))
    worst = next(one.worst for one in held.beyond if one.worst)
    assert found.expected != found.actual
    assert len(str(found.inputs)) < len(str(worst.inputs))
