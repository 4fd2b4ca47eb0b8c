"""The cells of a column of any table, in the unit that its name tells."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import RADIANS_PER
from pyport.arguments import refusal
from pyport.columns import ANGLES, NUMBER, QUANTITIES, TIME, angle_of
from pyport.errors import BadInput


def in_its_unit(name: str, column: Any) -> tuple[str, NDArray[Any]]:  # noqa: ANN401 - of any table
    """Return a column under the contract's name, in the unit that the name tells.

    Raises `BadInput`: Astropy's unit of the column is none that its name could have.
    """
    if hasattr(column, "utc") and hasattr(column, "unix"):
        when = np.asarray(column.utc.datetime64)
        return (TIME if name == "time" else name), when
    unit = getattr(column, "unit", None)
    if unit is None or not str(unit):
        return name, _cells(name, column)
    told = angle_of(name)
    if name in ANGLES:
        own = "h" if str(unit) == "hourangle" else str(unit)
        own = own if own in RADIANS_PER else "deg"
        wanted, name = _ASTROPY[own], f"{name}_{own}"
    elif told is not None:
        wanted = _ASTROPY[name.rpartition("_")[2]]
    elif name in _QUANTITIES:
        name, wanted = _QUANTITIES[name]
    else:
        wanted = dict(_QUANTITIES.values()).get(name, "")
    return name, _cells(name, column) if not wanted else _converted(name, column, unit, wanted)


#: The contract's units of angle as astropy spells them.
_ASTROPY = {"mdeg": "mdeg", "h": "hourangle"} | {
    one: one for one in RADIANS_PER if one not in {"mdeg", "h"}
}
#: Quantities whose unit is a fixed part of their name: without it -> the name, and the unit.
_QUANTITIES = {
    spoken: (one.spelled, one.quantity) for spoken, one in QUANTITIES.items() if one.kind == NUMBER
}


def _converted(
    name: str,
    column: Any,  # noqa: ANN401 - a column of any table
    unit: object,
    wanted: str,
) -> NDArray[Any]:
    """Return the numbers of a column of astropy's in another unit."""
    from astropy import units

    cells = _cells(name, column)
    try:
        numbers = np.asarray(cells, float)
    except ValueError:
        raise BadInput(f"table: column {name!r} holds text, expected numbers in {unit}") from None
    if str(unit) == wanted:
        return numbers
    try:
        there = units.Unit(str(unit)).to(units.Unit(wanted), numbers, units.temperature())
    except (units.UnitConversionError, ValueError):
        raise BadInput(f"table: column {name!r} is in {unit}, expected {wanted}") from None
    return np.asarray(there, float)


def _cells(name: str, column: Any) -> NDArray[Any]:  # noqa: ANN401 - a column of any table
    """Return a column's cells: numbers or times with NaN or NaT, text with "", for blank.

    Raises `BadInput`: they are none of these, or not one a row.
    """
    if isinstance(column, np.ma.MaskedArray):
        if column.dtype.kind in "iuf":
            return np.asarray(np.ma.filled(column.astype(float), np.nan))
        blank = np.datetime64("NaT") if column.dtype.kind == "M" else ""
        return np.asarray(np.ma.filled(column, blank))
    try:
        cells = np.asarray(column)
        cells = cells.astype(np.str_) if cells.dtype.kind == "S" else cells
    except (TypeError, ValueError):  # cells of different shapes, bytes that are no ASCII
        cells = np.empty((0, 0))
    if cells.ndim != 1 or cells.dtype.kind not in "OUMiufb":
        raise refusal(f"table: column {name!r}", column, "numbers, times or texts, one a row")
    if cells.dtype.kind == "O":
        if any(_many(one) for one in cells.tolist()):
            raise refusal(f"table: column {name!r}", column, "one number, time or text a row")
        return np.array(["" if _blank(one) else str(one) for one in cells.tolist()], np.str_)
    return cells


def _many(cell: object) -> bool:
    """Tell whether a cell holds several things."""
    several = hasattr(cell, "__len__") and not isinstance(cell, str | bytes)
    return several and getattr(cell, "ndim", 1) > 0


def _blank(cell: object) -> bool:
    """Tell whether a cell is None, NaN, NaT or such."""
    return cell is None or cell != cell or str(cell) in {"<NA>", "NaT"}  # noqa: PLR0124
