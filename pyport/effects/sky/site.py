"""The frame of the sky turned under the telescope: wrong site coordinates, wrong clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

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
from pyport.effects.sessions import since_begun, spans_of
from pyport.effects.sky.frame import SIDEREAL, hour_angle_shift, ut1_minus_utc

_SMART = "Smart, Textbook on Spherical Astronomy, ch. II: differentials of az and el"
#: UT1-UTC is distinguished from a constant error where it scatters by this share of itself.
CHANGED = 0.3
_CONSTANT, _OMITTED_UT1 = "constant", "UT1-UTC left out"


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


def _clock_rate(
    sessions: Sequence[str] = (),
    spans_s: Sequence[Sequence[float]] = (),
    since_s: float | None = None,
) -> Effect:
    """Return a clock at a wrong rate: set once, or when each session begins."""
    if since_s is not None:
        return _set_once(since_s)
    known = dict(zip(sessions, map(list, spans_s), strict=True))
    return Effect(
        "clock_rate",
        "the clock runs at a wrong rate (above zero it loses): check what keeps it to time, as NTP",
        _SMART,
        (Coefficient("clock_rate", "s/d", SIDEREAL / DAY_S),),
        lambda at: _late(at, since_begun(at, known)),
        common="array",
        variant="set each session",
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
        looks_back=True,
        member={"sessions": list(known), "spans_s": list(known.values())} if known else {},
        make=_clock_rate,
    )


def _set_once(since_s: float) -> Effect:
    """Return a clock that goes wrong from some moment on [s]."""
    # Beside nights that lean its one coefficient takes weak steps of the tilt.
    return replace(
        _clock_rate(),
        basis=lambda at: _late(at, at.numbers("time") - since_s),
        variant="set once",
        looks_back=False,
        changes_with="time",
        change_of="tilt",
        consists_of=("epoch_tilt", "epoch_azimuth_zero"),
        member={"since_s": since_s},
    )


def _late(at: Circumstances, since: Array) -> tuple[Array, Array]:
    """Return the offset for each second of hour angle that a clock loses in a second (n,)."""
    x, y = hour_angle_shift(at)
    return stack(at, (since * x, since * y))


def _clock_rates(at: Circumstances) -> tuple[Effect, ...]:
    """Return a clock that was set when each session of some recordings began, and one set once."""
    spans = spans_of(at)
    each_session = _clock_rate(list(spans), list(spans.values()))
    if len(spans) < 2:
        return (each_session,)
    return each_session, _set_once(min(began for began, _ in spans.values()))


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
