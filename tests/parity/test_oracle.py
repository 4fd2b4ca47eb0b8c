"""The oracle takes only numbers that the Fortran holds exactly, and says what made it."""

import os
import select

import numpy as np
import pytest
import rt32

from pyport.errors import BadInput
from pyport.parity.compiled import driver, stored
from pyport.parity.compiled import oracle as compiled

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


@pytest.mark.oracle
@pytest.mark.parametrize(
    "wrong",
    [
        lambda az: az.astype(np.float64),
        lambda az: az.astype(np.int32),
        lambda az: np.repeat(az, 2)[::2],
        lambda az: az[:-1],
    ],
    ids=["real*8", "integer", "strided", "short"],
)
def test_f2py_converts_nothing(oracle, wrong):
    """The wrapper refuses an array of another kind, layout or size: no copy, no rounding."""
    module = compiled.imported(str(oracle.library))
    loop = getattr(module, driver.entry(rt32.DESCRIPTION.routines.index(HJUMP)))
    arrays = [np.linspace(0, 1, 4).astype(np.float32) for _ in driver.passed(HJUMP)]
    loop(4, *arrays)

    with pytest.raises(Exception, match=r"intent\(inout\)|shape"):
        loop(4, wrong(arrays[0]), *arrays[1:])


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle")
@pytest.mark.parametrize("build", ["reference", "promoted"])
def test_signature_has_the_kinds_of_the_build(build):
    """REAL*4 arrays are REAL*4 to f2py, and REAL*8 where the build promotes them."""
    asked = compiled.of(rt32.DESCRIPTION.path, build)
    text = driver.signature(rt32.DESCRIPTION, asked.build)

    assert ("real*4" in text, "real*8" in text) == ((True, False), (False, True))[
        build == "promoted"
    ]


@pytest.mark.oracle
@pytest.mark.usefixtures("oracle")
def test_process_holds_nothing_of_its_parent_open():
    """A pipe that is closed here has ended, though an oracle was started while it was open."""
    here, there = os.pipe()
    asked = compiled.Oracle(rt32.DESCRIPTION, rt32.DESCRIPTION.reference)
    try:
        asked.ask(HJUMP, {"az": np.float32([0.1]), "alt": np.float32([0.5])})
        os.close(there)

        assert select.select([here], [], [], 5)[0]
        assert os.read(here, 1) == b""
    finally:
        os.close(here)
        asked.close()


@pytest.mark.oracle
def test_every_pattern_of_bits_passes(oracle):
    """What a loop does not touch comes back as it was: payloads of NaN, -0, subnormals."""
    bits = np.array([0x7F800001, 0xFFC12345, 0x80000000, 1, 0x7F800000], np.uint32)
    at = {"az": bits.view(np.float32), "alt": np.full(5, 0.5, np.float32)}
    arrays = [at.get(one.key, np.zeros(5, np.float32)) for one in driver.passed(HJUMP)]
    module = compiled.imported(str(oracle.library))
    number = rt32.DESCRIPTION.routines.index(HJUMP)

    after = compiled.call(module, number, arrays)
    assert after[0].tobytes() == bits.tobytes()
    empty = compiled.call(module, number, [one[:0] for one in arrays])
    assert [one.shape for one in empty] == [(0,)] * len(arrays)


@pytest.mark.parametrize("gone", ["PYPORT_ORACLE", "C compiler", r"Python\.h"])
def test_missing_compiler_or_header_is_named(monkeypatch, tmp_path, gone):
    """f2py's wrapper is C: without a compiler or Python.h the stored answers serve, or none may."""
    fortran, c = gone != "PYPORT_ORACLE", gone != "C compiler"
    monkeypatch.setattr(compiled.building, "command_of", lambda name: name if fortran else None)
    monkeypatch.setattr(compiled.building, "c_compiler", lambda: "cc" if c else None)
    monkeypatch.setattr(compiled.building.sysconfig, "get_path", lambda _: str(tmp_path))
    monkeypatch.delenv("PYPORT_ORACLE", raising=False)
    assert not compiled.available(rt32.DESCRIPTION)
    monkeypatch.setenv("PYPORT_ORACLE", "required")

    with pytest.raises(BadInput, match=gone):
        compiled.available(rt32.DESCRIPTION)
