"""The whole table against its stored digest."""

from __future__ import annotations

from pyport.steering import tabulate
from pyport.steering.golden import FILE, digests


def test_every_row_of_the_table_is_what_it_was():
    """All 51395 rows have the stored bytes; a difference names its azimuth."""
    expected = FILE.read_text().splitlines()
    actual = digests(tabulate())

    assert expected == actual
