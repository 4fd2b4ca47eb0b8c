"""The whole table against its stored digest."""

from __future__ import annotations

from pathlib import Path

from pyport.steering import tabulate
from pyport.steering.golden import digests

#: Of the checkout: an installed program, which has no such folder, is held to it too.
FILE = Path(__file__).parents[2] / "golden_tables/steering/3model.digests"


def test_every_row_of_the_table_is_what_it_was():
    """All 51395 rows have the stored bytes; a difference names its azimuth."""
    expected = FILE.read_text().splitlines()
    actual = digests(tabulate())

    assert expected == actual
