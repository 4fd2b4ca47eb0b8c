"""The frame of the sky turned under the telescope: wrong site coordinates, wrong clock."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, Array
from pyport.effects.base import (
    HELD,
    SKY,
    THE_HOUR,
    Basis,
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    stack,
)
from pyport.effects.circumstances import DAY_S, NIGHT_GAP_S
from pyport.effects.sky.frame import SIDEREAL, hour_angle_shift, ut1_minus_utc

_SMART = "Smart, Textbook on Spherical Astronomy, ch. II: differentials of az and el"
#: UT1-UTC is distinguished from a constant error where it scatters by this share of itself.
CHANGED = 0.3
_CONSTANT, _OMITTED_UT1 = "constant", "UT1-UTC left out"
_EACH_SESSION, _ONCE = "set each session", "set once"
#: When sessions began and ended [s].
Spans = Sequence[Sequence[float]]


def site_latitude(at: Circumstances) -> tuple[Array, Array]:
    """Return the offset for each radian of true minus assumed latitude: a lean toward north."""
    return stack(at, (np.sin(at.el) * np.sin(at.az), np.cos(at.az)))


def site_longitude(at: Circumstances) -> tuple[Array, Array]:
    """Return the offset for each radian of true minus assumed longitude, east positive."""
    return stack(at, hour_angle_shift(at))


def hour_angle_turned(at: Circumstances) -> tuple[Array, Array]:
    """Return the offset for each radian of true minus assumed hour angle."""
    return stack(at, hour_angle_shift(at))


def _omitted_ut1(at: Circumstances) -> tuple[Array, Array]:
    """Return the offset of a clock that keeps UTC for UT1, as the Earth really turned."""
    seconds = ut1_minus_utc(at)
    x, y = hour_angle_shift(at)
    return stack(at, (seconds * x, seconds * y))


def _clock(variant: str) -> Effect:
    """Return an error of the clock: the same at all times, or that of UT1-UTC left out."""
    basis: Basis = hour_angle_turned
    coefficient = Coefficient("clock_error", "s", 15 * ARCSEC)
    if variant == _OMITTED_UT1:
        basis, coefficient = _omitted_ut1, Coefficient("share_of_ut1_utc", "", SIDEREAL, 1.0)
    return Effect(
        "clock",
        "the clock, or UT1-UTC, is wrong",
        _SMART,
        (coefficient,),
        basis,
        common="array",
        variant=variant,
        profile=_clocks,
        acts_in=SKY,
        in_arrays=HELD,
        pattern="along the hour angle, in both axes",
        needs=("latitude_deg",),
        formula=("d (sin phi cos E - cos phi sin E cos A)", "d cos phi sin A"),
        member={"variant": variant},
        make=_clock,
    )


def _clocks(at: Circumstances) -> tuple[Effect, ...]:
    """Return a constant error and, where it changed enough to show, UT1-UTC left out."""
    constant = _clock(_CONSTANT)
    try:
        seconds = ut1_minus_utc(at)
    except MissingColumn:
        return (constant,)
    if np.nanstd(seconds) < CHANGED * np.sqrt(np.nanmean(seconds**2)):
        return (constant,)
    return constant, _clock(_OMITTED_UT1)


def _sessions(at: Circumstances) -> NDArray[np.str_]:
    """Return the session of each row, shape (n,): one where none are told."""
    return at.column("session").astype(str) if "session" in at else np.full(len(at), "")


def _since_set(at: Circumstances, sessions: Sequence[str], spans_s: Spans) -> Array:
    """Return the time since the session of each row began [s], shape (n,).

    A session that is not among those told, or has the name of one at another time, began with its
    own first row.
    """
    time, session = at.numbers("time"), _sessions(at)
    told = dict(zip(sessions, spans_s, strict=True))
    since = np.full(len(at), np.nan)
    for name in np.unique(session[np.isfinite(time)]):
        own = session == name
        began = float(np.nanmin(time[own]))
        first, last = told.get(str(name), (began, began))
        # What follows within a night's gap belongs to the same night, and its clock was not set.
        same = first <= began < last + NIGHT_GAP_S
        since[own] = time[own] - (first if same else began)
    return since


def _session_spans(at: Circumstances) -> tuple[list[str], list[list[float]]]:
    """Return the sessions with a known time, and when each began and ended [s]."""
    time, session = at.numbers("time"), _sessions(at)
    names = np.unique(session[np.isfinite(time)])
    return names.tolist(), [_span(time[session == name]) for name in names]


def _span(time: Array) -> list[float]:
    return [float(np.nanmin(time)), float(np.nanmax(time))]


def _clock_rate(
    sessions: Sequence[str] = (),
    spans_s: Spans = (),
    span_s: Sequence[float] | None = None,
) -> Effect:
    """Return a clock at a wrong rate: set at each session's start, or once, before `span_s` [s].

    Beyond that span an error that grew stays as it was: the clock may have been set by then.
    """

    def basis(at: Circumstances) -> tuple[Array, Array]:
        if span_s is None:
            since = _since_set(at, sessions, spans_s)
        else:
            first, last = span_s
            since = np.clip(at.numbers("time"), first, last) - first
        x, y = hour_angle_shift(at)
        return stack(at, (since * x, since * y))

    once = span_s is not None
    return Effect(
        "clock_rate",
        "the clock runs at a wrong rate (above zero it loses): check what keeps it to time, as NTP",
        _SMART,
        (Coefficient("clock_rate", "s/d", SIDEREAL / DAY_S),),
        basis,
        common="array",
        variant=_ONCE if once else _EACH_SESSION,
        profile=_clock_rates,
        acts_in=SKY,
        in_arrays=HELD,
        pattern="along the hour angle, in both axes, more the longer ago the clock was set",
        needs=("latitude_deg", "time_utc"),
        formula=(
            "d (t - t0) (sin phi cos E - cos phi sin E cos A)",
            "d (t - t0) cos phi sin A",
        ),
        driver=THE_HOUR,
        changes_with="time" if once else "",
        member=_told(sessions, spans_s, span_s),
        make=_clock_rate,
    )


def _told(
    sessions: Sequence[str], spans_s: Spans, span_s: Sequence[float] | None
) -> dict[str, Any]:
    """Return what a file holds of when the clock was set."""
    if span_s is not None:
        return {"span_s": list(span_s)}
    each = [list(one) for one in spans_s]
    return {"sessions": list(sessions), "spans_s": each} if sessions else {}


def _clock_rates(at: Circumstances) -> tuple[Effect, ...]:
    """Return a clock that was set each session.

    One that was set once can be part of a model and is not tried: with its one coefficient it is
    found in place of a weak step of the tilt.
    """
    return (_clock_rate(*_session_spans(at)),)


EFFECTS = (
    Effect(
        "site_latitude",
        "the latitude used for the site is wrong",
        _SMART,
        (Coefficient("latitude_error"),),
        site_latitude,
        acts_in=SKY,
        mounts=("altaz", "xy"),
        in_arrays=HELD,
        pattern="as a lean toward north or south, in both axes",
        formula=("d sin E sin A", "d cos A"),
    ),
    Effect(
        "site_longitude",
        "the longitude used for the site is wrong",
        _SMART,
        (Coefficient("longitude_error"),),
        site_longitude,
        acts_in=SKY,
        in_arrays=HELD,
        pattern="along the hour angle, in both axes",
        needs=("latitude_deg",),
        formula=("d (sin phi cos E - cos phi sin E cos A)", "d cos phi sin A"),
    ),
    _clock(_CONSTANT),
    _clock_rate(),
)
