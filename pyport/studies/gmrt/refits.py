"""The paper's curve a + b cos(HA + d) fitted again, its sigmas, and why fits differ from it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pyport.angles import ARCMIN, HOUR, Array
from pyport.diagnosis.joint import rms
from pyport.effects import MissingColumn
from pyport.fitting.fit import Fit
from pyport.studies.gmrt.curves import Cosine, Curve, Track, condition, curve, tracks
from pyport.studies.gmrt.figures import Hours, continued, hours
from pyport.studies.gmrt.published import Wave, table_18

#: A coefficient agrees with the published one within this many combined sigmas.
SIGMAS = 3.0

#: The published curve may leave this many times the rms of the refit.
RMS_RATIO = 1.2


@dataclass(frozen=True)
class Refit:
    """One antenna in one session: refits beside the published curve."""

    track: Track  #: its scans that print has left
    published: Wave  #: the paper's curve
    readings: int  #: how many readings have weight
    together: Cosine  #: the fitted model's own cosine, forward and reverse scans in one
    apart: Curve  #: the cosine with forward and reverse apart
    #: `continued`, `stretches`: the cosine of all the hours that the paper scanned, as the scans
    #: that are left foretell it; with formal errors, and with those by leaving out stretches of
    #: scans. None where the paper's hours are not known, or what is left does not tell.
    continued: Cosine | None
    stretches: Cosine | None
    #: `rms_published`, `rms_refit`, `rms_continued`: of the readings with weight about each curve
    #: [rad].
    rms_published: float
    rms_refit: float
    rms_continued: float

    @cached_property
    def sigmas(self) -> dict[str, Array]:
        """Return by how many combined sigmas a, b and d are off, for each kind of refit."""
        kinds = {
            "together": self.together,
            "apart": self.apart.cosine,
            "continued": self.continued,
            "stretches": self.stretches,
        }
        return {k: one.sigmas_from(self.published) for k, one in kinds.items() if one is not None}

    @property
    def rms_ratio(self) -> float:
        """Return the published curve's rms over the refit's."""
        return self.rms_published / self.rms_refit

    @property
    def rms_ratio_per_freedom(self) -> float:
        """Return the same per degree of freedom: three went into the refit, none into the other."""
        return self.rms_ratio * float(np.sqrt(1 - 3 / self.readings))

    @property
    def condition(self) -> float:
        """Return how a, b and d trade against each other on the hours that are left."""
        return condition(self.track.hour_angle)


@dataclass(frozen=True)
class Day:
    """One session's antennas beside Table 18, and what hours the paper scanned, where it tells."""

    session: str
    antennas: tuple[Refit, ...]
    hours: Hours | None


def beside_table_18(fit: Fit) -> list[Day]:
    """Return every session of a `gmrt-paper` fit that Table 18 has curves for.

    Recordings that do not tell their scans and the scans' directions have none.
    """
    at = fit.recordings.at
    published = {(wave.antenna, wave.session): wave for wave in table_18()}
    try:
        found = [t for t in tracks(fit.recordings) if (t.antenna, t.session) in published]
        dec, latitude = at.column("dec"), at.latitude()
    except MissingColumn:
        return []
    cosines, session = _cosines(fit), fit.recordings.label("session")
    days = []
    for name in sorted({track.session for track in found}):
        own = session == name
        left = np.unique(at.column("hour_angle")[own & np.isfinite(fit.recordings.y)])
        place = float(np.median(dec[own])), latitude
        day = [track for track in found if track.session == name and _labels(track) in cosines]
        scanned = hours(left, [published[_labels(track)] for track in day], *place)
        antennas = [
            _beside(fit, track, published[_labels(track)], cosines[_labels(track)], scanned, place)
            for track in day
        ]
        days.append(Day(name, tuple(antennas), scanned))
    return days


def _labels(track: Track) -> tuple[str, str]:
    return track.antenna, track.session


def _beside(
    fit: Fit,
    track: Track,
    wave: Wave,
    together: Cosine,
    scanned: Hours | None,
    place: tuple[float, float],
) -> Refit:
    """Return one antenna's day; `place` is the source's declination and the site's latitude."""
    recordings = fit.recordings
    own = (recordings.label("antenna") == track.antenna) & (
        recordings.label("session") == track.session
    )
    used = fit.stack.is_y & own[fit.stack.row] & (fit.noise.used)
    hour_angle = np.asarray(recordings.at.column("hour_angle"), float)[fit.stack.row[used]]
    offset = fit.stack.value[used]
    found = None if scanned is None else continued(track, scanned.scanned, *place)
    on, stretches = (None, None) if found is None else found
    return Refit(
        track,
        wave,
        int(used.sum()),
        together,
        curve(track),
        on,
        stretches,
        rms(offset - wave(hour_angle)),
        rms(fit.residual[used]),
        np.nan if on is None else rms(offset - on(hour_angle)),
    )


def _cosines(fit: Fit) -> dict[tuple[str, ...], Cosine]:
    """Return the fitted cosine of each antenna and session that the recordings determine."""
    start, parts = 0, {}
    for one in fit.coefficients:
        stop = start + len(one.value)
        parts[one.labels, len(one.value)] = one.value, np.arange(start, stop)
        start = stop
    cosines = {}
    for labels, size in parts:
        if size == 1 and (labels, 2) in parts:
            (zero, first), (rest, others) = parts[labels, 1], parts[labels, 2]
            value, of = np.concatenate([zero, rest]), np.concatenate([first, others])
            if np.isfinite(value).all():
                cosines[labels] = Cosine(value, fit.covariance[np.ix_(of, of)])
    return cosines


#: A normal sample's median of absolute values is this share of its sigma.
_HALF = 0.6744897501960817


def printed_sigma_factors(first: str, second: str) -> dict[str, float]:
    """Return by how much a, b and d differ between two days, in units of their printed sigmas.

    One would say that the sigmas are honest and the antennas repeat. The median
    over antennas, so that a few that do not repeat have no say.
    """
    curves = {(wave.antenna, wave.session): wave for wave in table_18()}
    pairs = [
        (wave, curves[wave.antenna, second])
        for (_, session), wave in curves.items()
        if session == first and (wave.antenna, second) in curves
    ]
    factors = {}
    for name in ("a", "b", "d"):
        apart = [
            abs(getattr(one, name) - getattr(other, name))
            / np.hypot(getattr(one, f"sigma_{name}"), getattr(other, f"sigma_{name}"))
            for one, other in pairs
        ]
        factors[name] = float(np.median(apart)) / _HALF
    return factors


#: The kinds of refit that are shown, and how they are called in a reason.
SHOWN = {"together": "in one curve", "apart": "apart", "continued": "continued"}

_TOO_LITTLE = "too little is left to tell how it went on"


def reasons(day: Day) -> list[str]:
    """Return a line for everything that differs on a day, nothing where all agree."""
    lines = []
    for one in day.antennas:
        name = one.track.antenna
        if any((sigmas > SIGMAS).any() for kind, sigmas in one.sigmas.items() if kind in SHOWN):
            text = ", ".join(
                f"{SHOWN[kind]} {_slashed(one, kind)}" for kind in SHOWN if kind in one.sigmas
            )
            lines.append(f"{name}: {text} sigmas: {_of_coefficients(day, one)}")
        if one.rms_ratio > RMS_RATIO:
            lines.append(f"{name}: {_of_rms(day, one)}")
    return lines


def _slashed(one: Refit, kind: str) -> str:
    """Return by how many combined sigmas a, b and d differ."""
    return "/".join(f"{sigma:.1f}" for sigma in one.sigmas[kind])


def _of_coefficients(day: Day, one: Refit) -> str:
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


def _few(day: Day, one: Refit) -> str:
    """Return what an antenna lacks where it lacks a third of the day's scans, "" elsewhere."""
    track = one.track
    if day.hours is None or 3 * len(track) > 2 * len(day.hours.left):
        return ""
    forward = int((track.direction > 0).sum())
    return (
        f"{forward} forward and {len(track) - forward} reverse scans are left of "
        f"{len(day.hours.left)} on the day, the last at {track.hour_angle[-1] / HOUR:+.1f} h"
    )


def _of_rms(day: Day, one: Refit) -> str:
    """Return why the published curve leaves more than the refit."""
    text = f"Table 18's curve leaves {one.rms_ratio:.2f} times the rms"
    if one.continued is None:
        return f"{text}: {_few(day, one) or _TOO_LITTLE}"
    text += f", the continued one {one.rms_continued / one.rms_refit:.2f} times"
    if one.rms_published <= RMS_RATIO * one.rms_continued:
        return f"{text}: what is best over all hours is no better on those left"
    return f"{text}: not explained by the hours"
