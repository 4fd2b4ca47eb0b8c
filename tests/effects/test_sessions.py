"""When a session began: as recorded, or as the gaps between nights show."""

import numpy as np
import pytest

from pyport.effects import Circumstances
from pyport.effects.sessions import since_begun, spans_of

HOUR = 3600.0
#: Two nights, the second cut in two by a break; rows are in no order.
TIME = HOUR * np.array([24.0, 0.0, 1.0, 28.0, 3.0, 25.0])
KNOWN = {"a": [0.0, 3 * HOUR], "b": [23 * HOUR, 29 * HOUR]}


def at(time=TIME, **columns):
    """Return circumstances at some moments."""
    level = np.full(len(time), 0.5)
    return Circumstances(level, level, columns={"time": time, **columns})


def test_without_sessions_a_night_begins_after_a_gap():
    """In the order of time, whatever the order of the rows."""
    assert sorted(spans_of(at()).values()) == [[0.0, 3 * HOUR], [24 * HOUR, 28 * HOUR]]
    assert (since_begun(at(), {}) / HOUR).tolist() == [0, 0, 1, 4, 3, 1]


def test_a_night_without_a_name_goes_on_where_one_was_recorded():
    """Its session began before its first row here; one of a night not recorded did not."""
    assert (since_begun(at(), KNOWN) / HOUR).tolist() == [1, 0, 1, 5, 3, 2]
    later = at(TIME + 48 * HOUR)
    assert (since_begun(later, KNOWN) / HOUR).tolist() == [0, 0, 1, 4, 3, 1]


@pytest.mark.parametrize(
    ("names", "hours"),
    [
        (["b", "a", "a", "b", "a", "b"], [1, 0, 1, 5, 3, 2]),
        # Of another name: it begins with its own first row.
        (["c", "a", "a", "c", "a", "c"], [0, 0, 1, 4, 3, 1]),
        (["b", "a", "a", "c", "a", "b"], [1, 0, 1, 0, 3, 2]),
    ],
)
def test_sessions_with_names_are_known_by_them(names, hours):
    """And by when they began: of that name at another time it is another one."""
    named = at(session=np.array(names))

    assert (since_begun(named, KNOWN) / HOUR).tolist() == hours
    later = at(TIME + 48 * HOUR, session=np.array(names))
    assert since_begun(later, KNOWN).tolist() == since_begun(later, {}).tolist()


def test_what_has_no_time_belongs_to_no_moment():
    """A row without a time, the others as they are."""
    some = np.where(np.arange(6) == 2, np.nan, TIME)

    np.testing.assert_array_equal(since_begun(at(some), {}) / HOUR, [0, 0, np.nan, 4, 3, 1])
