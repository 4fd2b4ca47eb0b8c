"""The frame of the sky turned under the telescope: wrong site coordinates, wrong clock."""

from __future__ import annotations

from collections.abc import Sequence

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
from pyport.effects.circumstances import DAY_S
from pyport.effects.sky.frame import SIDEREAL, hour_angle_shift, ut1_minus_utc

_SMART = "Smart, Textbook on Spherical Astronomy, ch. II: differentials of az and el"
#: UT1-UTC is distinguished from a constant error where it scatters by this share of itself.
CHANGED = 0.3
_CONSTANT, _OMITTED_UT1 = "constant", "UT1-UTC left out"
_EACH_SESSION, _ONCE = "set each session", "set once"


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


def _since_set(at: Circumstances, sessions: Sequence[str], starts_s: Sequence[float]) -> Array:
    """Return the time since the session of each row began [s], shape (n,).

    A session whose start is not told began with its own first row.
    """
    time, session = at.numbers("time"), _sessions(at)
    told = dict(zip(sessions, starts_s, strict=True))
    since = np.full(len(at), np.nan)
    for name in np.unique(session[np.isfinite(time)]):
        own = session == name
        since[own] = time[own] - told.get(str(name), np.nanmin(time[own]))
    return since


def _session_starts(at: Circumstances) -> tuple[list[str], list[float]]:
    """Return the sessions and when each began [s], those with a known time."""
    time, session = at.numbers("time"), _sessions(at)
    names = np.unique(session[np.isfinite(time)])
    return names.tolist(), [float(np.nanmin(time[session == name])) for name in names]


def _clock_rate(
    sessions: Sequence[str] = (),
    starts_s: Sequence[float] = (),
    since_s: float | None = None,
) -> Effect:
    """Return a clock at a wrong rate: set at each session's start, or once, at `since_s` [s]."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        if since_s is None:
            since = _since_set(at, sessions, starts_s)
        else:
            since = at.numbers("time") - since_s
        x, y = hour_angle_shift(at)
        return stack(at, (since * x, since * y))

    once = since_s is not None
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
        member={"since_s": since_s} if once else _told(sessions, starts_s),
        make=_clock_rate,
    )


def _told(sessions: Sequence[str], starts_s: Sequence[float]) -> dict[str, list[str] | list[float]]:
    """Return what a file holds of when sessions began."""
    return {"sessions": list(sessions), "starts_s": list(starts_s)} if sessions else {}


def _clock_rates(at: Circumstances) -> tuple[Effect, ...]:
    """Return a clock that was set each session and, where there are several, one set once."""
    sessions, starts_s = _session_starts(at)
    each = _clock_rate(sessions, starts_s)
    return (each, _clock_rate(since_s=min(starts_s))) if len(sessions) > 1 else (each,)


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
