"""Refining: a step's moment and an edge's curve are found where they are."""

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.diagnosis.diagnose import diagnose
from pyport.formats.models import load


@pytest.mark.slow
def test_a_step_is_dated_to_within_two_recordings():
    """A step of two sigmas in elevation comes back with the moment it happened."""
    given = recordings(500, 1)
    time = given.at.column("time")
    moment = np.sort(time)[310] - 0.5
    found = diagnose(
        recordings(500, 1, y=lambda at: 10 * (at.column("time") > moment)), load("altaz")
    )
    first = found.findings[0]
    since = np.datetime64(first.where.since.rstrip("Z")).astype("datetime64[s]").astype(float)
    between = np.count_nonzero((time > min(since, moment)) & (time < max(since, moment)))

    assert "epoch_offset" in first.members
    assert between <= 2


@pytest.mark.slow
@pytest.mark.parametrize("lean_deg", [0.0, 8.0])
def test_an_edge_is_found_along_its_length(lean_deg):
    """A jump above a curve in the sky comes back with it, to two degrees nearly everywhere."""

    def edge(az):
        return np.radians(45 + lean_deg * np.cos(az - 1.0))

    found = diagnose(recordings(1500, 2, y=lambda at: -20.0 * (at.el > edge(at.az))), load("altaz"))
    first = found.findings[0]
    az, el = np.array(first.where.curve).T
    off = np.abs(el - np.degrees(edge(np.radians(az))))

    assert first.effect == "subreflector_jump"
    assert np.quantile(off, 0.9) < 2
    assert abs(first.parameters[0].value + 20) < 3
