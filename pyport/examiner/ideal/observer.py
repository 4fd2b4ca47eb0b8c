"""The ideal observer of a drawn case: it knows the form of the cause and the noise, not its size.

No tool of the same false-alarm rate detects more often: the most powerful test of a known form in
known noise compares its amplitude with its error (Kay 1998, Fundamentals of Statistical Signal
Processing II, ch. 7). The model's seven terms are fitted, as a tool fits them.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import solve_triangular
from scipy.stats import norm

from pyport.angles import ARCSEC, Array
from pyport.examiner.worlds.case import Case
from pyport.examiner.worlds.faults import CATALOGUED
from pyport.thresholds import FAMILY_ERROR

#: An encoder's step is this share of sigma in `worlds.campaign.usual_noise`; its rounding adds.
STEP = 0.2


def gain(case: Case) -> float:
    """Return the squared ratio of the true amplitude to its error: the expected gain beyond noise.

    Outliers are known to the observer and left out.
    """
    noise = case.truth["noise"]
    stamps = np.char.rstrip(case.columns["time_utc"].astype(str), "Z")
    time_s = stamps.astype("datetime64[ms]").astype(float) / 1000
    forms = zip(case.base, case.signature, ("az", "el"), ("xel", "el"), strict=True)
    white = []
    for columns, form, axis, name in forms:
        measured = np.isfinite(case.columns.get(f"d_{axis}_deg", np.full(len(time_s), np.nan)))
        both = np.concatenate([columns, form[:, None]], axis=1)[measured]
        sigma = noise[f"{name}_arcsec"] * ARCSEC
        unit = _covariance(time_s[measured], noise["drift_share"], noise["memory_s"])
        factor = np.linalg.cholesky(unit)
        white.append(solve_triangular(factor, both / sigma, lower=True, check_finite=False))
    stacked = np.concatenate(white)
    model, curve = stacked[:, :-1], stacked[:, -1]
    left = curve - model @ np.linalg.lstsq(model, curve, rcond=1e-9)[0]
    return float(left @ left) * (1 - noise["outlier_share"])


def possible(case: Case) -> float:
    """Return the chance that the observer detects a case's cause.

    It makes false alarms as often as the program and pays for all causes that are drawn.
    """
    return detection(gain(case), FAMILY_ERROR, len(CATALOGUED))


def _covariance(time_s: Array, drift_share: float, memory_s: float) -> Array:
    """Return the covariance of readings of unit variance, (n, n): white, wandering, rounded."""
    found = np.eye(len(time_s)) * (1 - drift_share + STEP**2 / 12)
    if drift_share > 0:
        apart = np.abs(time_s[:, None] - time_s)
        found += drift_share * np.exp(-apart / memory_s)
    return found


def detection(gain_: float, family_error: float, causes: int) -> float:
    """Return the chance to detect an amplitude at some rate of false alarms over many causes.

    `causes` forms are looked for, each with an equal part of the family's error: who does not know
    which of them is there pays for all.
    """
    each = -math.expm1(math.log1p(-family_error) / max(causes, 1))
    reach = float(norm.isf(each / 2))
    size = math.sqrt(gain_)
    return float(norm.sf(reach - size) + norm.cdf(-reach - size))
