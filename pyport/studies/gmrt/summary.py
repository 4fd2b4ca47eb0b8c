"""The analysis in words and tables.

With sin E = sin(phi) sin(dec) + cos(phi) cos(dec) cos(h), an antenna that
stands dphi further north and dh further on in hour angle sees

    cos E dE = dphi cos(phi) sin(dec) - dphi sin(phi) cos(dec) cos h
               - dh cos(phi) cos(dec) sin h

so in a + b cos(h + d)

    a       =  dphi cos(phi) sin(dec)
    b cos d = -dphi sin(phi) cos(dec)
    b sin d =  dh cos(phi) cos(dec)

The paper prints the same a, b and its square root, but d = atan of (the
latitude's part / the hour angle's part): the reciprocal, without the sign.
That is the d of a sine, b sin(h + d), turned round; taken at its word it gives
away the latitude for the longitude.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyport.angles import ARCMIN, DEG, HOUR, Array
from pyport.recordings import sky
from pyport.studies.gmrt.curves import Curve, columns
from pyport.studies.gmrt.repetition import EAST, NAMED, Jumps, Mirror, Repeat


@dataclass(frozen=True)
class Wave:
    """The coefficients of a + b cos(h + d) for cos E times the elevation offset [rad]."""

    a: float
    b: float
    d: float

    def __call__(self, hour_angle: Array) -> Array:
        """Return a + b cos(h + d)."""
        return self.a + self.b * np.cos(hour_angle + self.d)


def wave_of_place(north: float, on: float, dec: float, latitude: float) -> Wave:
    """Return the curve of an antenna `north` further north and `on` further on in hour angle."""
    cosine = -north * np.sin(latitude) * np.cos(dec)
    minus_sine = on * np.cos(latitude) * np.cos(dec)
    a = north * np.cos(latitude) * np.sin(dec)
    return Wave(
        float(a), float(np.hypot(cosine, minus_sine)), float(np.arctan2(minus_sine, cosine))
    )


def wave_as_printed(north: float, on: float, dec: float, latitude: float) -> Wave:
    """Return the same by the paper's own formulae, to show that they differ."""
    of_latitude = np.sin(latitude) * np.cos(dec) * north
    of_hour_angle = np.cos(latitude) * np.cos(dec) * on
    a = np.cos(latitude) * np.sin(dec) * north
    d = np.arctan(of_latitude / of_hour_angle)
    return Wave(float(a), float(np.hypot(of_latitude, of_hour_angle)), float(d))


def further_on(sine: tuple[float, float], dec: float, latitude: float) -> tuple[float, float]:
    """Return how far on in hour angle an antenna stands, with its sigma [rad].

    From the odd part of its curve for cos E times the offset, -b sin d: what
    the encoder's zero adds (cos E, even in hour angle) does not reach it.
    """
    size = np.cos(latitude) * np.cos(dec)
    return float(-sine[0] / size), float(sine[1] / size)


def wave_fitted_to_place(
    north: float, on: float, dec: float, latitude: float, hours: tuple[float, float]
) -> Wave:
    """Return the plain form (dE, no cos E) fitted to a displaced antenna over some hours.

    dE of a displaced antenna is no cosine of hour angle. So a, b and d depend
    on the hour angles that they are fitted over, most for the ends of the arms.
    """
    hour_angle = np.linspace(*hours, 60) * HOUR
    _, computed = sky.horizon(hour_angle, np.full(60, dec), latitude)
    _, seen = sky.horizon(hour_angle + on, np.full(60, dec), latitude + north)
    a, cosine, sine = np.linalg.lstsq(columns(hour_angle), seen - computed, rcond=None)[0]
    return Wave(float(a), -float(np.hypot(cosine, sine)), float(np.arctan2(sine, -cosine)))


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
    true = wave_of_place(north, on, dec, latitude)
    printed = wave_as_printed(north, on, dec, latitude)
    lines = [
        "An antenna 3' further north and 5' further on in hour angle has by trigonometry",
        f"  a = {true.a / ARCMIN:.3f}', b = {true.b / ARCMIN:.3f}', d = {true.d / DEG:.1f} deg;",
        f"  the paper's formula gives d = {printed.d / DEG:.1f} deg. Its ratio is upside down, its",
        "  sign lost: d = atan(hour angle's part / -latitude's part).",
        "Without the factor cos El a displacement is no cosine of hour angle, so what is fitted",
        "depends on how far the scans reach. An antenna 7' further on in hour angle:",
    ]
    for hours in ((-3.75, 1.72), (-3.75, 3.75)):
        wave = wave_fitted_to_place(0.0, 7 * ARCMIN, dec, latitude, hours)
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
        values = [further_on(curve.odd, dec, latitude) for curve in own]
        cells = "  ".join(
            f"{curve.track.session[5:]}: {value / ARCMIN:+6.2f} +-{sigma / ARCMIN:5.2f}"
            for curve, (value, sigma) in zip(own, values, strict=True)
        )
        lines.append(f"  {antenna}  {cells}")
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
        cells = "  ".join(
            f"{antenna} {value / ARCMIN:+.1f} +-{sigma / ARCMIN:.1f}"
            for antenna, (value, sigma) in day.odd.items()
        )
        right, count = day.opposite
        lines.append(f"{day.session}: {cells}")
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
