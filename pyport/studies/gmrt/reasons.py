"""Why a refit and Table 18 differ, as far as the recordings tell."""

from __future__ import annotations

import numpy as np

from pyport.angles import ARCMIN, HOUR
from pyport.studies.gmrt.beside import RMS_RATIO, SIGMAS, Beside, Day

#: The kinds of refit that are shown, and how they are called in a reason.
SHOWN = {"together": "in one curve", "apart": "apart", "continued": "continued"}

_TOO_LITTLE = "too little is left to tell how it went on"


def reasons(day: Day) -> list[str]:
    """Return a line for everything that differs on a day, nothing where all agree."""
    lines = []
    for one in day.antennas:
        name = one.track.antenna
        if any((sigmas > SIGMAS).any() for kind, sigmas in one.sigmas.items() if kind in SHOWN):
            told = ", ".join(
                f"{SHOWN[kind]} {_slashed(one, kind)}" for kind in SHOWN if kind in one.sigmas
            )
            lines.append(f"{name}: {told} sigmas: {_of_coefficients(day, one)}")
        if one.rms_ratio > RMS_RATIO:
            lines.append(f"{name}: {_of_rms(day, one)}")
    return lines


def _slashed(one: Beside, kind: str) -> str:
    """Return by how many combined sigmas a, b and d differ."""
    return "/".join(f"{sigma:.1f}" for sigma in one.sigmas[kind])


def _of_coefficients(day: Day, one: Beside) -> str:
    """Return why coefficients differ."""
    few = _few(day, one)
    if day.hours is None or one.continued is None or one.stretches is None:
        return few or _TOO_LITTLE
    scanned = day.hours.scanned
    apart, continued = (
        float(np.sqrt(np.mean((curve(scanned) - one.published(scanned)) ** 2)))
        for curve in (one.apart.cosine, one.continued)
    )
    within = {kind: bool((sigmas <= SIGMAS).all()) for kind, sigmas in one.sigmas.items()}
    if within["continued"] and continued < apart:
        return (
            f"hours lost in print (over all hours {apart / ARCMIN:.1f}' rms from Table 18's curve, "
            f"continued {continued / ARCMIN:.1f}')"
        )
    if within["stretches"]:
        larger = np.sqrt(one.stretches.covariance[0, 0] / one.continued.covariance[0, 0])
        few = f"{few}; " if few else ""
        return (
            f"few scans decide ({few}leaving out stretches makes the sigma of a {larger:.1f} times "
            f"the formal one, {_slashed(one, 'stretches')} sigmas)"
        )
    return few or "not explained"


def _few(day: Day, one: Beside) -> str:
    """Return what an antenna lacks where it lacks a third of the day's scans, "" elsewhere."""
    track = one.track
    if day.hours is None or 3 * len(track) > 2 * len(day.hours.left):
        return ""
    forward = int((track.direction > 0).sum())
    return (
        f"{forward} forward and {len(track) - forward} reverse scans are left of "
        f"{len(day.hours.left)} on the day, the last at {track.hour_angle[-1] / HOUR:+.1f} h"
    )


def _of_rms(day: Day, one: Beside) -> str:
    """Return why the published curve leaves more than the refit."""
    told = f"Table 18's curve leaves {one.rms_ratio:.2f} times the rms"
    if one.continued is None:
        return f"{told}: {_few(day, one) or _TOO_LITTLE}"
    told += f", the continued one {one.rms_continued / one.rms_refit:.2f} times"
    if one.rms_published <= RMS_RATIO * one.rms_continued:
        return f"{told}: what is best over all hours is no better on those left"
    return f"{told}: not explained by the hours"
