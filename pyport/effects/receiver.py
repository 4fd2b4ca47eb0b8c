"""Receivers: boxes that sit beside the axis, beams that squint apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.effects.base import (
    Basis,
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    stack,
)

_BAARS = "Baars 2007, The Paraboloidal Reflector Antenna: feeds off the axis"

#: Frequencies further apart than this ratio belong to two bands.
NEXT_BAND = 1.25


def bands(frequency_mhz: Array) -> NDArray[np.str_]:
    """Return the band of each frequency by name, "" where it is unknown.

    A band ends where the next frequency is higher by more than `NEXT_BAND`.
    """
    known = np.unique(frequency_mhz[np.isfinite(frequency_mhz)])
    starts = known[np.concatenate([[True], known[1:] > NEXT_BAND * known[:-1]])]
    at = np.searchsorted(starts, frequency_mhz, side="right") - 1
    names = np.array([f"from {start:g} MHz" for start in starts])
    return np.where(np.isfinite(frequency_mhz), names[np.clip(at, 0, None)], "")


def _labels(at: Circumstances, column: str) -> NDArray[np.str_]:
    """Return the labels that split these pointings."""
    if column == "frequency_mhz":
        return bands(at.numbers(column))
    return at.column(column).astype(str)


def _values(at: Circumstances, column: str) -> list[str]:
    """Return the distinct values of a label, the most frequent first."""
    values, count = np.unique(_labels(at, column), return_counts=True)
    ranked = values[np.argsort(-count, kind="stable")]
    return [str(value) for value in ranked if value != ""]


def _columns(names: list[str]) -> tuple[Coefficient, ...]:
    return tuple(
        Coefficient(f"{axis}[{name}]") for axis in ("offset_xel", "offset_el") for name in names
    )


def _in_both_axes(at: Circumstances, steps: list[Array]) -> tuple[Array, Array]:
    return stack(at, *[(step, 0) for step in steps], *[(0, step) for step in steps])


def _offset(column: str, values: list[str]) -> Effect:
    """Return a constant for every receiver but the one used most."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        label = _labels(at, column)
        return _in_both_axes(at, [np.where(label == value, 1.0, 0.0) for value in values[1:]])

    return _receiver_offset(basis, _columns(values[1:]), _BY[column])


def _receiver_offset(
    basis: Basis, coefficients: tuple[Coefficient, ...] = (), variant: str = "by receiver"
) -> Effect:
    return Effect(
        "receiver_offset",
        "a receiver's box sits elsewhere: receivers or bands differ by a constant",
        _BAARS,
        coefficients,
        basis,
        variant=variant,
        profile=_receiver_offsets,
        needs=("receiver or frequency_mhz",),
        formula=("b for each receiver or band", "c for each receiver or band"),
    )


_BY = {
    "receiver": "by receiver",
    "frequency_mhz": "by frequency band",
    "polarisation": "by polarisation",
    "channel": "by channel",
}


def _receiver_offsets(at: Circumstances) -> tuple[Effect, ...]:
    return tuple(_offset(*split) for split in _splits(at, "receiver", "frequency_mhz"))


def _splits(at: Circumstances, *columns: str) -> list[tuple[str, list[str]]]:
    """Return the columns that split these pointings in two or more, each split once.

    Raises
    ------
    MissingColumn
        None of the columns is there, or they have one value each.
    """
    there = [column for column in columns if column in at]
    if not there:
        raise MissingColumn(" or ".join(columns))
    splits: dict[bytes, tuple[str, list[str]]] = {}
    for column in there:
        values = _values(at, column)
        if len(values) > 1:
            labels = _labels(at, column)
            same = np.unique(labels, return_index=True, return_inverse=True)[1:]
            first_row_alike = same[0][same[1]]
            splits.setdefault(first_row_alike.tobytes(), (column, values))
    if not splits:
        raise MissingColumn(f"a second {there[0].removesuffix('_mhz')}")
    return list(splits.values())


def _squint(column: str, values: list[str]) -> Effect:
    """Return offsets that cancel over the values of a label: + for each one, - for the last."""

    def basis(at: Circumstances) -> tuple[Array, Array]:
        label = _labels(at, column)
        last = np.where(label == values[-1], 1.0, 0.0)
        return _in_both_axes(
            at, [np.where(label == value, 1.0, 0.0) - last for value in values[:-1]]
        )

    return _beam_squint(basis, _columns(values[:-1]), _BY[column])


def _beam_squint(
    basis: Basis, coefficients: tuple[Coefficient, ...] = (), variant: str = "by polarisation"
) -> Effect:
    return Effect(
        "beam_squint",
        "the beams of two polarisations or channels point apart",
        "Chu & Turrin 1973, IEEE Trans. AP 21, 339: depolarization of offset reflectors",
        coefficients,
        basis,
        variant=variant,
        profile=_beam_squints,
        needs=("polarisation or channel",),
        formula=("+-b by polarisation or channel", "+-c by polarisation or channel"),
    )


def _beam_squints(at: Circumstances) -> tuple[Effect, ...]:
    splits = _splits(at, "polarisation", "channel")
    return tuple(_squint(column, sorted(values)) for column, values in splits)


EFFECTS = (
    _receiver_offset(lambda at: _receiver_offsets(at)[0].basis(at)),
    _beam_squint(lambda at: _beam_squints(at)[0].basis(at)),
)
