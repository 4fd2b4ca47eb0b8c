"""An array's report in words and tables, for the terminal."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.angles import ARCMIN, ARCSEC, HOUR
from pyport.diagnosis.arrays.blocks import Block, blocks
from pyport.diagnosis.arrays.places import Comparison, Places
from pyport.diagnosis.arrays.repeat import FACTOR, UnseenDays, medians, unseen_days
from pyport.diagnosis.arrays.report import SCAN, ArrayReport, Session, number_of, shared_shapes
from pyport.diagnosis.case import Problem
from pyport.diagnosis.joint import Joint
from pyport.runs.workers import one_thread

_WIDTH = 96
#: Radians of hour angle in a second of time.
SECOND = 15 * ARCSEC
#: A session that by itself tells leans worse than the best one by this factor is a weak one.
WEAK = 2.0
#: Longer lists are cut short here; the report has them whole.
_SHOWN = 30


def words(found: ArrayReport) -> str:
    """Return the report as plain text."""
    antennas, sessions = len(found.parts.antennas), len(found.parts.sessions)
    lines = [f"The array: {antennas} antennas in {sessions} session{'s' * (sessions > 1)}."]
    lines += _sessions(found)
    lines += _own(found)
    lines += _repeats(found)
    if found.places is not None:
        lines += _places(found.places, several=sessions > 1)
    if found.comparison is not None and found.places is not None:
        lines += comparison(found.comparison, found.places.radius_m)
    if found.unseen is not None:
        lines += held_out(found.unseen)
    return "\n".join(lines)


def _sessions(found: ArrayReport) -> list[str]:
    """Return a table of what each session's antennas share, and which sessions are weak."""
    # A lean that all antennas have in common is a clock's error as well: only its changes tell.
    clocks = [one.clock[0] for one in found.sessions if one.clock]
    usual = float(np.mean(clocks)) if len(clocks) > 1 else None
    head = f"{'session':12} {'antennas':8}  {'hour angles':15}  {'time tag of scans':18}"
    beside = "  clock, less its mean" if usual is not None else ""
    lines = [
        "What a session's antennas share, beside what was found:",
        f"  {head}{beside}".rstrip(),
    ]
    for one in found.sessions:
        hours = "{:+.1f} to {:+.1f} h".format(*(h / HOUR for h in one.hours)) if one.hours else ""
        tag = _seconds(*one.tag) if one.tag else ""
        clock = ""
        if one.clock is not None and usual is not None:
            clock = _seconds((one.clock[0] - usual) / SECOND, one.clock[1] / SECOND)
        lines.append(f"  {one.name:12} {one.antennas:8d}  {hours:15}  {tag:18}  {clock}".rstrip())
    if found.tag_level is not None:
        lines += _wrapped(
            f"  The level of the time tags holds to +- {found.tag_level:.2f} s, if the antennas' "
            "play is as often one way as the other; their changes are known better."
        )
    best = min(one.sigma for one in found.sessions)
    return [*lines, *(line for one in found.sessions for line in _weak(one, best))]


def _seconds(value: float, sigma: float) -> str:
    return f"{value:+.2f} +- {sigma:.2f} s"


def _weak(one: Session, best: float) -> list[str]:
    """Explain why a session by itself says little of leans; nothing of the others."""
    if one.sigma <= WEAK * best:
        return []
    return _wrapped(
        f"  {one.name} by itself tells a lean toward east only to {one.sigma / ARCMIN:.2f} arcmin, "
        f"{one.sigma / best:.1f} times worse than the best session: over its hour angles zero and "
        f"sag look so much like a lean that they widen its error {one.inflation:.1f} times."
    )


def _own(found: ArrayReport) -> list[str]:
    """Return each antenna's own difference between scans up and down."""
    scan = number_of(found.shapes, SCAN)
    if scan is None:
        return []
    parts = found.parts
    sigma = np.sqrt(np.diag(parts.own_covariance(scan)))
    cells = [
        f"{name:>6} {value / ARCMIN:+6.2f} +- {error / ARCMIN:4.2f}"
        for name, value, error in zip(parts.antennas, parts.own[:, scan], sigma, strict=True)
    ]
    return ["Each antenna's own half-difference between scans up and down [arcmin]:", *_rows(cells)]


def _rows(cells: Sequence[str]) -> list[str]:
    """Set short texts in rows of four."""
    return ["  " + "  ".join(cells[n : n + 4]) for n in range(0, len(cells), 4)]


def _repeats(found: ArrayReport) -> list[str]:
    """Return whether own parts repeat, shape by shape."""
    if not found.repeats:
        return []
    lines = ["Do own parts repeat? Those of each session, beside those of all other sessions:"]
    lines.append(
        f"  {'':18} {'session':12} {'own rms':>8} {'left':>6} {'by errors':>10} "
        f"{'correlation':>12} {'p':>8}  common part"
    )
    for name, days in found.repeats.items():
        for day in days:
            common = f"{day.common / ARCMIN:+.2f} +- {day.common_sigma / ARCMIN:.2f}'"
            if name == SCAN and found.rate:
                common = _seconds(day.common / found.rate, day.common_sigma / found.rate)
            lines.append(
                f"  {name:18} {day.session:12} {day.size / ARCMIN:7.2f}' {day.left / ARCMIN:5.2f}' "
                f"{day.noise / ARCMIN:9.2f}' {day.correlation:12.2f} {day.p_value:8.1e}  {common}"
            )
    moved = ", ".join(
        f"{shape.name} {scatter / ARCMIN:.2f}'"
        for shape, scatter in zip(found.shapes, found.parts.scatter, strict=True)
    )
    return [
        *lines,
        *_wrapped(f"  From session to session an antenna's own part moves by: {moved}."),
    ]


def _places(found: Places, *, several: bool) -> list[str]:
    """Return the implied displacements."""
    lines = ["Where these recordings say the antennas stand, metres toward east of the median one:"]
    cells = [
        f"{name:>6} {east:+7.0f} +-{sigma:5.0f}"
        for name, east, sigma, usable in zip(
            found.antennas, found.east_m, found.sigma_m, found.usable, strict=True
        )
        if usable
    ]
    lines += _rows(cells)
    poor = ", ".join(
        f"{found.antennas[n]} {found.east_m[n]:+.0f} +- {found.sigma_m[n]:.0f}"
        for n in np.flatnonzero(~found.usable)
    )
    if poor:
        lines += _wrapped(f"  Not used, their errors are three times the usual or more: {poor}.")
    lines += _wrapped(
        "  An hour angle met early and a vertical leaning east are one curve, whatever the source: "
        f"a mount that leans by 1 arcmin of its own looks like {found.radius_m * ARCMIN:.0f} m."
    )
    if not several:
        lines.append("  One session: that leans last cannot be tested, their errors are the least.")
    return lines


def comparison(found: Comparison, radius_m: float) -> list[str]:
    """Return what a survey says."""
    one, two = (f"{np.mean(np.abs(found.misses) <= n):.0%}" for n in (1, 2))
    rest = f"({found.correlation_of_all:.3f} with those not used)"
    slope = f"{found.slope:.3f} +- {found.slope_sigma:.3f}"
    lean = f"{found.lean_m / radius_m / ARCMIN:.2f} arcmin of its own ({found.lean_m:.0f} m)"
    rms = f"{np.sqrt(np.mean(found.misses**2)):.2f} sigma rms"
    before, after = found.unseen_m
    grow = "grow with the distance as displacements do: site_longitude"
    verdict = grow if found.is_the_site else "do not grow with the distance as displacements would"
    lines = [f"Beside the survey, {len(found.antennas)} antennas:"]
    lines.append(f"  correlation {found.correlation:.3f} {rest}, implied over surveyed {slope}.")
    lines += _wrapped(
        f"  Each mount leans by {lean}: with that in the errors {one} of the antennas lie within "
        f"one sigma of the line, {two} within two, {rms}."
    )
    lines.append(f"  Each antenna from the line of all others: {before:.0f} -> {after:.0f} m rms.")
    lines.append(f"  The leans {verdict}.")
    if found.missing:
        lines += _wrapped(f"  Not in the survey: {', '.join(found.missing)}.")
    return lines


def held_out(found: UnseenDays) -> list[str]:
    """Return how whole antenna-days were predicted, and what went wrong."""
    lines = _wrapped(
        "Each antenna's session predicted from its other sessions and the session's other "
        "antennas, only its zero refitted; rms of the median antenna, the model's form -> the "
        "array's parts:"
    )
    lines.append(
        f"  {'session':12} {'antennas':8}  {'held out':16} {'factor':>6} {'by 2':>5}   "
        f"{'in the fit':16} {'factor':>6}"
    )
    for name in found.sessions:
        days = found.of(name)
        one = medians(days)
        held, fitted = (
            f"{before / ARCMIN:5.2f}' -> {after / ARCMIN:5.2f}'"
            for before, after in ((one.before, one.after), (one.fitted_before, one.fitted_after))
        )
        lines.append(
            f"  {name:12} {len(days):8d}  {held:16} {one.factor:6.2f} {one.enough:5d}   "
            f"{fitted:16} {one.fitted_factor:6.2f}"
        )
    reasons: dict[str, list[str]] = {}
    for day in found.days:
        if day.why:
            size = f"{day.before / ARCMIN:.2f}'->{day.after / ARCMIN:.2f}'"
            moved = f" ({day.detail})" if day.detail else ""
            reasons.setdefault(day.why, []).append(f"{day.antenna} {day.session} {size}{moved}")
    for antenna, session, reason in found.unpredicted:
        reasons.setdefault(reason, []).append(f"{antenna} {session}")
    if reasons:
        lines.append(f"  By less than {FACTOR:g}, and why:")
    for reason, listed in sorted(reasons.items(), key=lambda item: -len(item[1])):
        more = f" and {len(listed) - _SHOWN} more" if len(listed) > _SHOWN else ""
        lines += _wrapped(f"  - {reason}: {', '.join(listed[:_SHOWN])}{more}.")
    return lines


def _wrapped(line: str) -> list[str]:
    indent = " " * (len(line) - len(line.lstrip()) + 2)
    return textwrap.wrap(line, _WIDTH, subsequent_indent=indent, drop_whitespace=True)


@one_thread
def predict(known: ArrayReport, problem: Problem, fit: Joint) -> UnseenDays:
    """Predict other recordings of an array from recordings that are known.

    Own parts come from the known recordings alone, what a session's antennas
    share from its other antennas; zeros are fitted anew, on either side of
    every step that was found in the other recordings.

    Parameters
    ----------
    known
        What is known of the array.
    problem, fit
        The case of the recordings to predict, by the same model, and the fit of all found in it.
    """
    taken, stem = set(known.parts.sessions), problem.recordings.file.stem
    fitted, others = (
        _renamed(blocks(problem, fit, some), taken, stem) for some in (known.form, known.shapes)
    )
    return unseen_days(
        [*known.fitted, *fitted],
        [*known.blocks, *others],
        known.shapes,
        shared_shapes(known.shapes),
        sessions={one.session for one in others},
    )


def _renamed(some: Sequence[Block], taken: set[str], stem: str) -> list[Block]:
    """Return blocks whose sessions are called unlike those taken."""
    return [
        replace(one, session=f"{stem} {one.session}".strip()) if one.session in taken else one
        for one in some
    ]
