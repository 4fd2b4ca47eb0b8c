"""Table 18: the paper's own fits of a + b cos(15 HA + d), antenna by antenna and day by day."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pyport.angles import ARCMIN, DEG, Array
from pyport.recordings.tabulate import Table
from pyport.studies.gmrt.recovery import printed

#: The file that Table 18 is shipped in.
NAME = "table_18.csv"

#: Where each day's six cells (a, b, d, each with its sigma) begin, counted from 0.
BEGINS = {
    1: "2003-03-31",
    8: "2003-06-01",
    14: "2003-06-02",
    20: "2003-06-05",
    26: "2003-05-31",
}

#: Cells that stand a little aside of their day: (antenna, where they begin) -> the day.
#: The tables decide: of all days it is the one whose offsets the curve runs through.
SHIFTED = {
    ("C12", 27): "2003-06-05",
    ("C12", 33): "2003-05-31",
    ("S02", 18): "2003-06-05",
    ("S04", 27): "2003-05-31",
}


_UNITS = (ARCMIN, ARCMIN, ARCMIN, ARCMIN, DEG, DEG)


@dataclass(frozen=True)
class Wave:
    """A published curve a + b cos(HA + d), with the printed sigmas [rad]."""

    antenna: str
    session: str
    a: float
    sigma_a: float
    b: float
    sigma_b: float
    d: float
    sigma_d: float

    def __call__(self, hour_angle: Array) -> Array:
        """Return the elevation offset [rad] at hour angles [rad]."""
        return self.a + self.b * np.cos(hour_angle + self.d)


def table_18() -> tuple[Wave, ...]:
    """Return every curve of Table 18, its rows in turn, in each the days as printed."""
    return tuple(
        Wave(antenna, session, *(float(v) * u for v, u in zip(values, _UNITS, strict=True)))
        for antenna, session, values, _ in _curves()
    )


def _curves() -> Iterator[tuple[str, str, list[str], tuple[int, int]]]:
    """Yield antenna, session, the six printed values and their printed row and column."""
    for number, cells in enumerate(printed.lines(18)[2:], 1):
        antenna = cells[0].strip("'")
        begin = 1
        while begin < len(cells):
            if not cells[begin]:
                begin += 1
                continue
            session = BEGINS.get(begin) or SHIFTED[antenna, begin]
            values = [cell.removeprefix("+/- ") for cell in cells[begin : begin + 6]]
            yield antenna, session, values, (number, begin + 1)
            begin += 6


def table() -> Table:
    """Return Table 18 as columns, each curve with the place it was printed in."""
    names = "antenna session a_arcmin sigma_a_arcmin b_arcmin sigma_b_arcmin d_deg sigma_d_deg"
    titles = [*names.split(), "table", "printed_row", "printed_column"]
    rows = [
        [antenna, session, *values, "18", *map(str, place)]
        for antenna, session, values, place in _curves()
    ]
    columns = {t: np.array(c) for t, c in zip(titles, zip(*rows, strict=True), strict=True)}
    return Table({"curve": "a + b cos(15 HA + d), HA in hours, offsets in arcmin"}, columns)
