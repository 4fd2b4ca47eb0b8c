"""What a model is given by name beside a direction: a time, the weather, labels; with units."""

from __future__ import annotations

import contextlib
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.arguments import SLIP, nearest, refusal
from pyport.columns import LABELS, NUMBER, QUANTITIES, angle_of
from pyport.effects.base import Site
from pyport.errors import BadInput
from pyport.recordings.raw import seconds_of, since_1970

if TYPE_CHECKING:
    from astropy.units import Quantity


@dataclass(frozen=True)
class Value:
    """A coefficient of a completed model for one set of labels, in its unit."""

    #: `name`, `effect`, `unit`: the coefficient, the effect that it belongs to, and the unit of all
    #: its numbers.
    name: str
    effect: str
    unit: str
    #: `value`, `sigma`, `before`: what to enter into the control system; its one-sigma error, None
    #: where it was held; what the model gave before.
    value: float
    sigma: float | None
    before: float
    #: The antenna, session, ... that it holds for; empty where it holds everywhere.
    labels: Mapping[str, str]
    #: The number of the finding that it belongs to, from 1; None for a term of the model.
    finding: int | None
    #: False where the recordings leave it open: the value is then one of many.
    determined: bool

    @property
    def change(self) -> float:
        """Return what the file that was given has to be changed by."""
        return self.value - self.before

    @property
    def quantity(self) -> Quantity:
        """Return the value as astropy's Quantity."""
        from astropy import units

        return units.Quantity(self.value, self.unit)


@dataclass(frozen=True)
class Completed:
    """What is known of a completed model beside its terms."""

    #: What made it, and from what: `by`, `recordings`, `sha256`, `rows`, `model`.
    made: Mapping[str, Any]
    #: Every coefficient, in the order of the model's terms and their labels.
    values: tuple[Value, ...]
    covariance: Array  #: of the values in their units, shape (P, P); zero for what was held
    findings: tuple[Mapping[str, Any], ...] = ()  #: as `report.json` spells them
    unsaved: tuple[str, ...] = ()  #: ids of terms that no file can hold: they were made in Python
    #: How many offsets it was fitted to; None for a model from a file, that knows `rows` only.
    offsets: int | None = None

    @property
    def undetermined(self) -> str | None:
        """Return that it was fitted to fewer offsets than coefficients; None where it was not."""
        fitted = sum(one.sigma is not None and one.finding is None for one in self.values)
        rows = self.made.get("rows")
        both = 2 * rows if isinstance(rows, int) else fitted
        return undetermined(both if self.offsets is None else self.offsets, fitted)


def undetermined(offsets: int, coefficients: int) -> str | None:
    """Return that so few offsets cannot determine so many coefficients; None where they can."""
    if offsets >= coefficients:
        return None
    return f"{offsets} measured offsets cannot determine {coefficients} coefficients"


#: The contract's names, unit and all: bare numbers in that unit.
_SPELLED = {one.spelled: spoken for spoken, one in QUANTITIES.items() if one.kind == NUMBER}
_PLAIN = frozenset({"scan_direction"})
_TIMES = frozenset({"time", "time_utc"})
NAMES = frozenset({*QUANTITIES, *_SPELLED, *_PLAIN, *_TIMES, *LABELS, "location"})

Columns = dict[str, NDArray[Any]]


def known(name: str) -> bool:
    """Tell whether a condition is called so."""
    angle = angle_of(name)
    return name in NAMES or (angle is not None and angle[0] in QUANTITIES)


def columns_of(given: Mapping[str, Any], others: Collection[str] = ()) -> Columns:
    """Return what was given by name as columns of the program, scalars of shape ().

    `others` are further columns that may be given as bare numbers.

    Raises `BadInput`: a name is none, or its value is no number, unit or time that it can be.
    """
    return {
        name: column for key, value in given.items() for name, column in [_one(key, value, others)]
    }


def _one(
    key: str,
    value: Any,  # noqa: ANN401 - whatever is given
    others: Collection[str],
) -> tuple[str, NDArray[Any]]:
    if key in _TIMES:
        return "time", seconds(value)
    if key in LABELS:
        return key, _cells(key, value).astype(str)
    if key in _PLAIN:
        return key, _numbers(key, value)
    name = _SPELLED.get(key, key)
    angle = angle_of(key)
    if angle is not None and angle[0] in QUANTITIES:
        name = angle[0]
    if name in QUANTITIES:
        column = QUANTITIES[name]
        scale = column.scale
        if angle is not None and not has_unit(value):
            scale = angle[1]
        return column.name, _in_unit(key, value, column.quantity) * scale
    if key in others:
        return key, _numbers(key, value)
    near = nearest(key, sorted(NAMES | set(others)))
    meant = f"did you mean {near!r}?" if near else f"known are {', '.join(sorted(NAMES))}"
    raise BadInput(f"no condition is called {key!r}: {meant}")


def refuse_slips(names: Collection[str], others: Collection[str]) -> None:
    """Refuse names that are nearly those of conditions, or of `others`, and are none.

    Raises `BadInput`: with the condition that may be meant.
    """
    for name in sorted(names):
        near = nearest(name.lower(), sorted(NAMES | set(others)), SLIP)
        if near and not known(name):
            raise BadInput(f"--set {name}: no condition is called so, did you mean {near!r}?")


def has_unit(value: Any) -> bool:  # noqa: ANN401 - whatever is given
    """Tell whether a value is a Quantity, or a column that has a unit."""
    return getattr(value, "unit", None) is not None


def _cells(key: str, value: Any) -> NDArray[Any]:  # noqa: ANN401 - whatever is given
    """Return a text or a time, or arrays of them; a Quantity and what has no shape are neither."""
    with contextlib.suppress(TypeError, ValueError):
        if not has_unit(value):
            return np.asarray(value)
    raise BadInput(f"{key} is {value!r:.60}, expected one text or time, or an array of them")


def _numbers(key: str, value: Any) -> NDArray[np.float64]:  # noqa: ANN401 - whatever is given
    if has_unit(value) and str(value.unit):
        raise BadInput(f"{key} is in {value.unit}, expected a bare number")
    try:
        return np.asarray(value).astype(float)
    except (TypeError, ValueError):
        raise BadInput(f"{key} is {value!r:.60}, expected a number") from None


def _in_unit(key: str, value: Any, unit: str) -> NDArray[np.float64]:  # noqa: ANN401
    """Return a quantity, or a bare number, in a unit."""
    if not has_unit(value):
        return _numbers(key, value)
    from astropy import units

    try:
        converted = units.Quantity(value).to_value(unit, equivalencies=units.temperature())
    except units.UnitConversionError:
        raise BadInput(f"{key} is in {value.unit}, expected {unit}") from None
    return np.asarray(converted, float)


def seconds(value: Any) -> NDArray[np.float64]:  # noqa: ANN401 - a time of any kind
    """Return times as seconds UTC since 1970.

    `value`: astropy `Time`, numpy `datetime64`, `datetime`, ISO 8601 text, or arrays of them.
    Raises `BadInput`: it is none of them: a bare number could be counted from anything.
    """
    if hasattr(value, "utc") and hasattr(value, "unix"):
        return np.asarray(value.utc.unix, float)
    cells = _cells("time", value)
    if cells.dtype.kind == "M":
        return since_1970(cells)
    if cells.dtype.kind in "UO":
        return np.array([_moment(one) for one in cells.ravel().tolist()]).reshape(cells.shape)
    wanted = "expected astropy's Time, datetime64, datetime or ISO 8601 text"
    raise BadInput(f"time is {value!r:.40}, {wanted}")


def _moment(one: Any) -> float:  # noqa: ANN401 - a time of any kind
    if isinstance(one, str | datetime):
        with contextlib.suppress(ValueError):
            return seconds_of(one)
    raise BadInput(f"time is {one!r:.40}, expected ISO 8601")


def site_of(location: Any) -> Site | None:  # noqa: ANN401 - astropy is not typed
    """Return the site that an astropy `EarthLocation` is, None for None."""
    if location is None or isinstance(location, Site):
        return location
    if not hasattr(location, "to_geodetic"):
        raise refusal("location", location, "astropy's EarthLocation")
    place = location.to_geodetic()
    return Site(
        float(place.lat.to_value("rad")),
        float(place.lon.to_value("rad")),
        float(place.height.to_value("m")),
    )


def location_of(site: Site | None) -> Any:  # noqa: ANN401 - astropy is not typed
    """Return a site as astropy's `EarthLocation`.

    Raises `BadInput`: there is none, or it has no longitude.
    """
    if site is None or site.longitude is None:
        raise BadInput("the telescope's place is not known: give location=EarthLocation(...)")
    from astropy import units
    from astropy.coordinates import EarthLocation

    return EarthLocation.from_geodetic(
        site.longitude * units.rad, site.latitude * units.rad, site.height_m * units.m
    )
