"""What acts in one session alone is no lasting effect: its coefficient would be no one's."""

from __future__ import annotations

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.diagnosis.diagnose import diagnose
from pyport.formats.models import load

NIGHT = np.arange(450) // 150


def found(there):
    """Return what is found where an encoder is off centre in some of three nights."""
    made = recordings(
        450,
        11,
        x=lambda at: 12 * np.cos(at.el) * np.sin(at.az) * np.isin(NIGHT, there),
        session=np.char.add("n", NIGHT.astype(str)),
        time=1.2e9 + 86400.0 * NIGHT + 120.0 * (np.arange(450) % 150),
    )
    return diagnose(made, load("altaz")).findings


@pytest.mark.slow
def test_what_one_session_has_alone_keeps_no_name_and_is_told():
    """The second of three: halves would not part it from the others."""
    (one,) = found([1])

    assert one.effect == "unknown"
    assert one.looks_like.startswith("the azimuth encoder sits off centre")
    assert "but strength in session n1: " in one.looks_like


@pytest.mark.slow
def test_what_every_session_has_keeps_its_name():
    """The session that differs most is told."""
    (one,) = found([0, 1, 2])

    assert one.effect == "azimuth_eccentricity"
    assert any(check.startswith("strength in session n") for check in one.checks)
