"""The analysis in words and tables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyport.angles import ARCMIN, DEG
from pyport.studies.gmrt import places
from pyport.studies.gmrt.curves import Curve
from pyport.studies.gmrt.repetition import EAST, NAMED, Jumps, Mirror, Repeat


def forms(plain: Sequence[Curve], times_cos_el: Sequence[Curve]) -> str:
    """Return both functional forms of every antenna and day, side by side."""
    units = ("a [arcmin]", "b [arcmin]", "d [deg]")
    head = "  ".join(f"{name:16}" for name in units)
    lines = [
        f"{'':16}{'dEl = a + b cos(HA + d)':56}dEl cos El = a + b cos(HA + d)",
        f"{'':16}{head}    {head}   rms [']   cond",
    ]
    for one, other in zip(plain, times_cos_el, strict=True):
        lines.append(
            f"{one.track.antenna} {one.track.session}  {_wave(one)}  {_wave(other)}  "
            f"{one.rms / ARCMIN:6.2f}  {one.condition:5.0f}"
        )
    return "\n".join(lines)


def warnings(found: Sequence[Curve]) -> str:
    """Return what is wrong with the curves' fits, each sentence with the antennas and days."""
    of: dict[str, list[str]] = {}
    for curve in found:
        for sentence in curve.doubts:
            of.setdefault(sentence, []).append(f"{curve.track.antenna} {curve.track.session}")
    lines = [f"warning: {', '.join(names)}: {sentence}" for sentence, names in of.items()]
    return "\n".join(lines) or "every fit of a curve is sound"


def _wave(curve: Curve) -> str:
    return "  ".join(
        f"{value / unit:+6.2f} +-{min(sigma / unit, 999):6.2f}"
        for (value, sigma), unit in zip(curve.cosine.polar(), (ARCMIN, ARCMIN, DEG), strict=True)
    )


def site(times_cos_el: Sequence[Curve], dec: float, latitude: float) -> str:
    """Return what the curves say of the antennas' places, and where the paper's formulae err."""
    north, on = 3 * ARCMIN, 5 * ARCMIN
    true = places.wave_of_place(north, on, dec, latitude)
    printed = places.wave_as_printed(north, on, dec, latitude)
    lines = [
        "An antenna 3' further north and 5' further on in hour angle has by trigonometry",
        f"  a = {true.a / ARCMIN:.3f}', b = {true.b / ARCMIN:.3f}', d = {true.d / DEG:.1f} deg;",
        f"  the paper's formula gives d = {printed.d / DEG:.1f} deg. Its ratio is upside down, its",
        "  sign lost: d = atan(hour angle's part / -latitude's part).",
        "Without the factor cos El a displacement is no cosine of hour angle, so what is fitted",
        "depends on how far the scans reach. An antenna 7' further on in hour angle:",
    ]
    for hours in ((-3.75, 1.72), (-3.75, 3.75)):
        wave = places.wave_fitted_to_place(0.0, 7 * ARCMIN, dec, latitude, hours)
        lines.append(
            f"  from {hours[0]:+.2f} to {hours[1]:+.2f} h: a = {wave.a / ARCMIN:+.1f}', "
            f"b = {wave.b / ARCMIN:+.1f}', d = {wave.d / DEG:+.0f} deg"
        )
    lines += [
        "",
        "How far on in hour angle each antenna stands, from the odd part of its curve [']:",
    ]
    for antenna in sorted({curve.track.antenna for curve in times_cos_el}):
        own = [curve for curve in times_cos_el if curve.track.antenna == antenna]
        values = [places.further_on(curve.odd, dec, latitude) for curve in own]
        told = "  ".join(
            f"{curve.track.session[5:]}: {value / ARCMIN:+6.2f} +-{sigma / ARCMIN:5.2f}"
            for curve, (value, sigma) in zip(own, values, strict=True)
        )
        lines.append(f"  {antenna}  {told}")
    return "\n".join(lines)


def repeatability(found: Sequence[Repeat]) -> str:
    """Return which antennas repeat from day to day, and whether the paper's list agrees."""
    lines = [
        "antenna  levels relative to the first day [']                p        does it repeat?"
    ]
    for one in found:
        levels = "  ".join(
            f"{session[5:]}: {value / ARCMIN:+6.2f}" for session, (value, _) in one.level.items()
        )
        verdict = "yes" if one.repeats else f"no, {one.spread / ARCMIN:.1f}'"
        named = " (named by the paper)" if one.antenna in NAMED else ""
        lines.append(f"{one.antenna:7}  {levels:46}  {one.p_value:7.1e}  {verdict}{named}")
    moved = [one.antenna for one in found if not one.repeats]
    agreed = [antenna for antenna in NAMED if antenna in moved]
    others = [antenna for antenna in moved if antenna not in NAMED]
    lines.append(f"Of the five that the paper names {len(agreed)} do not repeat: {_list(agreed)}.")
    lines.append(f"Not named, and do not repeat either: {_list(others)}.")
    return "\n".join(lines)


def mirrors(found: Sequence[Mirror]) -> str:
    """Return whether the arms are mirror images."""
    lines = [
        "odd part of the curves, coefficient of sin HA [']; east below, west above zero if mirrored"
    ]
    for day in found:
        told = "  ".join(
            f"{antenna} {value / ARCMIN:+.1f} +-{sigma / ARCMIN:.1f}"
            for antenna, (value, sigma) in day.odd.items()
        )
        right, count = day.opposite
        lines.append(f"{day.session}: {told}")
        lines.append(f"  {right} of {count} bend as their arm does (by chance {day.chance:.3f})")
    means = {
        arm: np.mean([v for day in found for a, (v, _) in day.odd.items() if (a in EAST) == east])
        for arm, east in (("east", True), ("west", False))
    }
    lines.append("  mean " + ", ".join(f"{a} {v / ARCMIN:+.1f}'" for a, v in means.items()))
    return "\n".join(lines)


def jumps(found: Sequence[Jumps]) -> str:
    """Return whether offsets jump at transit."""
    lines = []
    for day in found:
        large = [
            f"{j.antenna} {j.step / ARCMIN:+.1f}'" for j in day.jumps if abs(j.step) > 3 * j.sigma
        ]
        lines.append(
            f"{day.session}: step at transit {day.mean / ARCMIN:+.2f} +- {day.sigma / ARCMIN:.2f}' "
            f"over {len(day.jumps)} antennas, p = {day.p_value:.2f}; beyond 3 sigma: {_list(large)}"
        )
    return "\n".join(lines)


def _list(names: Sequence[str]) -> str:
    return ", ".join(names) or "none"
