"""Which program printed the published digits: arguments converted, or all promoted to REAL*8.

The six rows of the table that are printed in full tell. Where the program took a turn off a REAL*4
offset, the answer is a multiple of 2**-15 deg (see wrap-in-single in the ledger); whether it had to
depends on the azimuth that the routine was called with. Each hypothesis is tried with every set of
parameters that prints as Model3 was printed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport import legacy
from pyport.angles import DEG, Array
from pyport.pointing import PARAMETERS, exact_offsets, printed
from pyport.pointing.parameters import PRINTED_ROUNDING
from pyport.steering.as_written import wrapped_deg
from pyport.steering.published import full_rows

#: Distance of neighbouring REAL*4 between 256 and 512 deg.
STEP_DEG = 2.0**-15


@dataclass(frozen=True)
class Hypothesis:
    """One program and way of calling it, tried on the six rows.

    Attributes
    ----------
    name
        The program and the azimuth it was called with.
    answers_deg
        What it answers with the parameters as printed, shape (6,).
    coarse
        Rows whose answer is a multiple of ``STEP_DEG`` because a turn was taken off, shape (6,).
    off_grid_deg
        How far the printed numbers of the coarse rows are from such a multiple, at most.
    violation_deg
        How far some printed number stays from what it would print, whatever the parameters within
        the rounding of the printed ones; 0 or less when there are parameters that print all six.
    """

    name: str
    answers_deg: Array
    coarse: NDArray[np.bool_]
    off_grid_deg: float
    violation_deg: float


def hypotheses() -> list[Hypothesis]:
    """Try the promoted program, and the converted one with azimuth as printed and reduced."""
    az_deg = full_rows()[0].az_deg
    reduced_deg = np.array([wrapped_deg(one) for one in az_deg])
    return [
        _try("every REAL*4 promoted to REAL*8", az_deg, promoted=True),
        _try("arguments converted, azimuth as in the table", az_deg),
        _try("arguments converted, azimuth reduced to ±180 deg", reduced_deg),
    ]


def printed_rows() -> tuple[Array, Array, Array]:
    """Return azimuth, zenith distance and azimuth offset [deg] of the six rows."""
    block = full_rows()[0]
    return block.az_deg, block.zd_deg, np.asarray(block.printed * block.unit_deg, dtype=float)


def _try(name: str, az_deg: Array, *, promoted: bool = False) -> Hypothesis:
    _, zd_deg, numbers = printed_rows()
    smooth = _exact(az_deg, zd_deg, printed())
    coarse = np.zeros(len(numbers), dtype=bool)
    answers = smooth
    if not promoted:
        p_deg = np.array([float(one.printed_deg) for one in PARAMETERS])
        az, alt, p = map(np.float32, (az_deg * DEG, (90 - zd_deg) * DEG, p_deg))
        answers = np.array([legacy.model(*at, p)[0] for at in zip(az, alt, strict=True)], float)
        coarse = answers / STEP_DEG == np.rint(answers / STEP_DEG)
    off_grid = np.abs(numbers - STEP_DEG * np.rint(numbers / STEP_DEG))[coarse]
    tolerance = 0.5e-7 + np.where(coarse, STEP_DEG / 2, 0)
    violation = _least_violation(az_deg, zd_deg, numbers - smooth, tolerance)
    return Hypothesis(name, answers, coarse, float(off_grid.max(initial=0)), violation)


def _exact(az_deg: Array, zd_deg: Array, p: Array) -> Array:
    """Return the azimuth offset [deg] without any rounding to REAL*4."""
    return exact_offsets(az_deg * DEG, (90 - zd_deg) * DEG, p)[0] / DEG


def _least_violation(az_deg: Array, zd_deg: Array, residual: Array, tolerance: Array) -> float:
    """Return the least excess of |residual - J dp| over `tolerance` [deg], dp within its rounding.

    A linear programme: the parameters may move by half a unit of their last printed digit, over
    which the model is as good as linear.
    """
    from scipy.optimize import linprog

    moves = PRINTED_ROUNDING * np.eye(len(PARAMETERS))
    slopes = [
        (_exact(az_deg, zd_deg, printed() + move) - _exact(az_deg, zd_deg, printed() - move)) / 2
        for move in moves
    ]
    jacobian = np.array(slopes).T  # per half a unit, so that each unknown lies within -1..1
    scale = 1e-7
    excess = -np.ones((len(residual), 1))
    result = linprog(
        c=[*np.zeros(len(PARAMETERS)), 1],
        A_ub=np.block([[jacobian / scale, excess], [-jacobian / scale, excess]]),
        b_ub=np.concatenate([tolerance + residual, tolerance - residual]) / scale,
        bounds=[(-1, 1)] * len(PARAMETERS) + [(None, None)],
    )
    return float(result.x[-1] * scale)
