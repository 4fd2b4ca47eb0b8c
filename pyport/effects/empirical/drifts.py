"""Drifts: what creeps, warms or settles, as polynomials in time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyport.angles import Array
from pyport.effects.base import AXES, THE_HOUR, Circumstances, Coefficient, Effect, stack
from pyport.effects.empirical.epochs import OWN

#: Orders of the slow polynomial in time that are tried.
DRIFT_ORDERS = (1, 2, 3)


def _drift(order: int, span_s: Sequence[float] | None = None) -> Effect:
    """Return a polynomial in time over a span, by default that of the recordings themselves.

    Before and after it stays as it was at its ends: what crept for a night is not known to go on.
    """

    def basis(at: Circumstances) -> tuple[Array, Array]:
        time = at.numbers("time")
        first, last = _span(time) if span_s is None else span_s
        phase = np.clip((time - (first + last) / 2) / max((last - first) / 2, 1.0), -1.0, 1.0)
        powers = np.polynomial.legendre.legvander(phase, order)[:, 1:].T
        return stack(at, *[(one, 0) for one in powers], *[(0, one) for one in powers])

    numbers = range(1, order + 1)
    return Effect(
        "drift",
        "something creeps, warms or settles",
        OWN,
        tuple(Coefficient(f"drift_{axis}_{n}") for axis in ("xel", "el") for n in numbers),
        basis,
        variant=f"order {order}",
        profile=_drifts,
        acts_in=AXES,
        pattern="slowly, with time",
        needs=("time_utc",),
        formula=("a polynomial in time, constant outside its span", "another one"),
        parameter=order,
        driver=THE_HOUR,
        changes_with="time",
        member={"order": order} | ({} if span_s is None else {"span_s": list(span_s)}),
        make=_drift,
    )


def _drifts(at: Circumstances) -> tuple[Effect, ...]:
    span_s = _span(at.numbers("time"))
    return tuple(_drift(order, span_s) for order in DRIFT_ORDERS)


def _span(time: Array) -> tuple[float, float]:
    return float(np.nanmin(time)), float(np.nanmax(time))


EFFECTS = (_drift(1),)
