"""From a pointing model and a refraction to the offsets that a steering system adds."""

from __future__ import annotations

import math

import numpy as np

from pyport.angles import DEG, Array
from pyport.errors import BadInput
from pyport.pointing import (
    approximate_offsets,
    exact_offsets,
    printed,
    recovered,
    refraction,
)
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


def tabulate(
    model: str = "rt32-3model",
    refraction_name: str | None = None,
    grid: Grid = RT32_GRID,
    reading: str = "as-written",
) -> Table:
    """Return the table of a model with a refraction.

    Parameters
    ----------
    model
        `rt32-3model`, `rt32-exact` or `rt32-approximate`, azimuth from south through west;
        or any other model with coefficients (a TOML file), azimuth from north through east.
    refraction_name
        One of :data:`pyport.pointing.FORMULAE`; by default the RT32's own for its models
        and Bennett's for others.
    grid
        Where.
    reading
        One of :data:`READINGS`, for the RT32's models; others are computed in float64.

    Raises
    ------
    BadInput
        There is no such model or refraction, or the model lacks coefficients.
    """
    az_deg, zd_deg = grid.points_deg()
    if model in _RT32:
        parameters, exact = _RT32[model]
        name = refraction_name or DEFAULT_REFRACTION
        offsets = rt32_offsets(az_deg, zd_deg, parameters(), name, reading, exact=exact)
    else:
        name = refraction_name or STANDARD_REFRACTION
        d_az_deg, d_alt_deg = _offsets_of(model, az_deg, zd_deg)
        offsets = d_az_deg, -d_alt_deg - zenith_refraction(name, zd_deg)
    return Table(grid, *offsets, model=model, refraction=name)


def zenith_refraction(name: str, zd_deg: Array) -> Array:
    """Return the refraction R(z) of a table [deg], odd in zenith distance.

    Refraction lifts a source toward the zenith from either side of it: the
    offset -R brings the zenith distance nearer to zero. See
    :func:`pyport.pointing.refraction` for the names.
    """
    altitude = (90 - np.abs(zd_deg)) * DEG
    return np.sign(zd_deg) * refraction(name, altitude) / DEG


def rt32_offsets(
    az_deg: Array, zd_deg: Array, p: Array, refraction_name: str, reading: str, *, exact: bool
) -> tuple[Array, Array]:
    """Return azimuth and zenith-distance offset [deg] of the RT32 at any points.

    The zenith-distance offset is -dAlt - R(z): altitude turned over, and
    refraction, of which the pointing model knows nothing.

    Parameters
    ----------
    az_deg, zd_deg
        Azimuth from south through west and zenith distance [deg], of one shape.
    p
        p1..p12 [rad].
    refraction_name, reading
        As for :func:`tabulate`.
    exact
        The exact form, or the approximate one.
    """
    if reading == "float64":
        form = exact_offsets if exact else approximate_offsets
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
    if reading == "as-written":
        az_deg = np.vectorize(as_written.wrapped_deg, otypes=[float])(az_deg)
    exact_form = as_written.exact4 if reading == "as-written" else legacy.model
    routine = exact_form if exact else legacy.modela

    heights, which = np.unique(zd_deg, return_inverse=True)
    if refraction_name == DEFAULT_REFRACTION:
        lifts = np.array([as_written.refraction4(zd) for zd in heights], real4)
    else:
        lifts = zenith_refraction(refraction_name, heights).astype(real4)

    p4 = list((p / DEG).astype(real4))
    az4, alt4 = (az_deg * DEG).astype(real4), ((90 - zd_deg) * DEG).astype(real4)
    offsets = np.empty((2, az4.size), real4)
    with np.errstate(all="ignore"):
        for i, (az, alt) in enumerate(zip(az4.flat, alt4.flat, strict=True)):
            offsets[:, i] = routine(az, alt, p4)
    d_az, d_alt = offsets.reshape(2, *az4.shape)
    return d_az.astype(float), (-d_alt - lifts[which].reshape(d_alt.shape)).astype(float)


def _offsets_of(model: str, az_deg: Array, zd_deg: Array) -> tuple[Array, Array]:
    """Return azimuth and altitude offset [deg] of any model of the program with coefficients."""
    from pyport.effects import Circumstances, MissingColumn
    from pyport.fitting import models

    loaded = models.load(model)
    if loaded.given is None and all(term.values is None for term in loaded.terms):
        raise BadInput(f"model {model!r} has no coefficients to make a table from")
    at = Circumstances(az=az_deg.ravel() * DEG, el=math.pi / 2 - zd_deg.ravel() * DEG)
    try:
        x, y = loaded.offsets(at)
    except MissingColumn as lack:
        raise BadInput(
            f"model {model!r} needs {lack.column}, which a table of azimuth and zenith "
            "distance does not have"
        ) from None
    shape = az_deg.shape
    return (x / np.cos(at.el)).reshape(shape) / DEG, y.reshape(shape) / DEG
