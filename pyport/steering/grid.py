"""The array that a steering system reads: its grid and its numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.errors import BadInput


@dataclass(frozen=True)
class Grid:
    """Azimuths and zenith distances of a table, in degrees, ascending by equal steps.

    Azimuth as the telescope's own counter has it, unwrapped: -100 and 260 are
    different columns. Zenith distances below zero point in plunge.
    """

    az_deg: Array
    zd_deg: Array

    def __len__(self) -> int:
        """Return the number of rows of the table."""
        return len(self.az_deg) * len(self.zd_deg)

    def points_deg(self) -> tuple[Array, Array]:
        """Return azimuth and zenith distance of every point [deg], shape (azimuths, zenith)."""
        az_deg, zd_deg = np.meshgrid(self.az_deg, self.zd_deg, indexing="ij")
        return az_deg, zd_deg

    def steps_deg(self) -> tuple[float, float]:
        """Return the steps in azimuth and in zenith distance [deg]."""
        return _step(self.az_deg), _step(self.zd_deg)


def _step(values: Array) -> float:
    return float(values[-1] - values[0]) / (len(values) - 1) if len(values) > 1 else 1.0


def span(text: str) -> Array:
    """Return the values that FIRST:LAST:STEP stands for [deg], both ends included.

    Raises
    ------
    BadInput
        The text is not three numbers, or the steps do not lead from first to last.
    """
    try:
        first, last, step = (float(word) for word in text.split(":"))
        count = round((last - first) / step) + 1
    except (ValueError, ZeroDivisionError, OverflowError):
        raise BadInput(f"expected FIRST:LAST:STEP in degrees, found {text!r}") from None
    values = np.asarray(first + step * np.arange(max(count, 0)), dtype=float)
    if count < 2 or step < 0 or abs(values[-1] - last) > 1e-9 * abs(last - first):
        raise BadInput(f"{text!r}: steps of {step:g} deg do not lead from {first:g} to {last:g}")
    return values


#: What the RT32's steering reads: 541 x 95 points, one degree apart.
RT32_GRID = Grid(np.arange(-270.0, 271.0), np.arange(-5.0, 90.0))

#: The last decimal of the published table: offsets are whole multiples of 1e-7 deg.
UNITS_PER_DEG = 1e7


@dataclass(frozen=True)
class Table:
    """Offsets on a grid, in degrees, to be added to the true coordinates.

    Attributes
    ----------
    grid
        n azimuths and m zenith distances.
    d_az_deg, d_zd_deg
        Offset of azimuth (the coordinate's) and of zenith distance, shape (n, m).
    model, refraction, reading
        What they were computed from and how, by name; "" where a file does not tell.
    """

    grid: Grid
    d_az_deg: Array
    d_zd_deg: Array
    model: str = ""
    refraction: str = ""
    reading: str = ""

    def units(self) -> NDArray[np.int64]:
        """Return both offsets in whole units of 1e-7 deg, shape (2, n, m).

        Every file is written from these, so that all of them hold the same digits.
        """
        with np.errstate(invalid="ignore"):  # what is no number is refused where it is written
            units = np.rint(np.stack([self.d_az_deg, self.d_zd_deg]) * UNITS_PER_DEG)
            return units.astype(np.int64)
