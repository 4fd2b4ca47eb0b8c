"""Calibration: the statistics of cases without a cause, counted against levels."""

import pytest

from pyport.examiner.acceptance import calibrate
from pyport.examiner.nulls import nulls


def test_a_case_without_a_cause_has_its_three_statistics():
    """A p-value, the most evidence of an effect or none, and what coefficients miss by."""
    found = calibrate.examine(nulls.Case("white", 0, nulls.NULL, 3))

    assert 0 < found["p_value"] <= 1
    assert found["evidence"] is None or found["evidence"] < 20
    assert len(found["z"]) == 7
    assert max(map(abs, found["z"].values())) < 5


@pytest.mark.parametrize(
    ("name", "shares"),
    [
        ("FAMILY_ERROR", ["0.0", "50.0", "50.0", "100.0", "100.0"]),
        ("CONVINCING", ["50.0", "50.0", "50.0", "0.0", "0.0"]),
        ("coverage", ["25.0", "50.0", "100.0"]),
    ],
)
def test_shares_are_counted_against_levels(name, shares):
    """P-values up to a level, evidence above it, coefficients within it."""
    some = [
        {"kind": "white", "p_value": 0.008, "evidence": 7.0, "z": {"a": 0.5, "b": -1.5}},
        {"kind": "white", "p_value": 0.08, "evidence": None, "z": {"a": 2.5, "b": -2.9}},
    ]
    head, levels, white, every = calibrate.text(name, some).splitlines()

    assert head.startswith(name)
    assert levels.split()[2:] == [f"{one:g}" for one in calibrate.LEVELS[name]]
    assert white.split()[0] == "white"
    assert [one for one in white.split()[2:] if "(" not in one] == shares
    assert every.split()[1:] == white.split()[1:]
