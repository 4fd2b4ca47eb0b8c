"""Where the RT32's ports are held to the oracle: the table's grid, pinned edges, random points.

The edges are inputs pinned by hand: every place where a routine branches, blows up or gives in.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pyport.angles import DEG
from pyport.parity.described.description import Batch
from pyport.parity.described.functions import joined
from pyport.parity.described.inputs import nudged
from pyport.pointing import PARAMETERS, jump_altitude
from pyport.steering.grid import RT32_GRID

Real4 = NDArray[np.float32]

#: Model3 as printed, p1 to p12 [deg].
MODEL3_DEG = np.array([one.printed_deg for one in PARAMETERS], dtype=float).astype(np.float32)

HALF_PI = float(np.float32(math.pi / 2))
#: Half of the REAL*4 constant 3.141593, where ModelA turns to plunge (modela.f:22).
MODELA_PLUNGE = float(np.float32(3.141593) / 2)


def points(az: ArrayLike, alt: ArrayLike, p: ArrayLike) -> Batch:
    """Return points from azimuths, altitudes [rad] and one or n sets of parameters [deg]."""
    az, alt = np.asarray(az, np.float32), np.asarray(alt, np.float32)
    return {"az": az, "alt": alt, "p": np.array(np.broadcast_to(np.float32(p), (len(az), 12)))}


def table(every_az: int = 1, every_zd: int = 1) -> Batch:
    """Return the steering table's grid with Model3, or some of it; zenith distance runs fastest."""
    az_deg, zd_deg = (part[::every_az, ::every_zd].ravel() for part in RT32_GRID.points_deg())
    return points(az_deg * DEG, (90 - zd_deg) * DEG, MODEL3_DEG)


def table_sample() -> Batch:
    """Return the points of the table whose answers are stored."""
    return table(every_az=15, every_zd=6)


def random(n: int, seed: int | list[int]) -> Batch:
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
    return {"az": az, "alt": alt, "p": p.astype(np.float32)[which]}


def _near_branches(az: Real4, rng: np.random.Generator) -> tuple[NDArray, NDArray]:
    """Return points within a few hundred ulp of the zenith, horizon, curve and azimuth zero."""
    n = len(az)
    alt = np.choose(
        rng.integers(0, 3, n), [np.full(n, math.pi / 2), np.zeros(n), jump_altitude(az)]
    )
    az = np.where(rng.random(n) < 0.1, np.float32(0), az)
    return nudged(az, rng), nudged(alt.astype(np.float32), rng)


def around(value: float, steps: int = 1) -> list[float]:
    """Return a REAL*4 and its neighbours, up to `steps` ulp either side."""
    low, high = np.float32(-np.inf), np.float32(np.inf)
    below = above = np.float32(value)
    result = [below]
    for _ in range(steps):
        below, above = np.nextafter(below, low), np.nextafter(above, high)
        result += [below, above]
    return [float(number) for number in result]


def product(az: Iterable[float], alt: Iterable[float], p: ArrayLike = MODEL3_DEG) -> Batch:
    """Return every azimuth with every altitude [rad]."""
    pairs = np.array(list(itertools.product(az, alt)), dtype=np.float32)
    return points(pairs[:, 0], pairs[:, 1], p)


def _model3_with(changes: dict[int, float]) -> np.ndarray:
    """Return Model3 with some of p1..p12 [deg] replaced."""
    p = MODEL3_DEG.copy()
    for number, value in changes.items():
        p[number - 1] = value
    return p


def edges() -> Batch:
    """Return all pinned inputs."""
    az = [a * DEG for a in (-270, -180, -100, -45, 0, 17, 90, 180, 260, 270)]
    some = az[1:-1:3]
    sets = [
        product(az, around(HALF_PI, 2) + around(MODELA_PLUNGE)),
        product(az, [e * DEG for e in (95, 94.99, 91, 90.03)]),
        product(some, [*around(0.0), -0.0, -1e-6, -5 * DEG, -HALF_PI]),
        product([*around(0.0), -0.0, *around(math.pi), *around(-math.pi)], [0.7, 1.2, 1.3]),
        product([a * DEG for a in (-100, 260, -200, 160, -300, 60)], [-0.1, 0.9, 1.1, 1.17]),
        *_jump_curve(),
        _single_cosine(),
        *_blind_spot(some),
        *_tilted_zenith(),
        *_zeros(some),
        *_wraps(),
        *_extremes(),
    ]
    return joined(sets)


def _jump_curve() -> list[Batch]:
    """Return altitudes at the jump's curve and up to two ulp either side of it."""
    east = [(a, 65 + 7 * math.cos(a * DEG / 2)) for a in (-270, -180, -90, -1, 0)]
    west = [(a, 55 + ((a - 95) / 90) ** 2 * 15) for a in (1, 50, 95, 180, 270)]
    return [product([a * DEG], around(h * DEG, 2)) for a, h in east + west]


def _single_cosine() -> Batch:
    """Return azimuths whose REAL*4 cosine is not the REAL*8 one rounded, below the horizon."""
    az = [-4.516542434692383, -2.1071996688842773, -4.552035331726074, -1.7674838304519653]
    return product(az, [-0.0199, -0.05])


def _blind_spot(az: list[float]) -> list[Batch]:
    """Return the rim of the spot of radius |sigma + beta| that no setting of the axes reaches."""
    wide = _model3_with({3: 0.4, 4: 0.3})
    rims = [(MODEL3_DEG, 0.009452 - 0.013255), (wide, 0.7)]
    return [
        product(az, [HALF_PI + side * share * rim * DEG for side in (-1, 1) for share in shares], p)
        for p, rim in rims
        for shares in [(0.5, 0.99, 1.0, 1.01)]
    ]


def _tilted_zenith() -> list[Batch]:
    """Return the mount's own zenith and its neighbours: the arcsine's argument may pass 1."""
    result = []
    for xi, zeta in ((0.001393, -0.000304), (0.5, 0.25), (-0.3, 0.0), (0.1944147, 0.22395763)):
        tilt = math.hypot(xi, zeta) * DEG
        az, alt = around(math.atan2(zeta, xi), 2), around(math.pi / 2 - tilt, 2)
        result.append(product(az, alt, _model3_with({5: xi, 6: zeta})))
    return result


def _zeros(az: list[float]) -> list[Batch]:
    """Return each parameter zero in turn, both zeros of the tilt, and all of them zero."""
    alt = [0.5, 1.57, 1.6]
    changes = [{number: 0.0} for number in range(1, 13)]
    changes += [{5: a, 6: b} for a in (0.0, -0.0) for b in (0.0, -0.0)]
    sets = [product(az, alt, _model3_with(change)) for change in changes]
    return [*sets, product(az, alt, np.zeros(12)), product(az, alt, -np.zeros(12))]


def _wraps() -> list[Batch]:
    """Return azimuth offsets that pass 180 deg, or several turns, on their way."""
    offsets = [*around(180), *around(-180), 360, -360, 540, 1e4]
    sets = [product([0.3, -2.0], [0.8, 1.6], _model3_with({1: value})) for value in offsets]
    # exactly half a turn stays what it is
    return [*sets, *(product([0.0], [0.8], [half, *[0.0] * 11]) for half in (180, -180))]


def _extremes() -> list[Batch]:
    """Return the ends of REAL*4: largest, smallest normal and subnormal, infinity, NaN."""
    info = np.finfo(np.float32)
    ends = [info.max, info.tiny, info.smallest_subnormal, np.inf]
    values = [np.nan, *ends, *(-np.array(ends))]
    sets = [product([value], [0.8, 1.6]) for value in values]
    sets += [product([0.3], [value]) for value in values]
    sets += [
        product([0.3], [0.8, 1.6], _model3_with({number: value}))
        for number in range(1, 13)
        for value in values[::2]
    ]
    return sets
