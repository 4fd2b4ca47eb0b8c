"""Inputs pinned by hand: every place where a routine branches, blows up or gives in."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from pyport.angles import DEG
from pyport.parity.points import MODEL3_DEG, Points, joined, points

HALF_PI = float(np.float32(math.pi / 2))
#: Half of the REAL*4 constant 3.141593, where ModelA turns to plunge (modela.f:22).
MODELA_PLUNGE = float(np.float32(3.141593) / 2)


def around(value: float, steps: int = 1) -> list[float]:
    """Return a REAL*4 and its neighbours, up to `steps` ulp either side."""
    low, high = np.float32(-np.inf), np.float32(np.inf)
    below = above = np.float32(value)
    result = [below]
    for _ in range(steps):
        below, above = np.nextafter(below, low), np.nextafter(above, high)
        result += [below, above]
    return [float(number) for number in result]


def product(az: Iterable[float], alt: Iterable[float], p: ArrayLike = MODEL3_DEG) -> Points:
    """Return every azimuth with every altitude [rad]."""
    pairs = np.array(list(itertools.product(az, alt)), dtype=np.float32)
    return points(pairs[:, 0], pairs[:, 1], p)


def _model3_with(changes: dict[int, float]) -> np.ndarray:
    """Return Model3 with some of p1..p12 [deg] replaced."""
    p = MODEL3_DEG.copy()
    for number, value in changes.items():
        p[number - 1] = value
    return p


def edges() -> Points:
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


def _jump_curve() -> list[Points]:
    """Return altitudes at the jump's curve and up to two ulp either side of it."""
    east = [(a, 65 + 7 * math.cos(a * DEG / 2)) for a in (-270, -180, -90, -1, 0)]
    west = [(a, 55 + ((a - 95) / 90) ** 2 * 15) for a in (1, 50, 95, 180, 270)]
    return [product([a * DEG], around(h * DEG, 2)) for a, h in east + west]


def _single_cosine() -> Points:
    """Return azimuths whose REAL*4 cosine is not the REAL*8 one rounded, below the horizon."""
    az = [-4.516542434692383, -2.1071996688842773, -4.552035331726074, -1.7674838304519653]
    return product(az, [-0.0199, -0.05])


def _blind_spot(az: list[float]) -> list[Points]:
    """Return the rim of the spot of radius |sigma + beta| that no setting of the axes reaches."""
    wide = _model3_with({3: 0.4, 4: 0.3})
    rims = [(MODEL3_DEG, 0.009452 - 0.013255), (wide, 0.7)]
    return [
        product(az, [HALF_PI + side * share * rim * DEG for side in (-1, 1) for share in shares], p)
        for p, rim in rims
        for shares in [(0.5, 0.99, 1.0, 1.01)]
    ]


def _tilted_zenith() -> list[Points]:
    """Return the mount's own zenith and its neighbours: the arcsine's argument may pass 1."""
    result = []
    for xi, zeta in ((0.001393, -0.000304), (0.5, 0.25), (-0.3, 0.0), (0.1944147, 0.22395763)):
        tilt = math.hypot(xi, zeta) * DEG
        az, alt = around(math.atan2(zeta, xi), 2), around(math.pi / 2 - tilt, 2)
        result.append(product(az, alt, _model3_with({5: xi, 6: zeta})))
    return result


def _zeros(az: list[float]) -> list[Points]:
    """Return each parameter zero in turn, both zeros of the tilt, and all of them zero."""
    alt = [0.5, 1.57, 1.6]
    changes = [{number: 0.0} for number in range(1, 13)]
    changes += [{5: a, 6: b} for a in (0.0, -0.0) for b in (0.0, -0.0)]
    sets = [product(az, alt, _model3_with(change)) for change in changes]
    return [*sets, product(az, alt, np.zeros(12)), product(az, alt, -np.zeros(12))]


def _wraps() -> list[Points]:
    """Return azimuth offsets that pass 180 deg, or several turns, on their way."""
    offsets = [*around(180), *around(-180), 360, -360, 540, 1e4]
    sets = [product([0.3, -2.0], [0.8, 1.6], _model3_with({1: value})) for value in offsets]
    # exactly half a turn stays what it is
    return [*sets, *(product([0.0], [0.8], [half, *[0.0] * 11]) for half in (180, -180))]


def _extremes() -> list[Points]:
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
