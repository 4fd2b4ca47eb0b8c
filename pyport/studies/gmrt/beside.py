"""The paper's curve a + b cos(HA + d) fitted again, beside the paper's own coefficients."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pyport.angles import Array
from pyport.effects import MissingColumn
from pyport.fitting.fit import Fit
from pyport.studies.gmrt.continued import continued
from pyport.studies.gmrt.cosine import Cosine, condition
from pyport.studies.gmrt.curves import Curve, curve
from pyport.studies.gmrt.hours import Hours, hours
from pyport.studies.gmrt.published import Wave, table_18
from pyport.studies.gmrt.tracks import Track, tracks

#: A coefficient agrees with the published one within this many combined sigmas.
SIGMAS = 3.0

#: The published curve may leave this many times the rms of the refit.
RMS_RATIO = 1.2


@dataclass(frozen=True)
class Beside:
    """One antenna in one session: refits beside the published curve.

    Attributes
    ----------
    track
        Its scans that print has left.
    published
        The paper's curve.
    readings
        How many readings have weight.
    together
        The fitted model's own cosine, forward and reverse scans in one.
    apart
        The cosine with forward and reverse apart.
    continued, stretches
        The cosine of all the hours that the paper scanned, as the scans that are
        left foretell it; with formal errors, and with those by leaving out
        stretches of scans. None where the paper's hours are not known, or what is
        left does not tell.
    rms_published, rms_refit, rms_continued
        Of the readings with weight about each curve [rad].
    """

    track: Track
    published: Wave
    readings: int
    together: Cosine
    apart: Curve
    continued: Cosine | None
    stretches: Cosine | None
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
    antennas: tuple[Beside, ...]
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
) -> Beside:
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
    return Beside(
        track,
        wave,
        int(used.sum()),
        together,
        curve(track),
        on,
        stretches,
        _rms(offset - wave(hour_angle)),
        _rms(fit.residual[used]),
        np.nan if on is None else _rms(offset - on(hour_angle)),
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


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
