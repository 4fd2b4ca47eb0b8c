"""What acts in one session alone is no lasting effect: its coefficient would be no one's."""

from __future__ import annotations

import numpy as np
import pytest
from diagnosis.made import recordings

from pyport.diagnosis import joint
from pyport.diagnosis.case import Chosen
from pyport.diagnosis.diagnose import diagnose
from pyport.diagnosis.naming import scene
from pyport.diagnosis.naming.noise_remarks import uneven
from pyport.diagnosis.preparing import prepare
from pyport.diagnosis.weighing import weigh
from pyport.formats.models import load
from pyport.report.made import report_of


def diagnosed(nights, there, wave):
    """Return the diagnosis of 450 readings of some nights, a wave in azimuth in some of them."""
    night = np.arange(450) * nights // 450
    made = recordings(
        450,
        11,
        x=lambda at: 12 * np.cos(at.el) * np.sin(wave * at.az) * np.isin(night, there),
        session=np.char.add("n", night.astype(str)),
        time=1.2e9 + 86400.0 * night + 120.0 * (np.arange(450) % 150),
    )
    return diagnose(made, load("altaz"))


def found(there):
    """Return what is found where an encoder is off centre in some of three nights."""
    return diagnosed(3, there, 1).findings


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


@pytest.mark.slow
def test_strengths_are_shares_of_what_the_rest_has():
    """Half as strong in the last of three nights as in the others, which the common fit is not."""
    night = np.arange(900) // 300
    made = recordings(
        900,
        12,
        x=lambda at: 20 * np.cos(at.el) * np.sin(at.az) * np.where(night == 2, 0.5, 1.0),
        session=np.char.add("n", night.astype(str)),
        time=1.2e9 + 86400.0 * night + 60.0 * (np.arange(900) % 300),
    )
    problem = prepare(made, load("altaz"))
    chosen = tuple(
        Chosen(one, "all") for one in problem.candidates if one.effect.id == "azimuth_eccentricity"
    )
    weighed = weigh(problem, chosen)
    fitted = joint.fit(problem, weighed, chosen)
    place = next(
        n for n, one in enumerate(fitted.choices) if one.candidate.effect.physical and one in chosen
    )
    (last,) = scene._strengths(
        problem, weighed, fitted, place, {"n2": problem.session == 2}
    ).values()

    assert last.extra == pytest.approx(-0.5, abs=3 * last.sigma)
    assert last.sigma < 0.05


@pytest.mark.slow
def test_a_session_that_scatters_more_is_said():
    """Of nine the fifth has a wave of its own: nothing lasts, and that is no all-clear."""
    one = report_of(diagnosed(9, [4], 2))
    said = "catter in cross-elevation is "

    (sentence,) = [words for words in one.noise.sentences if f"S{said}" in words]
    assert sentence.endswith("arcsec in n4")
    assert f"s{said}" in one.verdict
    even = report_of(diagnosed(9, [], 2))
    assert not any(" arcsec in n" in words for words in (*even.noise.sentences, even.verdict))


@pytest.mark.slow
def test_nights_of_one_row_tell_no_scatter():
    """Beside thirty of them one night of many is none that scatters more."""
    night = np.minimum(np.arange(150), 30)
    made = recordings(
        150,
        11,
        session=np.char.add("n", night.astype(str)),
        time=1.2e9 + 86400.0 * night + 120.0 * np.maximum(np.arange(150) - 30, 0),
    )

    found = diagnose(made, load("altaz"))

    assert uneven(found, found.left(found.after)) == []
