"""Places alone, in the order of the rows: nights that nobody wrote down are no findings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.diagnosis.diagnose import diagnose
from pyport.formats.models import load
from pyport.noise.estimation import departing


def leaning(rows, seed, tilt):
    """Return recordings of places alone, the azimuth axis leaning by `tilt` (rows,) [arcsec]."""
    made = recordings(
        rows,
        seed,
        x=lambda at: tilt * np.sin(at.el) * np.sin(at.az),
        y=lambda at: tilt * np.cos(at.az),
    )
    return replace(made, at=replace(made.at, columns={}))


def of_nights(seed):
    """Return 320 places of five nights, each with a tilt of its own."""
    tilts = 7 * np.random.default_rng(seed).normal(size=5)
    return leaning(320, seed, tilts[np.arange(320) * 5 // 320])


@pytest.mark.parametrize("seed", [6, 7])
def test_a_tilt_that_differs_every_night_is_no_step(seed, monkeypatch):
    """It scatters from stretch to stretch; one long night has none."""
    found = diagnose(of_nights(seed), load("altaz"))
    monkeypatch.setattr(departing, "FEWEST", 1000)
    as_one_night = diagnose(of_nights(seed), load("altaz"))

    assert not found.findings
    assert [one.term for one in found.weighed.covariance.departures] == ["tilt of the azimuth axis"]
    assert as_one_night.weighed.covariance.departures == ()


def test_one_change_of_the_tilt_is_found():
    """Where nothing else happens: named, within ten rows, with its size."""
    made = leaning(320, 5, np.where(np.arange(320) < 210, 0.0, 12.0))
    (found,) = diagnose(made, load("altaz")).findings

    assert (found.effect, found.verdict) == ("epoch_tilt", "named")
    assert abs(int(found.variant.rpartition(" ")[2]) - 211) <= 10
