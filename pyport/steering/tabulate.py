"""From a pointing model and a refraction to the offsets that a steering system adds."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array
from pyport.effects.base import Site
from pyport.effects.sky.atmosphere import ITERATIONS, mean_refraction
from pyport.errors import BadInput
from pyport.mounts import turned
from pyport.pointing import exact_offsets, kernel, printed, recovered, swift
from pyport.steering.grid import RT32_GRID, Grid, Table

#: The refraction of the RT32's tables, and what others take where none is asked for.
DEFAULT_REFRACTION = "rt32-table"
STANDARD_REFRACTION = "bennett-improved"

#: How a table of the RT32 can be computed: as the program did that wrote the published one;
#: by the routines as printed, azimuth as the cable has it; or in double precision throughout.
READINGS = ("as-written", "routine", "float64")

#: The RT32's models: their parameters, and whether the form is the exact one.
_RT32 = {
    "rt32-3model": (recovered, True),
    "rt32-exact": (printed, True),
    "rt32-approximate": (printed, False),
}


#: So near to the zenith the exact form alone says where azimuth goes [deg].
BLIND_DEG = 0.1


@dataclass(frozen=True)
class Conditions:
    """What a table holds for: `north` or `south`, where azimuth starts, conditions, and the site.

    `azimuth_zero`: None for the model's own: south for the RT32's.
    `columns`: conditions under the names of columns inside the program: `temperature_c`, ...
    `site`: None for the model's own.
    """

    azimuth_zero: str | None = None
    columns: Mapping[str, Any] = field(default_factory=dict)
    site: Site | None = None


NOTHING = Conditions()

#: Azimuth and zenith distance [deg] -> their offsets [deg].
OffsetsDeg = Callable[[Array, Array], tuple[Array, Array]]


def tabulate(
    model: str = "rt32-3model",
    refraction_name: str | None = None,
    grid: Grid = RT32_GRID,
    reading: str = "as-written",
    beside: Conditions = NOTHING,
) -> Table:
    """Return the table of a model with a refraction.

    Parameters
    ----------
    model
        `rt32-3model`, `rt32-exact` or `rt32-approximate`, or one of them completed by a fit or
        a diagnosis (a TOML file), azimuth from south through west; or any other model with
        coefficients, azimuth from north through east.
    refraction_name
        One of :data:`pyport.effects.sky.atmosphere.FORMULAE`; by default the RT32's own for its
        models and Bennett's for others.
    grid
        Where.
    reading
        One of :data:`READINGS`, for the RT32's models; others are computed in float64. What
        completes a model is added to what the reading gives.
    beside
        Where azimuth is counted from, and the conditions that the whole table is for.

    Raises
    ------
    BadInput
        There is no such model, refraction or reading, or the model lacks coefficients.
    """
    base = base_of(model)
    if base in _RT32 and beside.azimuth_zero == "north":
        raise BadInput(
            f"{base} counts azimuth from south, expected no azimuth zero at north", model
        )
    if base not in _RT32:
        reading = "float64"
    name = refraction_name or (DEFAULT_REFRACTION if base in _RT32 else STANDARD_REFRACTION)
    offsets = offsets_of(model, name, reading, beside)(grid.az_deg[:, None], grid.zd_deg[None, :])
    return Table(grid, *offsets, model, name, reading)


def base_of(model: str) -> str:
    """Return the model of the RT32 that a model is or completes, "" for any other."""
    if model in _RT32:
        return model
    from pyport.formats import models

    return models.load(model).base


def offsets_of(
    model: str, refraction_name: str, reading: str, beside: Conditions = NOTHING
) -> OffsetsDeg:
    """Return a model as a function of azimuth and zenith distance; arguments as for `tabulate`."""
    if model in _RT32:
        return lambda az_deg, zd_deg: _published(model, az_deg, zd_deg, refraction_name, reading)
    return lambda az_deg, zd_deg: _any_offsets(
        model, refraction_name, reading, beside, az_deg, zd_deg
    )


def _published(
    name: str, az_deg: Array, zd_deg: Array, refraction_name: str, reading: str
) -> tuple[Array, Array]:
    """Return the offsets [deg] of one of the RT32's models with a refraction."""
    parameters, exact = _RT32[name]
    return rt32_offsets(az_deg, zd_deg, parameters(), refraction_name, reading, exact=exact)


def zenith_refraction(name: str, zd_deg: Array, iterations: int = ITERATIONS) -> Array:
    """Return the refraction R(z) of a table [deg], odd in zenith distance.

    Refraction lifts a source toward the zenith from either side of it: the
    offset -R brings the zenith distance nearer to zero. See
    :func:`pyport.effects.sky.atmosphere.refraction` for the names and the iterations.
    """
    altitude = (90 - np.abs(zd_deg)) * DEG
    return np.sign(zd_deg) * mean_refraction(name, altitude, iterations) / DEG


def rt32_offsets(
    az_deg: Array, zd_deg: Array, p: Array, refraction_name: str, reading: str, *, exact: bool
) -> tuple[Array, Array]:
    """Return azimuth and zenith-distance offset [deg] of the RT32 at any points.

    The zenith-distance offset is -dAlt - R(z): altitude turned over, and
    refraction, of which the pointing model knows nothing.

    `az_deg`, `zd_deg`: azimuth from south through west and zenith distance [deg], of shapes that
      broadcast: a grid is computed quickest from its two axes.
    `p`: p1..p12 [rad].
    `refraction_name`, `reading`: as for :func:`tabulate`.
    `exact`: the exact form, or the approximate one.
    """
    if reading == "float64":
        form = exact_offsets if exact else swift.approximate
        d_az, d_alt = form(az_deg * DEG, (90 - zd_deg) * DEG, p)
        return d_az / DEG, -d_alt / DEG - zenith_refraction(refraction_name, zd_deg)
    if reading not in READINGS:
        raise BadInput(f"no reading is called {reading!r}; there are {', '.join(READINGS)}")
    return _single_precision(az_deg, zd_deg, p, refraction_name, reading, exact=exact)


def _single_precision(
    az_deg: Array, zd_deg: Array, p: Array, refraction_name: str, reading: str, *, exact: bool
) -> tuple[Array, Array]:
    """Return the offsets with the roundings of the routines, point by point."""
    from pyport import legacy
    from pyport.steering import as_written

    real4 = np.float32
    lift = refraction4(refraction_name, zd_deg)
    if reading == "as-written" and exact:
        compiled = kernel.table_offsets(p / DEG, az_deg, zd_deg, lift.astype(float))
        if compiled is not None:
            return compiled
    p4 = list((p / DEG).astype(real4))
    if reading == "as-written":
        az_deg = as_written.each(as_written.wrapped_deg, az_deg)
    az4, alt4 = (az_deg * DEG).astype(real4), ((90 - zd_deg) * DEG).astype(real4)
    with np.errstate(all="ignore"):
        if reading == "as-written" and exact:
            d_az, d_alt = _each_azimuth_once(az4, alt4, p4)
        else:
            routine = legacy.model if exact else legacy.modela
            one = np.vectorize(lambda az, alt: routine(az, alt, p4), otypes=[real4, real4])
            d_az, d_alt = one(az4, alt4)
    return d_az.astype(float), (-d_alt - lift).astype(float)


def _each_azimuth_once(
    az4: NDArray[np.float32], alt4: NDArray[np.float32], p4: list[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the offsets of a grid given by its axes; wrapped, azimuths a turn apart are one."""
    from pyport.steering import as_written

    if az4.shape[1:] != (1,):
        return as_written.exact4(az4, alt4, p4)
    once, which = np.unique(az4[:, 0], return_inverse=True)
    d_az, d_alt = as_written.exact4(once[:, None], alt4, p4)
    return d_az[which], d_alt[which]


def refraction4(name: str, zd_deg: Array) -> NDArray[np.float32]:
    """Return the refraction R(z) [deg] in REAL*4, the RT32's own as its program computed it."""
    from pyport.steering import as_written

    if name != DEFAULT_REFRACTION:
        return zenith_refraction(name, zd_deg).astype(np.float32)
    heights, which = np.unique(zd_deg, return_inverse=True)
    lifts = np.array([as_written.refraction4(zd) for zd in heights], np.float32)
    return lifts[which].reshape(np.shape(zd_deg))


def _any_offsets(
    model: str,
    refraction_name: str,
    reading: str,
    beside: Conditions,
    az_deg: Array,
    zd_deg: Array,
) -> tuple[Array, Array]:
    """Return the offsets [deg] of any model of the program that has coefficients."""
    from pyport.effects import Circumstances
    from pyport.formats import models

    loaded = models.load(model)
    if loaded.leans:
        wanted = "expected a model of azimuth and elevation"
        raise BadInput(f"the first axis of the model {model!r} leans (phi), {wanted}")
    if loaded.given is None and not any(term.has_values for term in loaded.terms):
        raise BadInput(f"model {model!r} has no coefficients to make a table from")
    if loaded.completed is not None and (wrong := loaded.completed.undetermined):
        raise BadInput(f"model {model!r} is not determined: {wrong}")
    if loaded.base in _RT32:
        d_az_deg, d_zd_deg = _published(loaded.base, az_deg, zd_deg, refraction_name, reading)
    else:
        d_az_deg, d_zd_deg = np.zeros(()), -zenith_refraction(refraction_name, zd_deg)
    az_deg, zd_deg = np.broadcast_arrays(az_deg, zd_deg)
    south = loaded.base in _RT32 if beside.azimuth_zero is None else beside.azimuth_zero == "south"
    turn = math.pi if south else 0.0
    at = Circumstances(
        az=az_deg.ravel() * DEG + turn,
        el=math.pi / 2 - zd_deg.ravel() * DEG,
        site=beside.site,
        columns={name: np.full(az_deg.size, one) for name, one in beside.columns.items()},
    )
    try:
        x, y = replace(loaded, given=None).offsets_on_sky(at)
    except BadInput as error:
        wanted = "a table of azimuth and zenith distance is for one condition: --set COLUMN=VALUE"
        raise BadInput(f"{error.message}; {wanted}", model) from None
    more_az_deg = (turned(x, at.el) / DEG).reshape(az_deg.shape)
    if loaded.base in _RT32:  # near the zenith its form has turned by a quarter already
        more_az_deg = np.where(np.abs(zd_deg) < BLIND_DEG, 0.0, more_az_deg)
    return d_az_deg + more_az_deg, d_zd_deg - (y / DEG).reshape(az_deg.shape)
