"""The verdict on a finding: stability decides it, and the sentence says why."""

from __future__ import annotations

import pytest

from pyport.diagnosis.naming.finding import Evidence, Finding, Stability, Where
from pyport.diagnosis.naming.verdict import judged
from pyport.thresholds import NOTICEABLE, STABLE


def finding(effect="refraction", verdict="named", members=None):
    """Return a finding that has a name."""
    return Finding(
        effect,
        members or (effect,),
        verdict,
        "what was left out",
        Where(("el",)),
        (),
        Evidence(1e-9, 50.0, None, None),
        1e-5,
        1e-5,
    )


@pytest.mark.parametrize(
    ("kept", "names", "verdict", "members"),
    [
        # At and above eight tenths of the draws the name stands; the rest are chance.
        (40, {}, "named", ("refraction",)),
        (32, {"sag_sine": 8}, "named", ("refraction",)),
        # Below: with every name that came first in a tenth of the draws.
        (31, {"sag_sine": 9}, "ambiguous", ("refraction", "sag_sine")),
        (31, {"sag_sine": 6, "ionosphere": 3}, "ambiguous", ("refraction", "sag_sine")),
        (
            20,
            {"sag_sine": 4, "ionosphere": 16},
            "ambiguous",
            ("refraction", "sag_sine", "ionosphere"),
        ),
        # Its rival came first more often: both are reported, the fitted one first.
        (9, {"sag_sine": 31}, "ambiguous", ("refraction", "sag_sine")),
        # In half of the draws no name: still a choice between names; in more, nothing to name.
        (10, {"sag_sine": 10}, "ambiguous", ("refraction", "sag_sine")),
        (10, {"sag_sine": 9}, "unknown", ("unknown",)),
        (0, {}, "unknown", ("unknown",)),
    ],
)
def test_stability_decides(kept, names, verdict, members):
    """Named at 80 % of the draws, below with what came back, unknown when mostly nothing did."""
    found = judged(finding(), Stability("sessions", 40, kept, names))

    assert found.verdict == verdict
    assert set(found.members) == set(members)
    assert found.members[0] == members[0]
    assert found.effect == members[0]
    assert (found.looks_like is not None) == (verdict == "unknown")
    if verdict != "named":
        assert f"the name came back in {kept} of 40 draws" in found.sentence
        assert found.decide_by


def test_what_would_distinguish_the_names_follows_them():
    """The observation to make next is that for the names that came back."""
    found = judged(finding(), Stability("sessions", 40, 20, {"ionosphere": 20}))

    assert "another frequency" in found.decide_by


def test_a_class_too_wide_says_nothing():
    """More names than a class may have are no name at all."""
    names = ("refraction", "sag_sine", "ionosphere", "sag_cosine")
    others = {"drift": 5, "temperature": 5, "elevation_scale": 5}
    found = judged(
        finding(verdict="ambiguous", members=names), Stability("sessions", 40, 25, others)
    )

    assert found.verdict == "unknown"


def test_the_name_with_none_beside_it_is_not_certain():
    """No other name came back, but neither did this one often enough."""
    found = judged(finding(), Stability("sessions", 40, 25, {}))

    assert found.verdict == "ambiguous"
    assert "no name in 15" in found.sentence


def test_shares_stand_apart():
    """A share that is noticeable cannot be what a stable name leaves over by itself."""
    assert NOTICEABLE < 1 - STABLE
