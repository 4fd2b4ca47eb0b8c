"""The oracle takes only numbers that the Fortran holds exactly, and says what made it."""

import numpy as np
import pytest
import rt32

from pyport.errors import BadInput
from pyport.parity import oracle as compiled
from pyport.parity import stored

HJUMP = rt32.DESCRIPTION.routine("Hjump")
MODEL = rt32.DESCRIPTION.routine("Model")


@pytest.mark.oracle
@pytest.mark.parametrize("value", [0.1, 1e300, 1e-50])
def test_number_that_real4_cannot_hold_is_refused(oracle, value):
    """A number that rounding to REAL*4 would change is an error, not another number."""
    with pytest.raises(BadInput, match=r"Az: .* is no real\*4"):
        oracle.ask(HJUMP, {"az": np.array([value]), "alt": np.array([0.5])})


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle")
def test_promoted_build_takes_and_returns_real8():
    """The promoted build takes what only REAL*8 holds, and answers with its digits."""
    at = {"az": np.array([0.1]), "alt": np.array([0.5]), "p": np.full((1, 12), 0.01)}
    daz = compiled.of(rt32.DESCRIPTION.path, "promoted").ask(MODEL, at)["daz"]

    assert daz.dtype == np.float64
    assert daz != daz.astype(np.float32)


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle")
def test_provenance_names_compiler_flags_and_sources():
    """The oracle says what made it: compiler, flags and the published files' SHA-256."""
    provenance = stored.describe(rt32.DESCRIPTION)

    assert provenance["compiler"].startswith("gcc ")
    assert "-O0" in provenance["flags"]
    assert set(provenance["published_sha256"]) == {"hjump.f", "model.f", "modela.f"}


def test_missing_compiler_is_an_error_where_it_is_required(monkeypatch):
    """PYPORT_ORACLE=required turns a missing compiler into bad input, never into a skip."""
    monkeypatch.setattr(compiled.building, "command_of", lambda _: None)
    monkeypatch.delenv("PYPORT_ORACLE", raising=False)
    assert not compiled.available(rt32.DESCRIPTION)
    monkeypatch.setenv("PYPORT_ORACLE", "required")

    with pytest.raises(BadInput, match="PYPORT_ORACLE"):
        compiled.available(rt32.DESCRIPTION)
