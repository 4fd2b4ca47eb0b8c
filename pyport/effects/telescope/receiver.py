"""Receivers: boxes that sit beside the axis, beams that squint apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.effects.base import (
    AXES,
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    stack,
)

_BAARS = "Baars 2007, The Paraboloidal Reflector Antenna: feeds off the axis"

#: Frequencies further apart than this ratio belong to two bands.
NEXT_BAND = 1.25


@dataclass(frozen=True)
class Split:
    """A label that splits recordings: its column and values, and where bands of frequency start."""

    by: str
    values: list[str]
    starts_mhz: list[float]

    @property
    def name(self) -> str:
        """Return what a split by this column is called."""
        return "by frequency band" if self.by == "frequency_mhz" else f"by {self.by}"

    def label(self, at: Circumstances) -> NDArray[np.str_]:
        """Return the label of each row."""
        if self.by == "frequency_mhz":
            return band_of(at.numbers(self.by), np.array(self.starts_mhz))
        return at.column(self.by).astype(str)


def bands(frequency_mhz: Array) -> Array:
    """Return where frequency bands start, rising [MHz].

    A band ends where the next frequency is higher by more than `NEXT_BAND`.
    """
    known = np.unique(frequency_mhz[np.isfinite(frequency_mhz)])
    return known[np.concatenate([[True], known[1:] > NEXT_BAND * known[:-1]])]


def band_of(frequency_mhz: Array, starts: Array) -> NDArray[np.str_]:
    """Return the band of each frequency by name, "" where there is none."""
    names = np.array(["", *(f"from {start:g} MHz" for start in starts)])
    known = np.isfinite(frequency_mhz)
    return names[np.where(known, np.searchsorted(starts, frequency_mhz, side="right"), 0)]


def _splits(at: Circumstances, names: Sequence[str]) -> list[Split]:
    """Return the labels that split these pointings in two or more, each way of splitting once.

    `names` has the columns. The values of a label are in the order of how many rows have them.

    Raises `MissingColumn`: none of the columns is there, or they have one value each.
    """
    there = [column for column in names if column in at]
    if not there:
        raise MissingColumn(" or ".join(names))
    splits: dict[bytes, Split] = {}
    for column in there:
        starts = bands(at.numbers(column)).tolist() if column == "frequency_mhz" else []
        split = Split(column, [], starts)
        values, first, number, count = np.unique(
            split.label(at), return_index=True, return_inverse=True, return_counts=True
        )
        ranked = [str(one) for one in values[np.argsort(-count, kind="stable")] if one != ""]
        if len(ranked) > 1:
            splits.setdefault(first[number].tobytes(), replace(split, values=ranked))
    if not splits:
        raise MissingColumn(f"a second {there[0].removesuffix('_mhz')}")
    return list(splits.values())


def _columns(names: list[str]) -> tuple[Coefficient, ...]:
    return tuple(
        Coefficient(f"{axis}[{name}]") for axis in ("offset_xel", "offset_el") for name in names
    )


def _in_both_axes(at: Circumstances, steps: list[Array]) -> tuple[Array, Array]:
    return stack(at, *[(step, 0) for step in steps], *[(0, step) for step in steps])


def _receiver_offset(split: Split | None = None) -> Effect:
    """Return a constant for every receiver but the one used most; without a split the first one."""
    others = [] if split is None else split.values[1:]

    def basis(at: Circumstances) -> tuple[Array, Array]:
        if split is None:
            return _receiver_offsets(at)[0].basis(at)
        label = split.label(at)
        return _in_both_axes(at, [np.where(label == value, 1.0, 0.0) for value in others])

    how = "by receiver" if split is None else split.name
    return Effect(
        "receiver_offset",
        "receivers or bands look in different directions",
        _BAARS,
        _columns(others),
        basis,
        variant=how,
        profile=_receiver_offsets,
        acts_in=AXES,
        pattern=f"a constant {how}, in both axes",
        means={"receiver-boxes": "a box beside its place"},
        needs=("receiver or frequency_mhz",),
        formula=("b for each receiver or band", "c for each receiver or band"),
        member={} if split is None else asdict(split),
        make=lambda **member: _receiver_offset(Split(**member)),
    )


def _receiver_offsets(at: Circumstances) -> tuple[Effect, ...]:
    return tuple(map(_receiver_offset, _splits(at, ("receiver", "frequency_mhz"))))


def _beam_squint(split: Split | None = None) -> Effect:
    """Return offsets that cancel over the values of a label: + for each one, - for the last.

    Without a split those of the first one.
    """
    *others, last = [""] if split is None else sorted(split.values)

    def basis(at: Circumstances) -> tuple[Array, Array]:
        if split is None:
            return _beam_squints(at)[0].basis(at)
        label = split.label(at)
        minus = np.where(label == last, 1.0, 0.0)
        return _in_both_axes(at, [np.where(label == one, 1.0, 0.0) - minus for one in others])

    how = "by polarisation" if split is None else split.name
    return Effect(
        "beam_squint",
        "the beams of two polarisations or channels point apart",
        "Chu & Turrin 1973, IEEE Trans. AP 21, 339: depolarization of offset reflectors",
        _columns(others),
        basis,
        variant=how,
        profile=_beam_squints,
        acts_in=AXES,
        pattern=f"opposite offsets {how}, in both axes",
        needs=("polarisation or channel",),
        formula=("+-b by polarisation or channel", "+-c by polarisation or channel"),
        member={} if split is None else asdict(split),
        make=lambda **member: _beam_squint(Split(**member)),
    )


def _beam_squints(at: Circumstances) -> tuple[Effect, ...]:
    return tuple(map(_beam_squint, _splits(at, ("polarisation", "channel"))))


EFFECTS = (_receiver_offset(), _beam_squint())
