"""From a pointing model and a refraction to the offsets that a steering system adds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pyport.angles import DEG, Array
from pyport.errors import BadInput
from pyport.pointing import approximate_offsets, exact_offsets, printed, refraction
from pyport.steering.grid import RT32_GRID, Grid, Table

#: (azimuth from south, altitude) [rad] -> (azimuth offset, altitude offset) [rad].
Offsets = Callable[[Array, Array], tuple[Array, Array]]

#: The refraction of a table where none is asked for.
DEFAULT_REFRACTION = "bennett-improved"


def _exact(az_south: Array, altitude: Array) -> tuple[Array, Array]:
    return exact_offsets(az_south, altitude, printed())


def _approximate(az_south: Array, altitude: Array) -> tuple[Array, Array]:
    return approximate_offsets(az_south, altitude, printed())


MODELS: dict[str, Offsets] = {
    "rt32-3model": _exact,
    "rt32-exact": _exact,
    "rt32-approximate": _approximate,
}


def model_named(name: str) -> Offsets:
    """Return a built-in model, or raise `BadInput`."""
    if name not in MODELS:
        raise BadInput(f"no model is called {name!r}; there are {', '.join(MODELS)}")
    return MODELS[name]


def zenith_refraction(name: str, zd_deg: Array) -> Array:
    """Return the refraction R(z) of a table [deg], odd in zenith distance.

    Refraction lifts a source toward the zenith from either side of it: the
    offset -R brings the zenith distance nearer to zero. See
    :func:`pyport.pointing.refraction` for the names.
    """
    altitude = (90 - np.abs(zd_deg)) * DEG
    return np.sign(zd_deg) * refraction(name, altitude) / DEG


def table_offsets(
    offsets: Offsets, refraction_name: str, az_deg: Array, zd_deg: Array
) -> tuple[Array, Array]:
    """Return azimuth and zenith-distance offset [deg] at any points.

    The zenith-distance offset is -dAlt - R(z): altitude turned over, and
    refraction, of which the pointing model knows nothing.
    """
    d_az, d_alt = offsets(np.asarray(az_deg) * DEG, (90 - np.asarray(zd_deg)) * DEG)
    return d_az / DEG, -d_alt / DEG - zenith_refraction(refraction_name, zd_deg)


def tabulate(
    model: str, refraction_name: str = DEFAULT_REFRACTION, grid: Grid = RT32_GRID
) -> Table:
    """Return the table of a model with a refraction.

    Raises
    ------
    BadInput
        There is no such model or refraction.
    """
    az_deg, zd_deg = grid.points_deg()
    d_az_deg, d_zd_deg = table_offsets(model_named(model), refraction_name, az_deg, zd_deg)
    return Table(grid, d_az_deg, d_zd_deg, model, refraction_name)
