"""Oscillations in time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array
from pyport.effects.base import AXES, Circumstances, Coefficient, Effect, MissingColumn, stack
from pyport.effects.circumstances import utc

#: The id of an oscillation.
OSCILLATION = "oscillation"
#: Periods that stand for all others until one is chosen from the recordings [s].
PERIODS_S = (3600.0, 3 * 3600.0, 9 * 3600.0)
#: A file may ask for any period and any number of stretches: none is shorter [s], none are more.
SHORTEST_S, MOST_STRETCHES = 1.0, 10_000

#: Beginning and end of some time [s, UTC since 1970].
Stretch = tuple[float, float]


def oscillation(
    period_s: float,
    since_s: float = 0.0,
    stretches_s: Sequence[Stretch] | None = None,
    *,
    direction_deg: float | None = None,
    reversing: bool = False,
) -> Effect:
    """Return an oscillation of the zeros.

    Parameters
    ----------
    period_s
        Its period.
    since_s
        The moment at which its sine begins [s, UTC since 1970].
    stretches_s
        Where its phase wanders: times in each of which amplitude and phase are free. None where
        they hold throughout.
    direction_deg
        The line along which the beam swings [deg], from across toward along elevation. None where
        both axes have an amplitude and a phase of their own.
    reversing
        Whether it changes its sign where the mount has turned over, as what the second axis does.

    Raises
    ------
    ValueError
        There is no such period, or there are more stretches than any recordings have.
    """
    if not period_s >= SHORTEST_S or len(stretches_s or ()) > MOST_STRETCHES:
        raise ValueError("an oscillation needs a period above a second and countable stretches")

    def basis(at: Circumstances) -> tuple[Array, Array]:
        time = at.numbers("time")
        phase = 2 * np.pi * (time - since_s) / period_s
        # What acts in the axes changes its sign there: twice is not at all.
        sign = 1.0 if reversing or at.sky is None else at.sky.side
        sine, cosine = sign * np.sin(phase), sign * np.cos(phase)
        inside = [np.ones(len(at), bool)] if stretches_s is None else _inside(time, stretches_s)
        columns = ((one * sine, one * cosine) for one in inside)
        waves = [wave for pair in columns for wave in pair]
        return stack(at, *[(x * wave, y * wave) for _, x, y in ways for wave in waves])

    ways = _ways(direction_deg)
    labels = [""] if stretches_s is None else [f"[{n + 1}]" for n in range(len(stretches_s))]
    return Effect(
        OSCILLATION,
        "something hunts or is switched by turns: a servo, a heater, an air conditioner",
        "a sine wave in time; Scargle 1982, ApJ 263, 835 (its search)",
        tuple(
            Coefficient(f"{wave}{axis}{label}")
            for axis, *_ in ways
            for label in labels
            for wave in ("sine", "cosine")
        ),
        basis,
        variant=_variant(period_s, since_s, stretches_s, reversing=reversing),
        profile=_members,
        acts_in=AXES,
        pattern="a wave in time, of one period",
        needs=("time_utc",),
        formula=("a sin(2 pi t / P) + b cos(2 pi t / P)", "c sin(2 pi t / P) + d cos(2 pi t / P)"),
        parameter=period_s,
        changes_with="time" if stretches_s is None else "stretch",
        member=_member(period_s, since_s, stretches_s, direction_deg, reversing=reversing),
        make=oscillation,
    )


def _ways(direction_deg: float | None) -> list[tuple[str, float, float]]:
    """Return the suffix of the coefficients of each line that it swings along, and its direction.

    Along a line of its own, or along both axes.
    """
    if direction_deg is None:
        return [("_xel", 1.0, 0.0), ("_el", 0.0, 1.0)]
    line = direction_deg * DEG
    return [("", float(np.cos(line)), float(np.sin(line)))]


def _variant(
    period_s: float, since_s: float, stretches_s: Sequence[Stretch] | None, *, reversing: bool
) -> str:
    phase = f", phase since {utc(since_s)}" if since_s else ""
    if stretches_s is not None:
        phase = f", its phase free in {len(stretches_s)} stretches of time"
    sides = ", its sign changing with the side of the pier" if reversing else ""
    return f"period {period_s / 60:.4g} min{phase}{sides}"


def _member(
    period_s: float,
    since_s: float,
    stretches_s: Sequence[Stretch] | None,
    direction_deg: float | None,
    *,
    reversing: bool,
) -> dict[str, Any]:
    """Return what `oscillation` makes the same effect of: what is as usual is left out."""
    member: dict[str, Any] = {"period_s": period_s, "since_s": since_s}
    if stretches_s is not None:
        member["stretches_s"] = [list(one) for one in stretches_s]
    if direction_deg is not None:
        member["direction_deg"] = direction_deg
    if reversing:
        member["reversing"] = True
    return member


def _inside(time: Array, stretches_s: Sequence[Stretch]) -> list[NDArray[np.bool_]]:
    return [(time >= first) & (time <= last) for first, last in stretches_s]


def _members(at: Circumstances) -> tuple[Effect, ...]:
    """Return some periods. The antennas of an array do not share one: their servos are several."""
    at.numbers("time")
    if "antenna" in at and len(np.unique(at.column("antenna"))) > 1:
        raise MissingColumn("recordings of a single antenna")
    return tuple(oscillation(one) for one in PERIODS_S)


EFFECTS = (oscillation(PERIODS_S[0]),)
