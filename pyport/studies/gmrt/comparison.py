"""Refits beside Table 18, in tables: how many agree, and why the rest do not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyport.angles import ARCMIN, DEG, HOUR
from pyport.studies.gmrt.curves import condition
from pyport.studies.gmrt.refits import (
    RMS_RATIO,
    SHOWN,
    SIGMAS,
    Day,
    Refit,
    printed_sigma_factors,
    reasons,
)

_UNITS = (ARCMIN, ARCMIN, DEG)
_HEADS = "".join(f"{head:18s}" for head in ("a [arcmin]", "b [arcmin]", "d [deg]"))

#: What the paper's curves of two days in a row say of their own sigmas.
_SAME_AGAIN = ("2003-06-01", "2003-06-02")


def text(days: Sequence[Day]) -> str:
    """Return both tables, each day's shares, the reasons, and what the printed sigmas are worth."""
    every = [one for day in days for one in day.antennas]
    parts = [_refits(every), _differences(every), *map(_day, days)]
    if set(_SAME_AGAIN) <= {day.session for day in days}:
        factors = printed_sigma_factors(*_SAME_AGAIN)
        cells = ", ".join(f"{name} {factor:.1f}" for name, factor in factors.items())
        parts.append(
            f"Table 18's sigmas are too small: from {' to '.join(_SAME_AGAIN)} its own a, b and d\n"
            f"change by this many of them (median, one if honest): {cells}"
        )
    return "\n\n".join(parts)


def _refits(found: Sequence[Refit]) -> str:
    """Return the refit's coefficients beside the published ones, and what either leaves."""
    lines = [
        f"{'':18s}{'refit':54s}{'Table 18':54s}rms [arcmin]   ratio",
        f"{'':18s}{_HEADS}{_HEADS}T. 18  refit   plain  per d.o.f.  condition",
    ]
    for one in found:
        wave = one.published
        printed = ((wave.a, wave.sigma_a), (wave.b, wave.sigma_b), (wave.d, wave.sigma_d))
        cells = "".join(map(_pair, (*one.together.polar(wave), *printed), _UNITS * 2))
        lines.append(
            f"{_who(one)} {cells}{one.rms_published / ARCMIN:5.2f}{one.rms_refit / ARCMIN:7.2f}"
            f"{one.rms_ratio:8.2f}{one.rms_ratio_per_freedom:12.2f}{one.condition:11.0f}"
        )
    return "\n".join(lines)


def _differences(found: Sequence[Refit]) -> str:
    """Return by how many combined sigmas each kind of refit differs from the published curve."""
    lines = [
        "By how many combined sigmas a, b and d differ from Table 18: forward and reverse in one",
        "curve (the refit above); apart; apart, and continued over the hours that the paper had",
        f"{'':16s}scans    " + "".join(f"{name:17s}" for name in SHOWN.values()) + f" {_HEADS}",
    ]
    for one in found:
        forward = int((one.track.direction > 0).sum())
        cells = "".join(
            "".join(f"{sigma:5.1f}" for sigma in one.sigmas[kind]) + "  "
            for kind in SHOWN
            if kind in one.sigmas
        )
        if one.continued is not None:
            cells += "".join(map(_pair, one.continued.polar(one.published), _UNITS))
        lines.append(f"{_who(one)}{forward:3d} +{len(one.track) - forward:3d} {cells}".rstrip())
    return "\n".join(lines)


def _pair(value_and_sigma: tuple[float, float], unit: float) -> str:
    value, sigma = value_and_sigma
    return f"{value / unit:7.2f} +-{min(sigma / unit, 180):6.2f}  "


def _day(day: Day) -> str:
    """Return how many of a day's antennas agree, and the reason for each of the rest."""
    lines = [f"{day.session}, {len(day.antennas)} antennas", *_hours(day)]
    lines.append(f"  Table 18's curve leaves at most {RMS_RATIO} times the refit's rms")
    for name, ratios in (
        ("per degree of freedom", [one.rms_ratio_per_freedom for one in day.antennas]),
        ("plain", [one.rms_ratio for one in day.antennas]),
    ):
        lines.append(f"    {name + ':':24s}{_share([ratio <= RMS_RATIO for ratio in ratios])}")
    lines.append(f"  a, b and d are within {SIGMAS:.0f} combined sigmas of Table 18")
    for kind, name in SHOWN.items():
        sigmas = np.array([one.sigmas[kind] for one in day.antennas if kind in one.sigmas])
        if len(sigmas):
            shares = ", ".join(_share(within) for within in (sigmas <= SIGMAS).T)
            lacking = len(day.antennas) - len(sigmas)
            rest = f"; {lacking} cannot be" if lacking else ""
            lines.append(f"    {name + ':':24s}{shares}{rest}")
    return "\n".join([*lines, *(f"  {line}" for line in reasons(day))])


def _hours(day: Day) -> list[str]:
    """Return what hours are left, what hours the paper had, and how it took the directions."""
    from scipy.stats import spearmanr

    if day.hours is None:
        return []
    left, scanned = day.hours.left, day.hours.scanned
    printed = [day.hours.scatter[one.track.antenna] for one in day.antennas]
    together, apart = (
        float(spearmanr(printed, rms).statistic)
        for rms in (
            [one.rms_refit for one in day.antennas],
            [one.apart.rms for one in day.antennas],
        )
    )
    first, last, end, low, high = (
        f"{hour / HOUR:+.1f} h" for hour in (left[0], left[-1], day.hours.ended, *day.hours.middle)
    )
    return [
        f"  left in print: {first} to {last}, condition number of a, b, d {condition(left):.0f}",
        f"  Table 18's sigmas, by their proportions, are of scans to {end} (two antennas in three",
        f"    say {low} to {high}), condition number {condition(scanned):.0f}",
        "  the scatter that they stand for has a rank correlation with that of the scans here",
        f"    of {apart:.2f}, forward and reverse apart, of {together:.2f}, both in one curve",
    ]


def _who(one: Refit) -> str:
    return f"{one.track.antenna:5s}{one.track.session:11s}"


def _share(good: Sequence[bool]) -> str:
    return f"{sum(good)} of {len(good)} ({np.mean(good):.0%})"
