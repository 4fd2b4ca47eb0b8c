"""Real recordings: what the GMRT paper's model leaves out."""

import numpy as np
import pytest

from pyport.diagnosis.diagnose import diagnose
from pyport.formats.models import load
from pyport.recordings import read, resolve
from pyport.report.made import report_of

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def first_june():
    """Return the diagnosis of 1 June 2003 against the paper's model."""
    return diagnose(read(resolve("gmrt-2003-06-01")), load("gmrt-paper"))


@pytest.fixture(scope="module")
def cygnus():
    """Return the diagnosis of all three days of Cygnus A together."""
    return diagnose(read(resolve("gmrt-cyg-a")), load("gmrt-paper"))


def test_most_antennas_scan_differently_up_and_down(first_june):
    """An effect that the paper has no term for is named for most antennas."""
    finding = next(f for f in first_june.findings if f.verdict == "named")
    antennas = {str(name) for name in first_june.problem.blocks.antenna}

    assert finding.effect == "scan_direction"
    assert len(finding.where.subset["antenna"]) > len(antennas) / 2


def test_predictions_of_whole_scans_improve_by_two(first_june):
    """Over the antennas concerned the held-out rms falls by a factor of two or more."""
    finding = next(f for f in first_june.findings if f.effect == "scan_direction")
    concerned = finding.where.subset["antenna"]
    factors = [
        one.heldout_before_arcsec / one.heldout_after_arcsec
        for one in report_of(first_june).antennas
        if one.antenna in concerned
    ]

    assert "whole scans" in finding.heldout.scheme
    assert finding.heldout.before > 2 * finding.heldout.after
    assert np.median(factors) > 2


@pytest.mark.slow
def test_three_days_tell_the_time_tag_from_the_antennas_own_part(cygnus):
    """The common part changes from day to day: a time tag, in seconds; the rest stays."""
    timing = next(f for f in cygnus.findings if f.effect == "scan_timing")
    own = next(f for f in cygnus.findings if f.effect == "scan_direction")
    tags = {p.name: p for p in timing.parameters}

    assert timing.verdict == "named"
    assert {p.unit for p in timing.parameters} == {"s"}
    assert len(tags) == 3
    spread = max(p.value for p in tags.values()) - min(p.value for p in tags.values())
    assert spread > 10 * max(p.sigma for p in tags.values())
    assert {p.unit for p in own.parameters} == {"arcsec"}
    assert abs(np.mean([p.value for p in own.parameters])) < 1
