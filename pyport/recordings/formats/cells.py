"""The cells of a column of any table, in the unit that its name tells; how tables spell units."""

from __future__ import annotations

import re
from collections.abc import Sequence
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
    # an astropy difference of times has no `unix`, and fails when asked for `utc`
    if hasattr(column, "unix") and hasattr(column, "utc"):
        when = np.asarray(column.utc.datetime64)
        when = np.where(getattr(column, "mask", False), np.datetime64("NaT"), when)
        return (TIME if name == "time" else name), when
    unit = getattr(column, "unit", None)
    if unit is None or not str(unit):
        return name, _cells(name, column)
    angle = angle_of(name)
    if name in ANGLES:
        own = "h" if str(unit) == "hourangle" else str(unit)
        own = own if own in RADIANS_PER else "deg"
        wanted, name = _ASTROPY[own], f"{name}_{own}"
    elif angle is not None:
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


#: Of a German file degrees, elsewhere gon: whoever maps the column decides.
GRAD = "grad"
#: Units of angle that the contract has no column in: they are recognised to be refused.
_UNKNOWN = (
    *("urad", "µrad", "mrad", "mas", "marcsec", "uas", "uarcsec", "mdegs"),
    *("gon", "gons", "gradian", "gradians", "grade", "grades", "mgon", "cc", GRAD, "grads"),
    *("grados", "gradi", "graden", "degré", "degrés", "bogenminuten", "bogensekunden"),
    *("turn", "turns", "rev", "revs", "cycles", "hms"),
)
#: Other units in the brackets of a column's name, which no angle is in.
_NO_ANGLES = frozenset(
    (
        *("s", "sec", "secs", "second", "seconds", "min", "mins", "minute", "minutes", "d", "m"),
        *("mm", "cm", "um", "v", "mv", "pix", "pixel", "pixels", "px", "beam", "beams", "hpbw"),
        *("count", "counts", "cts", "step", "steps", "tick", "ticks", "pulses", "bit", "bits"),
    )
)
#: Units of angle as tables spell them -> as the contract does.
_SPELLED = {
    **dict.fromkeys(("deg", "degs", "degree", "degrees", "°"), "deg"),
    **dict.fromkeys(("arcmin", "arcmins", "arcminutes", "'"), "arcmin"),
    **dict.fromkeys(("arcsec", "arcsecs", "arcseconds", '"', "''"), "arcsec"),
    **dict.fromkeys(("mdeg", "millideg"), "mdeg"),
    **dict.fromkeys(("rad", "rads", "radian", "radians"), "rad"),
    **dict.fromkeys(("h", "hours", "hourangle"), "h"),
    **{one: one for one in _UNKNOWN},
}
#: Other things that stand in a line of units.
_OTHERS = frozenset(
    (
        *("-", "--", "utc", "ut", "ut1", "tai", "mjd", "jd", "d", "day", "days", "min", "s", "sec"),
        *("k", "c", "degc", "°c", "f", "hpa", "mbar", "mb", "pa", "%", "pct", "m", "mm", "um"),
        *("cm", "m/s", "km/h", "hz", "mhz", "ghz", "jy", "mjy", "mjy/beam", "v", "mv", "db"),
    )
)
_BRACKETS = re.compile(r"\s*[\[(][^\[\]()]*[\])]$")
#: Units that names end in; letters before `rad` would be another word.
_ENDING = re.compile(r"(arcsec|arcmin|mdeg|deg|(?<![a-z])[um]?rad)$")


def angle_unit(text: str) -> str:
    """Return a unit of angle as the contract spells it, "" where a text is none."""
    return _SPELLED.get(text.strip().lower(), "")


def name_and_unit(name: str) -> tuple[str, str]:
    """Return a column's name in small letters, without brackets and unit of angle; and the unit."""
    plain = name.strip().lower()
    unit = in_brackets(plain)
    plain = _BRACKETS.sub("", plain)
    ending = None if unit else _ENDING.search(plain)
    return (plain, unit) if ending is None else (plain[: ending.start()], ending[0])


def bracketed(name: str) -> str:
    """Return what stands in brackets at the end of a name, "" for nothing."""
    found = _BRACKETS.search(name.strip())
    return "" if found is None else found[0].strip(" []()")


def in_brackets(text: str) -> str:
    """Return the unit of angle that stands in brackets in a text, "" for none.

    Without one, return what else there is a unit, or has one of angle among its words.
    """
    stated = re.findall(r"[\[(]([^\[\]()]*)[\])]", text)
    others = filter(_is_unit, (one.strip().lower() for one in stated))
    return next(filter(None, map(angle_unit, stated)), "") or next(others, "")


def _is_unit(text: str) -> bool:
    """Tell whether a text is a unit, or has one of angle among its words: not `d m s`."""
    words = set(text.split())
    return text in _NO_ANGLES or (bool(words & _SPELLED.keys()) and not words & _NO_ANGLES)


def unit_missed(name: str, stated: str) -> str:
    """Return the unit of a number of the contract where a table tells another of the same kind.

    "" where it tells none, or one that Astropy does not know or takes for something else.
    """
    wanted = dict(_QUANTITIES.values()).get(name, "")
    if not wanted or not stated:
        return ""
    from astropy import units

    theirs, ours = units.Unit(stated, parse_strict="silent"), units.Unit(wanted)
    alike = theirs.is_equivalent(ours, units.temperature())
    return wanted if alike and theirs != ours else ""


def are_units(cells: Sequence[str]) -> bool:
    """Tell whether the cells of a line are units or blank, and some of them those of angles."""
    plain = {cell.strip().strip("[]()").strip().lower() for cell in cells}
    return bool(plain & _SPELLED.keys()) and plain <= _SPELLED.keys() | _OTHERS | {""}


def joined(line: str) -> str:
    """Return a line of names that blanks separate with each unit joined to its name."""
    return re.sub(
        r"(?<=[^\s\])])\s+([\[(]\s*[^\s\[\]()]*\s*[\])])",
        lambda found: found[1] if in_brackets(found[1]) else found[0],
        line,
    )
