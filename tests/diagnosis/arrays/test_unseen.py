"""Whole antenna-days held out: predicted, and explained where they are not."""

import numpy as np
import pytest
from diagnosis.arrays.made_array import array, case

from pyport.angles import ARCMIN
from pyport.diagnosis.arrays import words
from pyport.diagnosis.arrays.repeat import ALONE, LOUD, MOVED, medians
from pyport.diagnosis.arrays.report import report
from pyport.diagnosis.arrays.words import predict
from pyport.report import array as as_data

EAST_M = np.array([0, 400, -300, 2500, 6000, 9000, -1500, -4000, -8000, 900.0])


@pytest.fixture(scope="module")
def found():
    """Return the report of an array on three days, one antenna touched, one seen once."""
    made = array(EAST_M, seed=7, tags=(5.0, 4.0, -4.0))[0]
    antenna, session = made.at.column("antenna"), made.at.column("session")
    touched = (antenna == "A02") & (session == "day 2")
    made.y[touched] += 9 * ARCMIN * np.cos(made.at.el[touched])
    loud = antenna == "A05"
    made.y[loud] += 3 * ARCMIN * np.random.default_rng(1).normal(size=loud.sum())
    made = made.take(~((antenna == "A03") & (session != "day 1")))
    return report(*case(made, "gmrt-paper"))


@pytest.mark.slow
def test_days_are_predicted_to_their_noise(found):
    """Own parts of other days and the day's common part say all but the noise."""
    for session in found.unseen.sessions:
        one = medians(found.unseen.of(session))

        assert one.factor > 2
        assert one.after < 0.7 * ARCMIN
        assert one.fitted_after <= one.after


def test_what_goes_wrong_is_explained(found):
    """A touched mount, a loud antenna and one seen once are told apart."""
    why = {(d.antenna, d.session): (d.why, d.detail) for d in found.unseen.days}

    assert why["A02", "day 2"][0] == MOVED
    assert why["A02", "day 2"][1].startswith(("sag cosine +", "tilt north"))
    assert LOUD in {why["A05", f"day {n}"][0] for n in (1, 2, 3)}
    assert found.unseen.unpredicted == (("A03", "day 1", ALONE),)


def test_it_is_told_in_words_and_numbers(found):
    """Nothing is hidden: every antenna that could not be predicted is named with a reason."""
    text, told = words.words(found), as_data.as_json(found)

    assert "A02 day 2" in text
    assert ALONE in text
    assert len(told["held_out"]["antennas"]) == len(found.unseen.days)
    assert {one["session"] for one in told["sessions"]} == {"day 1", "day 2", "day 3"}
    assert max(len(line) for line in text.splitlines()) <= 100


def test_another_source_is_predicted():
    """Parts learnt from one declination predict another, on a session of the same name too."""
    known = report(*case(array(EAST_M, seed=2, noise=0.2)[0], "gmrt-paper"))
    # the same mounts, the same seed: own parts are drawn first
    other = array(EAST_M, seed=2, noise=0.2, sessions=1, decs_deg=(10.0,))[0]
    found = predict(known, *case(other, "gmrt-paper"))

    assert found.sessions == ["made day 1"]
    assert len(found.days) == len(EAST_M)
    assert medians(found.days).factor > 2
    assert medians(found.days).after < 0.5 * ARCMIN
