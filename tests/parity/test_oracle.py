"""The oracle's Python side takes only numbers that the Fortran holds exactly."""

import numpy as np
import pytest

pytestmark = pytest.mark.oracle


@pytest.mark.parametrize("value", [0.1, 1e300, 2**24 + 1, 1e-50])
def test_number_that_real4_cannot_hold_is_refused(oracle, value):
    """A number that rounding to REAL*4 would change is an error, not another number."""
    with pytest.raises(ValueError, match=r"az: .* is no float32"):
        oracle.hjump([value], [0.5])


@pytest.mark.parametrize("value", ["1.5", None, True, 1j])
def test_what_is_no_real_number_is_refused(oracle, value):
    """Text, truth values and complex numbers are not converted in silence."""
    with pytest.raises(TypeError, match="az must hold real numbers"):
        oracle.hjump([value], [0.5])


@pytest.mark.parametrize("p", [np.zeros(11), np.zeros((3, 12)), np.zeros((12, 2))])
def test_wrong_shape_of_parameters_is_refused(oracle, p):
    """There are twelve parameters, common to all points or given at each."""
    with pytest.raises(ValueError, match="p must have shape"):
        oracle.model(np.zeros(2), np.zeros(2), p)


def test_promoted_build_takes_and_returns_real8(oracle):
    """The promoted build takes what only REAL*8 holds, and answers with its digits."""
    daz, _ = oracle.model([0.1], [0.5], np.full(12, 0.01), promoted=True)

    assert daz.dtype == np.float64
    assert daz != daz.astype(np.float32)


def test_provenance_names_compiler_flags_and_sources(oracle):
    """The oracle says what made it: compiler, flags and the published files' SHA-256."""
    provenance = oracle.provenance()

    assert provenance["compiler"].startswith("gcc ")
    assert "-O0" in provenance["flags"]
    assert set(provenance["published_sha256"]) == {"hjump.f", "model.f", "modela.f"}
