"""A simulated stand-in for the RT32's offsets of 2003 and 2004, which were never published.

The published numbers of rows by axis, the two seasons, all of Model3, the step
of the beam between them, and bad measurements of the two kinds that the
document tells of: single ones, and whole sequences that are off together.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array
from pyport.examiner.worlds.campaign import Noise, unix
from pyport.examiner.worlds.case import Case, Streams, finish, hide
from pyport.examiner.worlds.observatories import (
    RT32_ALTITUDE_ROWS,
    RT32_AZIMUTH_ROWS,
    rt32_plan,
    rt32_whole,
)
from pyport.examiner.worlds.schedule import Plan

#: What stands in the header of the file, for every reader and every figure.
LABEL = "made by pyport dev trials, no telescope measured this"

#: Box offset of 2003 minus that of 2004 [rad].
BOX_STEP = 0.017 * DEG

#: Share of the rows in sequences that are off together, their length, and by how much [rad].
_SEQUENCES_SHARE = 0.2
_SEQUENCE_ROWS = (15, 60)
_SEQUENCE_OFFSETS = (27 * ARCSEC, 60 * ARCSEC)

#: With these about two thirds of the rows are within 0.007 deg, of rms 12.8 arcsec.
_SIGMA = 17.5 * ARCSEC


def rt32_campaign(seed: int, rows: int = RT32_ALTITUDE_ROWS + RT32_AZIMUTH_ROWS) -> Case:
    """Make the RT32's two campaigns.

    The truth keeps, row by row, what each offset is off by, under "error_arcsec".
    """
    streams = Streams.of(seed)
    plan = rt32_plan(streams.plan, rows)
    across, up = _sequences(streams.fault, plan)
    world = replace(rt32_whole(plan), across=across, up=up).with_mount(
        beam_left=np.where(plan.time_s < unix(2004, 1, 1), BOX_STEP, 0.0)
    )
    # a tenth of the noise wanders through the session, and there are single bad rows
    noise = Noise(
        _SIGMA, _SIGMA, drift_share=0.06, memory_s=3600.0, outlier_share=0.05, step=ARCSEC
    )
    hidden = hide(world, [], None, noise)
    about = {"kind": "rt32-campaign", "seed": seed, "box_step_deg": BOX_STEP / DEG}
    case = finish(hidden, streams, about, azimuth_zero="south")
    error = _errors(case, across, up)
    return replace(
        case,
        header={"simulated": LABEL, **case.header},
        truth={**case.truth, "error_arcsec": (error / ARCSEC).round(3).tolist()},
    )


def _sequences(rng: np.random.Generator, plan: Plan) -> tuple[Array, Array]:
    """Return offsets across and up [rad] of sequences that are off together, zero elsewhere."""
    across, up = np.zeros((2, len(plan)))
    off: NDArray[np.bool_] = np.zeros(len(plan), bool)
    while off.mean() < _SEQUENCES_SHARE:
        start = int(rng.integers(len(plan)))
        rows = slice(start, start + int(rng.integers(*_SEQUENCE_ROWS)))
        sign = 1 if rng.random() < 0.5 else -1
        across[rows] = sign * rng.uniform(*_SEQUENCE_OFFSETS)
        up[rows] = -sign * rng.uniform(*_SEQUENCE_OFFSETS)
        off[rows] = True
    return across, up


def _errors(case: Case, across: Array, up: Array) -> Array:
    """Return what each row's offset is off by [rad], on the axis that it measures."""
    recorded_x = case.columns["d_az_deg"] * DEG * np.cos(case.columns["el_deg"] * DEG)
    recorded_y = case.columns["d_el_deg"] * DEG
    x, y = recorded_x - case.clean[0] + across, recorded_y - case.clean[1] + up
    return np.where(np.isnan(x), y, x)
