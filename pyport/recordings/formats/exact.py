"""Columns of a table as decimal numbers, digit for digit, in the unit that a format wants."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from pathlib import Path

from pyport.columns import SET_ASIDE, angle_of
from pyport.effects.base import PIER_SIDE
from pyport.effects.mounts import declared
from pyport.errors import BadInput
from pyport.mounts import ALTAZ, KINDS, Mount
from pyport.recordings.mounted import ALSO, names_of
from pyport.recordings.schema import Table

#: Decimals of a degree that a number gets which has no end in degrees: 0.4 microarcsec.
DECIMALS = 10
#: Degrees in one of a unit.
_DEGREES = {
    "deg": Fraction(1),
    "arcmin": Fraction(1, 60),
    "arcsec": Fraction(1, 3600),
    "mdeg": Fraction(1, 1000),
    "h": Fraction(15),
}

Numbers = list[Decimal | None]


@dataclass(frozen=True)
class Written:
    """What a file does not hold of a table as the table has it."""

    left_out: tuple[str, ...] = ()  #: columns that the format has no place for
    masked: int = 0  #: rows that are masked there alone, for they lack an angle or an offset


def number(text: str) -> Decimal | None:
    """Return a cell as a number, None where it is blank or none."""
    try:
        value = Decimal(text)
    except InvalidOperation:
        return None
    return value if value.is_finite() else None


def cells(table: Table, name: str) -> list[str]:
    """Return a column as text; a number is spelled with all digits that it has."""
    column = table.columns[name]
    if column.dtype.kind in "UO":
        return [str(cell).strip() for cell in column.tolist()]
    values = column.tolist()
    return ["" if value != value else f"{Decimal(repr(value)):f}" for value in values]  # noqa: PLR0124


def in_degrees(table: Table, quantity: str) -> Numbers | None:
    """Return an angle in degrees, exactly where that has an end; None without such a column."""
    for name in table.columns:
        found = angle_of(name)
        if found is not None and found[0] == quantity:
            unit = name.rpartition("_")[2]
            return [scaled(number(text), unit) for text in cells(table, name)]
    return None


def scaled(value: Decimal | None, unit: str) -> Decimal | None:
    """Return a number of a unit in degrees."""
    if value is None or unit == "deg":
        return value
    if unit == "rad":
        return _rounded(value * Decimal(repr(math.degrees(1))))
    factor = _DEGREES[unit]
    exact = value * factor.numerator
    if factor.denominator in {1, 1000}:
        return exact / factor.denominator
    return _rounded(exact / factor.denominator)


def _rounded(value: Decimal) -> Decimal:
    """Return a number to so many decimals, without the zeros at its end."""
    return plain(value.quantize(Decimal(1).scaleb(-DECIMALS)))


def plain(value: Decimal) -> Decimal:
    """Return a number without the zeros at its end, and without an exponent."""
    short = value.normalize()
    return short.quantize(Decimal(1)) if short == short.to_integral_value() else short


def offsets(table: Table, path: Path) -> tuple[Numbers, Numbers]:
    """Return azimuth (as a coordinate) and elevation offsets in degrees.

    Raises `BadInput`: the table has no offset of one of the axes.
    """
    along = in_degrees(table, "d_el")
    if along is None and (downward := in_degrees(table, "d_zd")) is not None:
        along = [None if one is None else -one for one in downward]
    across = coordinate(table, "d_az", "d_xel", path)
    if along is None or across is None:
        axis = "elevation" if along is None else "azimuth"
        raise BadInput(f"no {axis} offsets, and this format holds both axes", path)
    return across, along


def coordinate(table: Table, quantity: str, on_sky: str, path: Path) -> Numbers | None:
    """Return an angle of azimuth as a coordinate, from one on the sky where that is recorded.

    Raises `BadInput`: it has to be made from one on the sky, and there is no elevation.
    """
    recorded = in_degrees(table, quantity)
    if recorded is not None:
        return recorded
    sky = in_degrees(table, on_sky)
    return (
        None
        if sky is None
        else [
            None if one is None or el is None else over_cos(one, el)
            for one, el in zip(sky, position(table, path)[1], strict=True)
        ]
    )


def over_cos(value: Decimal, el_deg: Decimal) -> Decimal:
    """Return an angle across over cos E."""
    return _rounded(value / Decimal(repr(math.cos(math.radians(el_deg)))))


def position(table: Table, path: Path) -> tuple[Numbers, Numbers]:
    """Return azimuth, from north through east, and elevation in degrees.

    Raises `BadInput`: the table has no such columns.
    """
    az, el = in_degrees(table, "az"), in_degrees(table, "el")
    if az is None or el is None:
        raise BadInput("no columns az_deg and el_deg, and this format holds them", path)
    if table.meta.get("azimuth_zero", "north").lower() == "south":
        az = [None if one is None else one + 180 for one in az]
    return az, el


def asides(table: Table) -> list[str]:
    """Return why each row is not to be used, "" for those that are."""
    if SET_ASIDE in table.columns:
        return cells(table, SET_ASIDE)
    return [""] * len(next(iter(table.columns.values())))


def decimals_of(*columns: Sequence[Decimal | None], least: int) -> int:
    """Return how many decimals hold all digits of some columns, at least so many."""
    most = least
    for column in columns:
        for value in column:
            if value is not None:
                exponent = value.as_tuple().exponent
                most = max(most, -exponent if isinstance(exponent, int) else 0)
    return most


def left_out(table: Table, held: Sequence[str]) -> tuple[str, ...]:
    """Return the columns that a format which holds these quantities or names has no place for."""
    return tuple(
        name
        for name in table.columns
        if name not in held and not ((angle := angle_of(name)) and angle[0] in held)
    )


#: What every format of azimuth and elevation offsets holds.
OFFSETS_HELD = ("az", "el", "d_az", "d_xel", "d_el", "d_zd", SET_ASIDE)
SIGMAS_HELD = ("sigma_az", "sigma_xel", "sigma_el")


def mount_of(table: Table) -> Mount:
    """Return the mount that a table declares or, where it is silent, that its offsets are of."""
    for word in declared(table.meta):
        if ALSO.get(word, word) in KINDS:
            return KINDS[ALSO.get(word, word)]
    there = {angle[0] for name in table.columns if (angle := angle_of(name))}
    fitting = [one for one in KINDS.values() if names_of(one).offsets & there]
    if PIER_SIDE in table.columns:
        fitting = [one for one in fitting if one.turns_over] or fitting
    return fitting[0] if fitting else ALTAZ


def readings(table: Table, mount: Mount, path: Path) -> tuple[Numbers, ...]:
    """Return both angles of the axes and their offsets, as coordinates, in degrees.

    Raises `BadInput`: the table has no such columns.
    """
    if mount is ALTAZ:
        return (*position(table, path), *offsets(table, path))
    angles = [in_degrees(table, one.column) for one in mount.axes]
    across = _first(table, mount, mount.first.offset, mount.across_column)
    found = (*angles, across, in_degrees(table, mount.second.offset))
    names = [*(one.column for one in mount.axes), *(one.offset for one in mount.axes)]
    lost = [f"{name}_deg" for name, one in zip(names, found, strict=True) if one is None]
    if lost:
        raise BadInput(f"no columns {' and '.join(lost)}, and this format holds them", path)
    return tuple(one for one in found if one is not None)


def sigmas(table: Table, mount: Mount, path: Path) -> tuple[Numbers | None, Numbers | None]:
    """Return the errors of both offsets, as coordinates, in degrees, None for those not there."""
    if mount is ALTAZ:
        return coordinate(table, "sigma_az", "sigma_xel", path), in_degrees(table, "sigma_el")
    first, across, along = names_of(mount).sigmas
    return _first(table, mount, first, across), in_degrees(table, along)


def _first(table: Table, mount: Mount, quantity: str, on_sky: str) -> Numbers | None:
    """Return an angle of the first axis as a coordinate, from one on the sky where there is one."""
    recorded, sky = in_degrees(table, quantity), in_degrees(table, on_sky)
    second = in_degrees(table, mount.second.column)
    if recorded is not None or sky is None or second is None:
        return recorded
    pairs = zip(sky, second, strict=True)
    return [None if one is None or at is None else over_cos(one, at) for one, at in pairs]


def held(mount: Mount, *, sigmas: bool = False) -> tuple[str, ...]:
    """Return the quantities that a format of a mount's angles, offsets and errors holds."""
    if mount is ALTAZ:
        return (*OFFSETS_HELD, *(SIGMAS_HELD if sigmas else ()))
    names = names_of(mount)
    angles = (one.column for one in mount.axes)
    return (*angles, *names.offsets, *(names.sigmas if sigmas else ()), SET_ASIDE)
