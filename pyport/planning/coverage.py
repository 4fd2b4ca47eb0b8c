"""How much of the sky some recordings cover, and where the largest holes are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array

#: Height of a cell; cells of a band are as wide as to be of one area [deg].
CELL_DEG = 15.0
HOLES = 3


@dataclass(frozen=True)
class Hole:
    """A direction [deg] far from every recording, and how far."""

    az_deg: float
    el_deg: float
    distance_deg: float


@dataclass(frozen=True)
class Coverage:
    """Cells of equal area above an elevation [deg], how many hold a recording, and the holes."""

    lowest_deg: float
    cells: int
    covered: int
    holes: tuple[Hole, ...]


def coverage(az: Array, el: Array, lowest_deg: float) -> Coverage:
    """Return the coverage of the sky above an elevation.

    `az`, `el`: where recordings were taken [rad], shape (n,).
    `lowest_deg`: sky below this does not count.
    """
    centres = cells(lowest_deg)
    nearest = np.array([separation(a, e, az, el).min() for a, e in centres])
    covered = [bool(np.any(_inside(a, e, lowest_deg, az, el))) for a, e in centres]
    holes = []
    for _ in range(HOLES):
        far = int(np.argmax(nearest))
        if nearest[far] < CELL_DEG * DEG:
            break
        az_deg, el_deg = (float(angle / DEG) for angle in centres[far])
        holes.append(Hole(az_deg, el_deg, float(nearest[far] / DEG)))
        to_hole = separation(centres[far, 0], centres[far, 1], centres[:, 0], centres[:, 1])
        nearest = np.minimum(nearest, to_hole)
    return Coverage(lowest_deg, len(centres), sum(covered), tuple(holes))


def cells(lowest_deg: float) -> Array:
    """Return the centres (azimuth, elevation) [rad] of cells of nearly equal area, (cells, 2)."""
    found = []
    height = _height(lowest_deg)
    for band in range(round((90 - lowest_deg) / height)):
        el = lowest_deg + (band + 0.5) * height
        count = _around(el)
        found += [((n + 0.5) * 360 / count, el) for n in range(count)]
    return np.array(found) * DEG


def _height(lowest_deg: float) -> float:
    """Return the height of a band of cells [deg], so that whole bands reach the zenith."""
    return (90 - lowest_deg) / max(1, round((90 - lowest_deg) / CELL_DEG))


def _around(el_deg: float) -> int:
    return max(1, round(360 * np.cos(el_deg * DEG) / CELL_DEG))


def _inside(
    az: float, el: float, lowest_deg: float, azimuths: Array, elevations: Array
) -> NDArray[np.bool_]:
    """Tell which recordings lie in the cell about a centre."""
    count = _around(el / DEG)
    across = np.abs((azimuths - az + np.pi) % (2 * np.pi) - np.pi) <= np.pi / count
    return across & (np.abs(elevations - el) <= _height(lowest_deg) / 2 * DEG + 1e-9)


def separation(az: float, el: float, azimuths: Array, elevations: Array) -> Array:
    """Return the angles between a direction and others [rad]."""
    cosine = np.sin(el) * np.sin(elevations) + np.cos(el) * np.cos(elevations) * np.cos(
        azimuths - az
    )
    return np.arccos(np.clip(cosine, -1, 1))
