"""Scans in a file to recordings: the paper's formulae, sign and unit made plain.

The axis moves at a constant rate and stands at the source's computed place at
the expected time. If power peaks at another time, the axis stood at
direction * rate * (observed - expected) from there: encoder minus true. The
GMRT paper (section 1) prints (expected - observed) * rate / 60 in degrees,
times cos El along azimuth: minutes, not hours as it says, and the direction's
sign left to the reader.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCMIN
from pyport.columns import SCAN_RATE, SCAN_RATE_UNIT, SET_ASIDE, TIME
from pyport.recordings.formats import csv
from pyport.recordings.interpret import interpret
from pyport.recordings.raw import Raw
from pyport.recordings.scans.beam import Peak, fit_peak
from pyport.recordings.schema import Recordings

#: Columns that tell one scan of one antenna's channel from another.
KEYS = ("session", "scan", "antenna", "channel")

POWER = "power"
EXPECTED = "expected_utc"
#: Error of the offset along the scan, until it is known across what.
SIGMA = "sigma_along_arcmin"

REQUIRED = ("scan", TIME, POWER, EXPECTED, "scan_axis", "scan_direction", SCAN_RATE)


def offset_along_scan(
    observed_s: float, expected_s: float, direction: float, rate_per_s: float
) -> float:
    """Return the offset of the scanned axis, encoder minus true, in the rate's unit of angle.

    `observed_s`, `expected_s`: when power peaked, and when the axis stood at the source's computed
      place [s].
    `direction`: +1 for a scan toward larger angles, -1 for one back.
    `rate_per_s`: angle per second, positive; of the axis, so along azimuth not yet times cos El.
    """
    return direction * rate_per_s * (observed_s - expected_s)


def measure(path: str | Path) -> Recordings:
    """Return one recording for each scan, antenna and channel of a file of samples.

    The file is a CSV with a row for each sample: `scan`, `time_utc`, `power`,
    and the same in all rows of a scan `expected_utc`, `scan_axis` (az or el),
    `scan_direction`, `scan_rate_arcmin_per_min`, besides `antenna`, `channel`
    and whatever else recordings may tell. Scans without a peak are excluded.

    Raises `BadInput`: with file and line: what is wrong and what was expected.
    """
    samples = csv.read(Path(path))
    for name in REQUIRED:
        if name not in samples.columns:
            raise samples.error(f"no column {name}, expected {', '.join(REQUIRED)}")
    time, power = samples.seconds(TIME), samples.numbers(POWER)
    first, member = _scans(samples)
    expected = samples.seconds(EXPECTED)[first]
    direction, rate = (samples.numbers(name)[first] for name in ("scan_direction", SCAN_RATE))
    axis = samples.words("scan_axis")[first]
    whole = Raw(samples.file, samples.meta, samples.header_line, {}, samples.line[first])
    whole.refuse(np.isnan(expected), f"{EXPECTED} is blank, expected a time")
    whole.refuse(np.abs(direction) != 1, "scan_direction is not +1 or -1")
    whole.refuse(~(rate > 0), f"{SCAN_RATE} is not positive")
    whole.refuse(~np.isin(axis, ("az", "el")), "scan_axis is not az or el")

    peaks = [
        fit_peak(time[member == number] - expected[number], power[member == number])
        for number in range(len(first))
    ]
    rate *= SCAN_RATE_UNIT / ARCMIN
    found = [
        (offset_along_scan(peak.time_s, 0.0, way, speed), speed * peak.sigma_s, "")
        if isinstance(peak, Peak)
        else (np.nan, np.nan, peak)
        for peak, way, speed in zip(peaks, direction, rate, strict=True)
    ]
    offset, sigma = (np.array([one[k] for one in found]) for k in range(2))
    columns = {n: c[first] for n, c in samples.columns.items() if n not in {TIME, POWER, EXPECTED}}
    columns |= {
        TIME: samples.columns[EXPECTED][first],
        "d_az_arcmin": np.where(axis == "az", offset, np.nan),
        "d_el_arcmin": np.where(axis == "el", offset, np.nan),
        SIGMA: sigma,
        SET_ASIDE: np.array([one[2] for one in found], np.str_),
    }
    return _with_sigmas(interpret(replace(whole, columns=columns)))


def _scans(samples: Raw) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first row of each scan, and which scan each row belongs to; refuse changes."""
    keys = np.stack([samples.words(key) for key in KEYS if key in samples.columns], axis=1)
    _, first, member = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    first, member = first[order], np.argsort(order)[member.reshape(-1)]
    for name in set(samples.columns) - {TIME, POWER}:
        cells = samples.words(name)
        changed = np.flatnonzero(cells != cells[first][member])
        if changed.size:
            raise samples.error(f"{name} changes within a scan, expected one value", changed[0])
    return first, member


def _with_sigmas(measured: Recordings) -> Recordings:
    """Return recordings with the errors along each scan moved to the scanned axis."""
    columns = dict(measured.at.columns)
    error = columns.pop(SIGMA) * ARCMIN
    along_az = columns["scan_axis"] == "az"
    return replace(
        measured,
        at=replace(measured.at, columns=columns),
        sigma_x=np.where(along_az, error * np.cos(measured.at.el), np.nan),
        sigma_y=np.where(along_az, np.nan, error),
    )
