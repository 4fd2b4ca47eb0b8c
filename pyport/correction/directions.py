"""Directions in whatever form they are given: numbers, Quantities, astropy coordinates, tables."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pyport.angles import DEG, Array
from pyport.effects import Site
from pyport.errors import BadInput
from pyport.models.conditions import Columns, columns_of, has_unit, location_of, site_of
from pyport.mounts import ALTAZ, Mount


@dataclass(frozen=True)
class Pointing:
    """Directions as they were given: radians, shape, and what gives the answer its form."""

    #: `az`, `el`: from north through east, and up [rad], shape (n,).
    az: Array
    el: Array
    shape: tuple[int, ...]  #: of the answer
    #: `columns`, `site`: what is known beside the direction, shape (n,) each.
    columns: Columns
    site: Site | None
    frame: Any = None  #: astropy's, of which the answer is one, too; None for numbers
    mount: Mount = ALTAZ  #: whose readings they are, where a file says it; else the model's


def directions(
    where: tuple[Any, ...],
    conditions: Mapping[str, Any],
    site: Site | None,
    others: Collection[str] = (),
) -> Pointing:
    """Return directions as they were given, in radians.

    `where`: azimuth and elevation; one coordinate of astropy's; or one table.
    `conditions`: what is known beside them, by name, `location` among it.
    `site`: where the telescope stands, if nothing else tells.
    `others`: columns beyond the contract's that `conditions` may name.
    Raises `BadInput`: something is not what it can be; the message says what was expected.
    """
    known = dict(conditions)
    site = site_of(known.pop("location", None)) or site
    if len(where) == 2:
        return _numbers(where, known, site, others)
    if len(where) != 1:
        raise BadInput("expected azimuth and elevation, a coordinate, or a table")
    if hasattr(where[0], "transform_to"):
        return _coordinate(where[0], known, site, others)
    return _table(where[0], known, site, others)


def _numbers(
    where: tuple[Any, ...],
    known: Mapping[str, Any],
    site: Site | None,
    others: Collection[str],
    frame: Any = None,  # noqa: ANN401 - astropy is not typed
) -> Pointing:
    columns = columns_of(known, others)
    angles = [_radians(name, one) for name, one in zip(("az", "el"), where, strict=True)]
    try:
        az, el, *rest = np.broadcast_arrays(*angles, *columns.values())
    except ValueError:
        raise BadInput("azimuth, elevation and conditions have shapes that do not fit") from None
    spread = {name: one.ravel() for name, one in zip(columns, rest, strict=True)}
    return Pointing(az.ravel(), el.ravel(), az.shape, spread, site, frame)


def _coordinate(
    one: Any,  # noqa: ANN401 - astropy is not typed
    known: dict[str, Any],
    site: Site | None,
    others: Collection[str],
) -> Pointing:
    """Return the directions of an astropy coordinate at its time and place, or those given."""
    from astropy.coordinates import AltAz, SkyCoord
    from astropy.time import Time

    frame = one.frame if isinstance(one, SkyCoord) else one
    if not isinstance(frame, AltAz):
        if "time" not in known:
            raise BadInput(f"{frame.name} coordinates need a time: give time=Time(...)")
        when = Time(columns_of({"time": known["time"]})["time"], format="unix")
        frame = frame.transform_to(AltAz(obstime=when, location=location_of(site)))
    if frame.location is not None:
        site = site_of(frame.location)
    if frame.obstime is not None:
        known.setdefault("time", frame.obstime)
    return _numbers((frame.az, frame.alt), known, site, others, frame)


def _table(
    table: Any,  # noqa: ANN401 - a table of any kind
    known: Mapping[str, Any],
    site: Site | None,
    others: Collection[str],
) -> Pointing:
    from pyport.recordings.from_table import raw_table
    from pyport.recordings.interpret import targets

    at = targets(raw_table(table))
    n = len(at)
    given = columns_of(known, others)
    columns = dict(at.columns) | {key: np.broadcast_to(one, n) for key, one in given.items()}
    return Pointing(at.az, at.el, (n,), columns, at.site or site)


def _radians(name: str, value: Any) -> Array:  # noqa: ANN401 - a Quantity or numbers
    """Return an angle in radians; bare numbers are degrees."""
    if has_unit(value):
        from astropy import units

        try:
            return np.asarray(units.Quantity(value).to_value(units.rad), float)
        except units.UnitConversionError:
            raise BadInput(f"{name} is in {value.unit}, expected an angle") from None
    try:
        return np.asarray(value, float) * DEG
    except (TypeError, ValueError):
        raise BadInput(f"{name} is {value!r:.60}, expected degrees or a Quantity") from None


def formed(there: Pointing, az: Array, el: Array) -> Any:  # noqa: ANN401 - as it was given
    """Return directions [rad] in the form that they were given in."""
    from astropy import units

    angles = [one.reshape(there.shape) / DEG * units.deg for one in (az, el)]
    if there.frame is None:
        return angles[0], angles[1]
    from astropy.coordinates import AltAz

    frame = there.frame
    return AltAz(az=angles[0], alt=angles[1], obstime=frame.obstime, location=frame.location)
