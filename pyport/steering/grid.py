"""The array that a steering system reads: its grid and its numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pyport.angles import Array


@dataclass(frozen=True)
class Grid:
    """Azimuths and zenith distances of a table, in degrees, each ascending.

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


#: What the RT32's steering reads: 541 x 95 points, one degree apart.
RT32_GRID = Grid(np.arange(-270.0, 271.0), np.arange(-5.0, 90.0))


@dataclass(frozen=True)
class Table:
    """Offsets on a grid, in degrees, to be added to the true coordinates.

    Attributes
    ----------
    grid
        n azimuths and m zenith distances.
    d_az_deg, d_zd_deg
        Offset of azimuth (the coordinate's) and of zenith distance, shape (n, m).
    model, refraction
        What they were computed from, by name.
    """

    grid: Grid
    d_az_deg: Array
    d_zd_deg: Array
    model: str
    refraction: str
