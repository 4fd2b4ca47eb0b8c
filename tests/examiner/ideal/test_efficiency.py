"""The table of periods: how often an oscillation is found, and how well."""

import pytest

from pyport.examiner.ideal import efficiency

CAUSE = {"facts": {"period_s": 3600.0}}


def report(*minutes):
    """Return a report of oscillations of some periods."""
    return {"findings": [{"parameters": [{"name": "period", "value": one}]} for one in minutes]}


@pytest.mark.parametrize(
    ("said", "error"), [(report(61.2), 0.02), (report(57.0, 60.0), -0.05), (report(), None)]
)
def test_the_error_of_a_period(said, error):
    """Of the first finding that has one, as a share of the true one."""
    found = efficiency.period_error(said, [CAUSE])

    assert found is None if error is None else found == pytest.approx(error)
    assert efficiency.period_error(said, [{"facts": {}}]) is None


def test_the_table_counts_periods_within_three_per_cent():
    """Beside how many were named; other causes have no line."""
    one = {
        "effect": "oscillation",
        "rows": 300,
        "rho": 0.5,
        "possible": 1.0,
        "detected": True,
        "named": True,
    }
    errors = (0.01, -0.02, 0.04, None)
    other = one | {"effect": "tilt", "period_error": None}
    text = efficiency.text([*(one | {"period_error": error} for error in errors), other])
    line = text.splitlines()[-1].split()

    assert line == ["oscillation", "300", "0.5", "4", "4", "2", "2.00", "%"]
    assert "period" not in efficiency.text([other])
