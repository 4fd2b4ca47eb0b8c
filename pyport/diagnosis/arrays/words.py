"""An array's report in words and tables, for the terminal."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np

from pyport.angles import ARCMIN, HOUR
from pyport.diagnosis.arrays.places import Comparison, Places
from pyport.diagnosis.arrays.record import SECOND
from pyport.diagnosis.arrays.report import SCAN, ArrayReport, Session
from pyport.diagnosis.arrays.unseen import FACTOR, Unseen, medians

_WIDTH = 96
#: A session whose leans are told worse than this many times the best one's is a weak one.
WEAK = 2.0


def words(found: ArrayReport) -> str:
    """Return the report as plain text."""
    antennas, sessions = len(found.parts.antennas), len(found.parts.sessions)
    lines = [
        f"The array: {antennas} antennas in {sessions} session{'s' * (sessions > 1)}.",
        *_sessions(found.sessions),
        *_repeats(found),
    ]
    if found.places is not None:
        lines += _places(found.places, several=sessions > 1)
    if found.comparison is not None and found.places is not None:
        lines += comparison(found.comparison, found.places.radius_m)
    if found.unseen is not None:
        lines += held_out(found.unseen)
    return "\n".join(lines)


def _sessions(sessions: Sequence[Session]) -> list[str]:
    """Return a table of what each session's antennas share."""
    lines = [
        "What a session's antennas share (of the clock only changes between sessions mean anything):",
        f"  {'session':12} {'antennas':8}  {'hour angles':13}  {'time tag of scans':18}  clock",
    ]
    for one in sessions:
        hours = "" if one.hours is None else "{:+.1f} to {:+.1f} h".format(
            *(hour / HOUR for hour in one.hours)
        )
        tag = "" if one.tag is None else "{:+.2f} +- {:.2f} s".format(*one.tag)
        clock = "" if one.clock is None else "{:+.2f} +- {:.2f} s".format(
            *(part / SECOND for part in one.clock)
        )
        lines.append(f"  {one.name:12} {one.antennas:8d}  {hours:15}  {tag:18}  {clock}".rstrip())
    best = min(one.sigma for one in sessions)
    for one in sessions:
        if one.sigma > WEAK * best:
            lines += _wrapped(
                f"  {one.name} by itself tells a lean toward east to {one.sigma / ARCMIN:.2f} arcmin "
                f"only, {one.sigma / best:.1f} times worse than the best session: over its hour "
                f"angles zero and sag look so much like a lean that they widen its error "
                f"{one.inflation:.1f} times."
            )
    return lines


def _repeats(found: ArrayReport) -> list[str]:
    """Return whether own parts repeat, shape by shape."""
    if not found.repeats:
        return []
    lines = [
        "What each antenna has of its own, each session predicted by the others:",
        f"  {'':18} {'session':12} {'own rms':>8} {'left':>6} {'by errors':>10} "
        f"{'correlation':>12} {'p':>8}  common part",
    ]
    for name, days in found.repeats.items():
        for day in days:
            if name == SCAN and found.rate:
                common = f"{day.common / found.rate:+.2f} +- {day.common_sigma / found.rate:.2f} s"
            else:
                common = f"{day.common / ARCMIN:+.2f} +- {day.common_sigma / ARCMIN:.2f}'"
            lines.append(
                f"  {name:18} {day.session:12} {day.size / ARCMIN:7.2f}' {day.left / ARCMIN:5.2f}' "
                f"{day.noise / ARCMIN:9.2f}' {day.correlation:12.2f} {day.p_value:8.1e}  {common}"
            )
    moved = ", ".join(
        f"{shape.name} {scatter / ARCMIN:.2f}'"
        for shape, scatter in zip(found.shapes, found.parts.scatter, strict=True)
    )
    return [*lines, *_wrapped(f"  From session to session an antenna's own part moves by: {moved}.")]


def _places(found: Places, *, several: bool) -> list[str]:
    """Return the implied displacements."""
    lines = [
        "Where these recordings say the antennas stand, metres toward east of the median antenna",
        "(an hour angle met early and a vertical leaning east are one curve, whatever the source: a",
        f"mount that leans of its own by 1 arcmin looks like {found.radius_m * ARCMIN:.0f} m):",
    ]
    order = np.flatnonzero(found.usable)
    told = [
        f"{found.antennas[n]:>6} {found.east_m[n]:+7.0f} +-{found.sigma_m[n]:5.0f}" for n in order
    ]
    lines += ["  " + "  ".join(told[n : n + 4]) for n in range(0, len(told), 4)]
    poor = [
        f"{found.antennas[n]} {found.east_m[n]:+.0f} +- {found.sigma_m[n]:.0f}"
        for n in np.flatnonzero(~found.usable)
    ]
    if poor:
        lines += _wrapped(
            f"  Not used, told more than three times worse than is usual: {', '.join(poor)}."
        )
    if not several:
        lines.append("  One session: that leans last cannot be tested, their errors are the least.")
    return lines


def comparison(found: Comparison, radius_m: float) -> list[str]:
    """Return what a survey says."""
    within = [float(np.mean(np.abs(found.misses) <= n)) for n in (1, 2)]
    lines = [
        f"Beside the survey ({len(found.antennas)} antennas): correlation {found.correlation:.3f}, "
        f"implied over surveyed {found.slope:.3f} +- {found.slope_sigma:.3f}.",
        f"  Each mount leans by {found.lean_m / radius_m / ARCMIN:.2f} arcmin of its own "
        f"({found.lean_m:.0f} m): with that in the errors",
        f"  {within[0]:.0%} of the antennas lie within one sigma of the line, {within[1]:.0%} within "
        f"two, {np.sqrt(np.mean(found.misses**2)):.2f} sigma rms.",
        f"  Each antenna from the line of all others: {found.unseen_m[0]:.0f} -> "
        f"{found.unseen_m[1]:.0f} m rms.",
    ]
    if found.is_the_site:
        lines.append("  The leans grow with the distance as displacements do: site_longitude.")
    else:
        lines.append("  The leans do not grow with the distance as displacements would.")
    if found.missing:
        lines += _wrapped(f"  Not in the survey: {', '.join(found.missing)}.")
    return lines


def held_out(found: Unseen) -> list[str]:
    """Return how whole antenna-days were predicted, and what went wrong."""
    lines = [
        "Each antenna's session predicted from its other sessions and the session's other antennas,",
        "only its zero refitted; rms of the median antenna, the model's form -> the array's parts:",
        f"  {'session':12} {'antennas':8}  {'held out':16} {'factor':>6} {'by 2':>5}   "
        f"{'in the fit':16} {'factor':>6}",
    ]
    for name in found.sessions:
        days = found.of(name)
        one = medians(days)
        lines.append(
            f"  {name:12} {len(days):8d}  {one.before / ARCMIN:5.2f}' -> {one.after / ARCMIN:5.2f}' "
            f"{one.factor:6.2f} {one.enough:5d}   {one.fitted_before / ARCMIN:5.2f}' -> "
            f"{one.fitted_after / ARCMIN:5.2f}' {one.fitted_factor:6.2f}"
        )
    reasons: dict[str, list[str]] = {}
    for day in found.days:
        if day.why:
            told = f"{day.antenna} {day.session} {day.before / ARCMIN:.2f}'->{day.after / ARCMIN:.2f}'"
            reasons.setdefault(day.why, []).append(told)
    for antenna, session, reason in found.unpredicted:
        reasons.setdefault(reason, []).append(f"{antenna} {session}")
    if reasons:
        lines.append(f"  By less than {FACTOR:g}, and why:")
    for reason, days in sorted(reasons.items(), key=lambda item: -len(item[1])):
        lines += _wrapped(f"  - {reason}: {', '.join(days)}.")
    return lines


def _wrapped(line: str) -> list[str]:
    indent = " " * (len(line) - len(line.lstrip()) + 2)
    return textwrap.wrap(line, _WIDTH, subsequent_indent=indent, drop_whitespace=True)
