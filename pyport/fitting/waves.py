"""The paper's curve a + b cos(HA + d) beside the paper's own coefficients."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pyport.angles import ARCMIN, DEG, Array
from pyport.fitting.fit import Fit
from pyport.fitting.gmrt.sigmas import printed_sigma_factors
from pyport.recordings.gmrt.published import Wave, table_18

#: A refit's a may be off the published one by this many combined sigmas.
SIGMAS = 3.0
#: The published curve may leave this many times the rms of the refit.
RMS_RATIO = 1.2
#: Fewer readings than this tell no three coefficients.
ENOUGH = 10
#: A condition number above this: a, b and d trade against each other on these hour angles.
DEGENERATE = 30.0


@dataclass(frozen=True)
class Beside:
    """One antenna in one session: the refit beside the published curve.

    Attributes
    ----------
    antenna, session, readings
        Whose, and how many readings have weight.
    a, b, d
        The refit [rad], each with its sigma.
    published
        The paper's curve.
    rms_published, rms_refit
        Of the readings with weight about each curve [rad], about the refit per
        degree of freedom: three went into it, none of these into the other.
    condition
        Of the refit's three columns.
    """

    antenna: str
    session: str
    readings: int
    a: tuple[float, float]
    b: tuple[float, float]
    d: tuple[float, float]
    published: Wave
    rms_published: float
    rms_refit: float
    condition: float

    @property
    def agrees_in_a(self) -> bool:
        """Tell whether a is within three combined sigmas."""
        combined = math.hypot(self.a[1], self.published.sigma_a)
        return abs(self.a[0] - self.published.a) <= SIGMAS * combined

    @property
    def as_good(self) -> bool:
        """Tell whether the published curve leaves no more than 1.2 times the refit's rms."""
        return self.rms_published <= RMS_RATIO * self.rms_refit

    @property
    def reason(self) -> str:
        """Say why the two differ, "" where they do not."""
        words = []
        if not self.agrees_in_a:
            apart = (self.a[0] - self.published.a) / math.hypot(self.a[1], self.published.sigma_a)
            words.append(f"a differs by {apart:+.1f} combined sigmas")
        if not self.as_good:
            ratio = self.rms_published / self.rms_refit
            words.append(f"the published curve leaves {ratio:.1f} times the rms")
        if words and self.condition > DEGENERATE:
            words.append(
                f"a, b and d trade against each other on the hour angles printed "
                f"(condition number {self.condition:.0f})"
            )
        return "; ".join(words)


def beside_table_18(fit: Fit) -> list[Beside]:
    """Return every antenna and session of a `gmrt-paper` fit that Table 18 has a curve for."""
    published = {(wave.antenna, wave.session): wave for wave in table_18()}
    recordings = fit.recordings
    antenna, session = recordings.label("antenna"), recordings.label("session")
    hour_angle = np.asarray(recordings.at.column("hour_angle"), float)
    found = []
    terms = {(one.labels, len(one.value)): one for one in fit.coefficients}
    for labels, width in terms:
        wave = published.get(labels) if len(labels) == 2 else None
        if width != 1 or wave is None:
            continue
        rows = np.flatnonzero((antenna == labels[0]) & (session == labels[1]))
        used = rows[fit.weight[rows] > 0]
        zero, cosine = terms[labels, 1], terms[labels, 2]
        if len(used) < ENOUGH or not np.isfinite([*zero.value, *cosine.value]).all():
            continue
        columns = np.stack([np.ones(len(used)), np.cos(hour_angle[used]), np.sin(hour_angle[used])])
        scaled = columns / np.linalg.norm(columns, axis=1, keepdims=True)
        b, d = _polar(cosine.value, cosine.sigma, wave)
        found.append(
            Beside(
                labels[0],
                labels[1],
                len(used),
                (float(zero.value[0]), float(zero.sigma[0])),
                b,
                d,
                wave,
                _rms(recordings.y[used] - wave(hour_angle[used])),
                _rms(fit.residual[used], spent=3),
                float(np.linalg.cond(scaled)),
            )
        )
    return found


def _polar(
    value: Array, sigma: Array, wave: Wave
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return b and d of b cos(h + d) from its cosine and sine, in the published curve's branch."""
    b = math.copysign(math.hypot(*value), wave.b)
    d = math.atan2(-value[1] / b, value[0] / b) if b else 0.0
    d += 2 * math.pi * round((wave.d - d) / (2 * math.pi))
    size = max(abs(b), 1e-300)
    along, across = math.hypot(*(value * sigma)) / size, math.hypot(*(value[::-1] * sigma)) / size
    return (b, along), (d, min(across / size, math.pi))


def _rms(values: Array, spent: int = 0) -> float:
    return math.sqrt(float(np.sum(values**2)) / (len(values) - spent))


def text(found: list[Beside]) -> str:
    """Return the comparison as a table, the share that agrees, and the reason for the rest."""
    columns = ("a [arcmin]", "b [arcmin]", "d [deg]", "a [arcmin]")
    lines = [
        f"{'':16s}{'refit':^54s}{'Table 18':^36s}rms [arcmin]",
        f"{'':19s}{''.join(f'{name:18s}' for name in columns)}b        d     printed  refit",
    ]
    for one in found:
        wave = one.published
        lines.append(
            f"{one.antenna} {one.session} {_pair(one.a, ARCMIN)} {_pair(one.b, ARCMIN)} "
            f"{_pair(one.d, DEG)} {_pair((wave.a, wave.sigma_a), ARCMIN)} "
            f"{wave.b / ARCMIN:8.2f} {wave.d / DEG:8.2f} "
            f"{one.rms_published / ARCMIN:8.2f} {one.rms_refit / ARCMIN:6.2f} {one.condition:5.0f}"
        )
    for session in sorted({one.session for one in found}):
        day = [one for one in found if one.session == session]
        near = sum(one.agrees_in_a for one in day)
        good = sum(one.as_good for one in day)
        lines.append(
            f"{session}: a within {SIGMAS:.0f} combined sigmas for {near} of {len(day)} antennas "
            f"({near / len(day):.0%}); the published curve leaves at most {RMS_RATIO} times the "
            f"refit's rms for {good} ({good / len(day):.0%})"
        )
    lines += [f"  {one.antenna} {one.session}: {one.reason}" for one in found if one.reason]
    factors = printed_sigma_factors("2003-06-01", "2003-06-02")
    told = ", ".join(f"{name} {factor:.1f}" for name, factor in factors.items())
    lines.append(f"Table 18 of 1 and 2 June differs by this many printed sigmas (median): {told}")
    return "\n".join(lines)


def _pair(value: tuple[float, float], unit: float) -> str:
    return f"{value[0] / unit:7.2f} +-{value[1] / unit:6.2f}"
