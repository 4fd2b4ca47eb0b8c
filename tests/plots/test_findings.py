"""Pictures of findings: what stands on one axis, and what it is called."""

import pytest

from pyport.diagnosis.naming.finding import Parameter
from pyport.diagnosis.naming.words import spoken
from pyport.mounts import KINDS
from pyport.plots.findings import comparable, distinguishing


def parameters(*given):
    """Return coefficients of names and units."""
    return tuple(Parameter(name, 1.0, 0.1, unit) for name, unit in given)


def test_a_period_does_not_stand_on_the_axis_of_amplitudes():
    """Coefficients in minutes and in arcsec share no axis; most are in arcsec."""
    some = parameters(("period", "min"), ("amplitude_xel", "arcsec"), ("amplitude_el", "arcsec"))

    assert comparable(some) == some[1:]


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (("tilt[C01]", "tilt[C02]"), ["C01", "C02"]),
        (("offset_xel[since 2013]", "offset_el[since 2013]"), ["offset xel", "offset el"]),
        (("amplitude_xel", "amplitude_el"), ["amplitude xel", "amplitude el"]),
        (("tilt[a[b]]",), ["a[b"]),
        (("drift_xel", "drift_el[C01]"), ["drift xel", "drift el"]),
    ],
)
def test_coefficients_are_called_by_what_distinguishes_them(names, expected):
    """Antennas and sessions where they differ, else the names."""
    assert distinguishing(parameters(*((name, "arcsec") for name in names))) == expected


def test_other_axes_are_called_by_their_names():
    """The wave of an equatorial mount swings in declination; its names in files stay."""
    some = parameters(("amplitude_xel", "arcsec"), ("amplitude_el[a_el]", "arcsec"))

    said = ["amplitude in cross-declination", "amplitude in declination"]
    assert distinguishing(some, KINDS["equatorial"].names) == said
    assert spoken("amplitude_el[a_el]", KINDS["xy-ns"].names) == "amplitude in Y[a el]"
    assert spoken("amplitude_el") == "amplitude el"


def test_nothing_is_called_nothing():
    """A finding without coefficients has no names."""
    assert comparable(()) == ()
    assert distinguishing(()) == []
