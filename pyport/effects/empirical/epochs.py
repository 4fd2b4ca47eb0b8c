"""Epochs: what was moved or reset, what differs between sessions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, Array
from pyport.effects.base import (
    AXES,
    SKY,
    STEP,
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    stack,
)
from pyport.effects.circumstances import utc
from pyport.effects.sky.site import hour_angle_turned
from pyport.effects.telescope.geometry import azimuth_zero, sag_cosine, tilt
from pyport.thresholds import SEVERAL

OWN = "the constants of a pointing model hold for one state of the telescope"

#: So many moments are tried for a step: half in the longest gaps, half spread over the rows.
MOST_STEPS = 20

Inside = Callable[[Circumstances], NDArray[np.bool_]]


def offset(at: Circumstances) -> tuple[Array, Array]:
    """Return a constant in each axis."""
    return stack(at, (1, 0), (0, 1))


def _within(
    effect: Effect, inside: Inside, labels: list[str], variant: str, member: Mapping[str, Any]
) -> Effect:
    """Return an effect with coefficients of its own in each of some epochs, zero outside.

    `inside` tells which of the epochs, named by `labels`, each row is in: (n, epochs).
    """

    def basis(at: Circumstances) -> tuple[Array, Array]:
        there = inside(at)[:, :, None]
        x, y = (there * axis[:, None, :] for axis in _SHAPES[effect.on_altaz](at))
        return x.reshape(len(at), -1), y.reshape(len(at), -1)

    coefficients = tuple(
        replace(one, name=f"{one.name}[{label}]") for label in labels for one in effect.coefficients
    )
    return replace(
        effect, coefficients=coefficients, basis=basis, variant=variant, member=dict(member)
    )


def _by_session(effect: Effect, at: Circumstances) -> Effect:
    """Return an effect with coefficients of its own in every session but the first."""
    names = np.unique(at.column("session").astype(str))
    if len(names) < 2:
        raise MissingColumn("a second session")
    return _in_sessions(effect, [str(name) for name in names[1:]])


def _in_sessions(effect: Effect, sessions: Sequence[str]) -> Effect:
    """Return an effect with coefficients of its own in each of some sessions."""
    return _within(
        effect,
        lambda at: at.column("session").astype(str)[:, None] == np.array(sessions),
        list(sessions),
        "constant per session",
        {"sessions": list(sessions)},
    )


def _when(at: Circumstances) -> Array:
    """Return the time [s], or the order of the rows without one; half of it must be known."""
    return at.numbers("time" if "time" in at or "order" not in at else "order")


def epoch_step(
    since: float, effect: Effect | None = None, until: float = np.inf, *, of_order: bool = False
) -> Effect:
    """Return an effect of epochs, by default `epoch_offset`, as a step at one moment.

    `since` is in seconds UTC since 1970, or a number of rows in the file's order; so is `until`,
    when it steps back.
    """
    back = until < np.inf
    if of_order:
        when = (
            f"rows {int(since) + 2} to {int(until) + 1}" if back else f"since row {int(since) + 2}"
        )
    else:
        when = f"from {utc(since)} to {utc(until)}" if back else f"since {utc(since)}"

    def inside(at: Circumstances) -> NDArray[np.bool_]:
        now = _when(at)
        return ((now >= since) & (now < until))[:, None]

    unit = "row" if of_order else "s"
    member = {f"since_{unit}": since} | ({f"until_{unit}": until} if back else {})
    variant = f"step and back, {when}" if back else f"step, {when}"
    step = _within(effect or _OFFSET, inside, [when], variant, member)
    changes_with = "order" if of_order else "session"
    return replace(step, parameter=since, until=until, changes_with=changes_with)


def _steps(effect: Effect, at: Circumstances, moments: Array) -> tuple[Effect, ...]:
    return tuple(epoch_step(float(one), effect, of_order="time" not in at) for one in moments)


def _in_one_session(effect: Effect, at: Circumstances) -> tuple[Effect, ...]:
    """Return an effect in each single session, those with the most rows where there are many."""
    names, count = np.unique(at.column("session").astype(str), return_counts=True)
    if len(names) < SEVERAL:
        return ()
    most = np.sort(np.argsort(-count, kind="stable")[:MOST_STEPS])
    return tuple(_in_session_alone(effect, str(names[one])) for one in most)


def _in_session_alone(effect: Effect, name: str) -> Effect:
    """Return an effect in one session."""
    inside = lambda at: (at.column("session").astype(str) == name)[:, None]  # noqa: E731
    variant = f"in session {name} alone"
    return _within(effect, inside, [f"in {name}"], variant, {"session": name})


def _made(effect: Callable[[], Effect]) -> Callable[..., Effect]:
    """Return what makes a member of an effect of epochs: by sessions, or from a moment on."""

    def make(
        sessions: Sequence[str] | None = None,
        session: str | None = None,
        since_s: float = 0.0,
        since_row: float | None = None,
        until_s: float = np.inf,
        until_row: float = np.inf,
    ) -> Effect:
        if sessions is not None:
            return _in_sessions(effect(), sessions)
        if session is not None:
            return _in_session_alone(effect(), session)
        if since_row is not None:
            return epoch_step(since_row, effect(), until_row, of_order=True)
        return epoch_step(since_s, effect(), until_s)

    return make


def _moments(time: Array) -> Array:
    """Return some moments between recordings."""
    times = np.unique(time[np.isfinite(time)])
    gap = np.diff(times)
    chosen = np.arange(len(gap))
    if len(gap) > MOST_STEPS:
        longest = np.argsort(-gap, kind="stable")[: MOST_STEPS // 2]
        spread = np.linspace(0, len(gap) - 1, MOST_STEPS // 2 + 2)[1:-1].round().astype(int)
        chosen = np.union1d(longest, spread)
    return times[chosen] + gap[chosen] / 2


def _starts(at: Circumstances) -> Array:
    """Return when sessions began, but for the first one: just before, and not too many."""
    time, session = _when(at), at.column("session").astype(str)
    known = np.isfinite(time)
    names, number = np.unique(session[known], return_inverse=True)
    first = np.full(len(names), np.inf)
    np.minimum.at(first, number, time[known])
    later = np.unique(first)[1:] - 0.5
    few = np.linspace(0, len(later) - 1, min(len(later), MOST_STEPS)).round().astype(int)
    return later[few]


def _members(effect: Effect, at: Circumstances, moments: Array) -> tuple[Effect, ...]:
    """Return an effect of epochs per session and as steps; one of them where both say the same."""
    steps = _steps(effect, at, moments)
    if "session" not in at or len(np.unique(at.column("session"))) < 2:
        return steps
    by_session = _by_session(effect, at)
    if any(_splits_alike(by_session, step, at) for step in steps):
        return steps
    return by_session, *steps, *_in_one_session(effect, at)


def _splits_alike(by_session: Effect, step: Effect, at: Circumstances) -> bool:
    """Tell whether two sessions follow each other, so that a step says when the second began."""
    if len(by_session.coefficients) != len(step.coefficients):
        return False
    return np.array_equal(by_session.columns(at), step.columns(at))


def _epoch_offsets(at: Circumstances) -> tuple[Effect, ...]:
    """Return a constant per session, where there are some, and steps between recordings."""
    if "time" not in at and "order" not in at:
        return (_by_session(_OFFSET, at),)
    return _some(_members(_OFFSET, at, _moments(_when(at))))


def _set_anew(at: Circumstances) -> tuple[Effect, ...]:
    """Return steps of the azimuth zero: set anew it stays, and nights differ in other zeros."""
    return _some(_steps(_ZERO, at, _moments(at.numbers("time"))))


def _some(members: tuple[Effect, ...]) -> tuple[Effect, ...]:
    if not members:
        raise MissingColumn("a second moment")
    return members


def _from_session_on(effect: Effect, at: Circumstances) -> tuple[Effect, ...]:
    """Return an effect with coefficients per session, and as a step between any two of them."""
    if "time" not in at and "order" in at and "session" not in at:
        return _members(effect, at, _moments(_when(at)))
    if "time" not in at and "order" not in at:
        return (_by_session(effect, at),)
    if len(np.unique(at.column("session"))) < 2:
        raise MissingColumn("a second session")
    return _members(effect, at, _starts(at))


_OFFSET: Effect = Effect(
    "epoch_offset",
    "something was moved or reset",
    OWN,
    (Coefficient("offset_xel"), Coefficient("offset_el")),
    lambda at: _epoch_offsets(at)[0].basis(at),
    variant="constant per session",
    profile=_epoch_offsets,
    acts_in=AXES,
    in_arrays=STEP,
    pattern="the zeros differ from one time to another",
    needs=("session or time_utc",),
    formula=("b in each session, or since a moment", "c in each session, or since a moment"),
    changes_with="session",
    make=_made(lambda: _OFFSET),
)
_ZERO: Effect = Effect(
    "epoch_azimuth_zero",
    "the azimuth encoder's zero was set anew, or slipped",
    OWN,
    (Coefficient("azimuth_zero"),),
    lambda at: _set_anew(at)[0].basis(at),
    variant="step",
    profile=_set_anew,
    acts_in=AXES,
    pattern="a constant in azimuth, from one time to another",
    needs=("time_utc",),
    formula=("a cos E since a moment", ""),
    change_of="azimuth_zero",
    changes_with="session",
    make=_made(lambda: _ZERO),
)
_TILT: Effect = Effect(
    "epoch_tilt",
    "the azimuth axis leans otherwise in one session than in another",
    OWN,
    (Coefficient("tilt_north"), Coefficient("tilt_east")),
    lambda at: _by_session(_TILT, at).basis(at),
    variant="constant per session",
    profile=lambda at: _from_session_on(_TILT, at),
    acts_in=AXES,
    pattern="once per turn of azimuth, in both axes, from one session to another",
    needs=("session",),
    formula=("a tilt in each session, or since one", "a tilt in each session, or since one"),
    change_of="tilt",
    changes_with="session",
    make=_made(lambda: _TILT),
)
_SAG: Effect = Effect(
    "epoch_sag",
    "the structure sags otherwise in one session than in another",
    OWN,
    (Coefficient("sag_cosine"),),
    lambda at: _by_session(_SAG, at).basis(at),
    variant="constant per session",
    profile=lambda at: _from_session_on(_SAG, at),
    acts_in=SKY,
    pattern="with the cosine of elevation, in elevation, from one session to another",
    needs=("session",),
    formula=("", "g cos E in each session, or since one"),
    change_of="sag_cosine",
    changes_with="session",
    make=_made(lambda: _SAG),
)
_CLOCK: Effect = Effect(
    "epoch_clock",
    "the clock, or the times that were written down, are off otherwise in one session than in "
    "another",
    OWN,
    (Coefficient("clock_error", "s", 15 * ARCSEC),),
    lambda at: _by_session(_CLOCK, at).basis(at),
    common="array",
    variant="constant per session",
    profile=lambda at: _from_session_on(_CLOCK, at),
    acts_in=SKY,
    pattern="along the hour angle, in both axes, from one session to another",
    needs=("session", "latitude_deg"),
    formula=("a clock error in each session, or since one",) * 2,
    # A clock error is a lean of the axis to the east.
    change_of="tilt",
    # And of a zero of azimuth: on a mount that turns as the sky does it is nothing but that.
    consists_of=("epoch_tilt",),
    changes_with="session",
    make=_made(lambda: _CLOCK),
)
#: What each of them does inside an epoch.
_SHAPES = {
    "epoch_offset": offset,
    "epoch_azimuth_zero": azimuth_zero,
    "epoch_tilt": tilt,
    "epoch_sag": sag_cosine,
    "epoch_clock": hour_angle_turned,
}

EFFECTS = (_OFFSET, _ZERO, _TILT, _SAG, _CLOCK)
