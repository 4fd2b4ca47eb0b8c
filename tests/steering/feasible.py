"""Which parameters, inside the rounding of their print, write every printed number of the table.

The offsets are linear in so small a change of the parameters, so that this is a linear
programme: 584 printed numbers set two inequalities each on twelve unknowns, and a last unknown
says how far the worst number must be let out of its rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pyport.angles import DEG, Array
from pyport.pointing import printed
from pyport.pointing.approximate import approximate_offsets
from pyport.pointing.exact import Tilt, formulae, tilted
from pyport.pointing.parameters import PRINTED_ROUNDING
from pyport.steering.as_written import wrapped_deg
from pyport.steering.published import Block, published
from pyport.steering.tabulate import DEFAULT_REFRACTION, refraction4, rt32_offsets

#: Unknowns of the programme: a millionth of a degree, the parameters' last printed digit.
_UNIT = 1e-6 * DEG


@dataclass(frozen=True)
class Feasibility:
    """The answer of the linear programme.

    Attributes
    ----------
    excess_deg
        How far the worst printed number stays outside its rounding; 0 when all are met.
    parameters
        p1..p12 [rad] that come so near.
    low, high
        Between which each of them may lie when all numbers are met [rad]; None otherwise.
    binding
        The printed numbers that hold the excess up: block, azimuth and zenith distance [deg].
    """

    excess_deg: float
    parameters: Array
    low: Array | None
    high: Array | None
    binding: tuple[tuple[str, float, float], ...]


def tilted_over_the_shoulder(
    az_south: Array, altitude: Array, xi: float, zeta: float
) -> tuple[Array, Array]:
    """Return what `tilted` does, with the program's way in plunge.

    Beyond the zenith it takes the tilt at 180 deg - altitude with its sign turned, and
    adds the changes that this makes. Model turns the sign too, but mirrors the change of
    altitude: both agree to first order, not in the second.
    """
    plunging = np.cos(altitude) < 0
    facing = np.where(plunging, math.pi - altitude, altitude)
    ahead = tilted(az_south, facing, xi, zeta)
    behind = tilted(az_south, facing, -xi, -zeta)
    turn, reads = np.where(plunging, behind, ahead)
    return turn, altitude + (reads - facing)


def feasible(
    tilt: Tilt = tilted_over_the_shoulder, refraction_name: str = DEFAULT_REFRACTION
) -> Feasibility:
    """Find the parameters that reproduce every printed number, or how far the best ones miss.

    Parameters
    ----------
    tilt
        How the tilt acts; :func:`pyport.pointing.exact.tilted` for the routine as printed.
    refraction_name
        The refraction in the zenith-distance offsets.
    """
    from scipy.optimize import linprog

    blocks = published()
    systems = [_inequalities(block, tilt, refraction_name) for block in blocks]
    matrix = np.concatenate([system[0] for system in systems])
    bound = np.concatenate([system[1] for system in systems])
    where = [
        (block.name, float(az), float(zd))
        for block in blocks
        for az, zd in [*zip(block.az_deg, block.zd_deg, strict=True)] * 2
    ]
    half = PRINTED_ROUNDING / _UNIT
    box = [(-half, half)] * 12
    # a last column lets every number out by as much; as little of it as possible
    with_slack = np.column_stack([matrix, -np.ones(len(bound))])
    best = linprog(np.eye(13)[12], with_slack, bound, bounds=[*box, (0, None)])
    excess = float(best.fun)
    low = high = None
    if excess < 1e-9:
        low, high = (
            printed()
            + np.array(
                [linprog(sign * one, matrix, bound, bounds=box).x @ one for one in np.eye(12)]
            )
            * _UNIT
            for sign in (1, -1)
        )
    binding = tuple(where[i] for i in np.flatnonzero(np.abs(best.ineqlin.marginals) > 1e-6))
    return Feasibility(excess * _UNIT / DEG, printed() + best.x[:12] * _UNIT, low, high, binding)


def _inequalities(block: Block, tilt: Tilt, refraction_name: str) -> tuple[Array, Array]:
    """Return matrix (2n, 12) and bound (2n,), both for unknowns in `_UNIT` and offsets in it."""
    predicted = _prediction(block, tilt, refraction_name)
    here = predicted(printed())
    step = 10 * _UNIT
    slope = np.stack(
        [
            (predicted(printed() + step * one) - predicted(printed() - step * one)) / 20
            for one in np.eye(12)
        ],
        axis=1,
    )
    half_deg = block.unit_deg / 2 + _grid_deg(block) / 2
    room = (block.printed * block.unit_deg - here) * DEG / _UNIT
    half = half_deg * DEG / _UNIT
    return np.concatenate([slope, -slope]) * DEG / _UNIT, np.concatenate([room + half, half - room])


def _prediction(block: Block, tilt: Tilt, refraction_name: str) -> Callable[[Array], Array]:
    """Return the block's numbers [deg] as a function of p1..p12 [rad]; arguments are REAL*4."""
    wrapped = np.array([wrapped_deg(az) for az in block.az_deg])
    az, alt = (
        (degrees * DEG).astype(np.float32).astype(float) for degrees in (wrapped, 90 - block.zd_deg)
    )
    lift_deg = refraction4(refraction_name, block.zd_deg).astype(float)

    def predicted(p: Array) -> Array:
        d_az, d_alt = formulae(az, alt, p, tilt)
        if block.quantity.endswith("_difference"):
            rough_az, rough_alt = approximate_offsets(az, alt, p)
            d_az, d_alt = rough_az - d_az, rough_alt - d_alt
            return (d_az if block.quantity.startswith("d_az") else -d_alt) / DEG
        return d_az / DEG if block.quantity == "d_az" else -d_alt / DEG - lift_deg

    return predicted


def _grid_deg(block: Block) -> Array:
    """Return the step of the REAL*4 grid [deg] on which an azimuth was rounded, else 0."""
    if not block.quantity.startswith("d_az"):
        return np.zeros(len(block.printed))
    at = block.az_deg, block.zd_deg, printed(), DEFAULT_REFRACTION, "as-written"
    d_az_deg, _ = rt32_offsets(*at, exact=True)
    return np.where(np.rint(d_az_deg * 2**15) == d_az_deg * 2**15, 2.0**-15, 0.0)
