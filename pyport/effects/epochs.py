"""Time: what differs between sessions, and what changes slowly."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pyport.angles import Array
from pyport.effects.base import Circumstances, Coefficient, Effect, MissingColumn, stack

_OWN = "the constants of a pointing model hold for one state of the telescope"

#: Orders of the slow polynomial in time that are tried.
DRIFT_ORDERS = (1, 2, 3)


def _session_offsets(at: Circumstances) -> Effect:
    """Return a constant for every session but the first, in both axes."""
    names = np.unique(at.column("session"))

    def basis(at: Circumstances) -> tuple[Array, Array]:
        session = at.column("session")
        steps = [np.where(session == name, 1.0, 0.0) for name in names[1:]]
        return stack(at, *[(step, 0) for step in steps], *[(0, step) for step in steps])

    coefficients = tuple(
        Coefficient(f"offset_{axis}[{name}]") for axis in ("xel", "el") for name in names[1:]
    )
    return _epoch_offset(coefficients, basis, "constant per session")


def _epoch_offset(
    coefficients: tuple[Coefficient, ...],
    basis: Callable[[Circumstances], tuple[Array, Array]],
    variant: str,
) -> Effect:
    return Effect(
        "epoch_offset",
        "something was moved: the zeros differ from one session to another",
        _OWN,
        coefficients,
        basis,
        variant=variant,
        profile=_epoch_offsets,
    )


def _epoch_offsets(at: Circumstances) -> tuple[Effect, ...]:
    """Return the partitions to try; none where there is a single session."""
    if len(np.unique(at.column("session"))) < 2:
        raise MissingColumn("a second session")
    return (_session_offsets(at),)


def _needs_sessions(at: Circumstances) -> tuple[Array, Array]:
    """Return the basis of the constants per session."""
    return _epoch_offsets(at)[0].basis(at)


def _drift(order: int) -> Effect:
    def basis(at: Circumstances) -> tuple[Array, Array]:
        time = np.asarray(at.column("time"), float)
        middle = (np.nanmax(time) + np.nanmin(time)) / 2
        half = max((np.nanmax(time) - np.nanmin(time)) / 2, 1.0)
        powers = np.polynomial.legendre.legvander(np.nan_to_num((time - middle) / half), order)
        columns = [powers[:, n] for n in range(1, order + 1)]
        return stack(at, *[(one, 0) for one in columns], *[(0, one) for one in columns])

    return Effect(
        "drift",
        "the offsets drift slowly with time",
        _OWN,
        tuple(
            Coefficient(f"drift_{axis}_{n}") for axis in ("xel", "el") for n in range(1, order + 1)
        ),
        basis,
        variant=f"order {order}",
        profile=lambda _: tuple(map(_drift, DRIFT_ORDERS)),
    )


EFFECTS = (
    _epoch_offset((), _needs_sessions, "constant per session"),
    _drift(1),
)
