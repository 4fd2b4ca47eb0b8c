"""A zero that walks on through weeks is noise: nothing is found in it."""

import pytest

from pyport.api import diagnose
from pyport.examiner.nulls import nulls


@pytest.mark.parametrize("number", [23, 113, 167])
def test_a_walk_through_weeks_is_no_finding(number):
    """However far it comes, and though nights that depart from each other do nearly the same."""
    world = nulls.draw(nulls.Case("random-walk", number, nulls.NULL, 1))

    assert diagnose(world.table, header=world.header).report["findings"] == []
