"""Where the ports are held to the oracle: the table's grid, pinned edges, random points."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pyport.angles import DEG
from pyport.pointing import PARAMETERS, jump_altitude
from pyport.steering.grid import RT32_GRID

Real4 = NDArray[np.float32]

#: Model3 as printed, p1 to p12 [deg].
MODEL3_DEG = np.array([one.printed_deg for one in PARAMETERS], dtype=float).astype(np.float32)


@dataclass(frozen=True)
class Points:
    """n inputs of the routines, every number a REAL*4.

    `az`, `alt` [rad] have shape (n,), `parameters` [deg] (m, 12), and `which` (n,) says which of
    the m each point uses.
    """

    az: Real4
    alt: Real4
    parameters: Real4
    which: NDArray[np.intp]

    def __len__(self) -> int:
        """Return n."""
        return len(self.az)

    @property
    def p(self) -> Real4:
        """The twelve parameters at each point [deg], shape (n, 12)."""
        return self.parameters[self.which]

    def part(self, which: slice | NDArray[np.bool_]) -> Points:
        """Return some of the points, with those parameters that they use."""
        used, renumbered = np.unique(self.which[which], return_inverse=True)
        return Points(self.az[which], self.alt[which], self.parameters[used], renumbered)

    def moved(self, az: Real4 | None = None, alt: Real4 | None = None) -> Points:
        """Return the points with other azimuths or altitudes [rad]."""
        return replace(self, az=self.az if az is None else az, alt=self.alt if alt is None else alt)


def points(az: ArrayLike, alt: ArrayLike, p: ArrayLike) -> Points:
    """Return points from azimuths, altitudes [rad] and one or n sets of parameters [deg]."""
    az, alt = np.asarray(az, np.float32), np.asarray(alt, np.float32)
    parameters, which = np.unique(
        np.broadcast_to(np.asarray(p, np.float32), (len(az), 12)).view(np.uint32),
        axis=0,
        return_inverse=True,
    )
    return Points(az, alt, parameters.view(np.float32), which)


def joined(parts: list[Points]) -> Points:
    """Return all points of `parts`, one after the other."""
    return points(
        np.concatenate([part.az for part in parts]),
        np.concatenate([part.alt for part in parts]),
        np.concatenate([part.p for part in parts]),
    )


def table(every_az: int = 1, every_zd: int = 1) -> Points:
    """Return the steering table's grid with Model3, or some of it; zenith distance runs fastest."""
    az_deg, zd_deg = (part[::every_az, ::every_zd].ravel() for part in RT32_GRID.points_deg())
    return points(az_deg * DEG, (90 - zd_deg) * DEG, MODEL3_DEG)


def random(n: int, seed: int | list[int]) -> Points:
    """Return n random points: four in five all over the sky, the others where branches turn.

    Parameters are drawn a hundred points at a time, log-uniform from 1e-6 to 1 deg with random
    sign, one in ten zero.
    """
    rng = np.random.default_rng(seed)
    sets = max(1, n // 100)
    p = 10 ** rng.uniform(-6, 0, (sets, 12)) * rng.choice([-1, 1], (sets, 12))
    p[rng.random(p.shape) < 0.1] = 0
    which = np.sort(rng.integers(0, sets, n))
    az = (rng.uniform(-270, 270, n) * DEG).astype(np.float32)
    alt = (rng.uniform(-5, 95, n) * DEG).astype(np.float32)
    near = rng.random(n) < 0.2
    az[near], alt[near] = _near_branches(az[near], rng)
    return Points(az, alt, p.astype(np.float32), which)


def _near_branches(az: Real4, rng: np.random.Generator) -> tuple[Real4, Real4]:
    """Return points within a few hundred ulp of the zenith, horizon, curve and azimuth zero."""
    n = len(az)
    alt = np.choose(
        rng.integers(0, 3, n), [np.full(n, math.pi / 2), np.zeros(n), jump_altitude(az)]
    )
    az = np.where(rng.random(n) < 0.1, np.float32(0), az)
    return _nudged(az, rng), _nudged(alt, rng)


def _nudged(values: ArrayLike, rng: np.random.Generator) -> Real4:
    """Return REAL*4 numbers moved by up to a few hundred ulp, half of them by at most three."""
    values = np.asarray(values, np.float32)
    scale = rng.choice([3, 300], len(values))
    steps = np.rint(rng.uniform(-1, 1, len(values)) * scale)
    spacing = np.spacing(np.maximum(np.abs(values), np.float32(1e-3)))
    return (values + steps.astype(np.float32) * spacing).astype(np.float32)
