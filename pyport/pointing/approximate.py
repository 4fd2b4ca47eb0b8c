"""The RT32's approximate model: a sum of effects, linear in its twelve coefficients."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from pyport.angles import Array
from pyport.effects import CATALOGUE, Circumstances, Effect
from pyport.effects.telescope.structure import subreflector_jump
from pyport.pointing import swift
from pyport.pointing.jump import jump_altitude
from pyport.pointing.parameters import PARAMETERS

#: The jump above the RT32's curve, as an effect of the common vocabulary.
RT32_JUMP = subreflector_jump(
    lambda az_north: jump_altitude(az_north - math.pi), "the RT32's curve Hjump"
)


def effect_of(number: int) -> Effect:
    """Return the effect that p1..p12 (`number` 1 to 12) is a coefficient of."""
    name = PARAMETERS[number - 1].effect
    return RT32_JUMP if name == RT32_JUMP.id else CATALOGUE[name]


def approximate_columns(at: Circumstances) -> tuple[Array, Array]:
    """Return the offsets for one radian of each of p1..p12, eqs. 18 and 19.

    Parameters
    ----------
    at
        n pointings, azimuth from north through east. Elevations above pi/2 point
        in plunge; there the routine ModelA turns the tilt's sign in altitude.

    Returns
    -------
    x, y
        Offsets across and along elevation [rad/rad], shape (n, 12).
    """
    x, y = np.empty((2, len(at), len(PARAMETERS)))
    effects = {one.effect: effect_of(i + 1) for i, one in enumerate(PARAMETERS)}
    columns = {name: effect.columns(at) for name, effect in effects.items()}
    for i, parameter in enumerate(PARAMETERS):
        across, along = columns[parameter.effect]
        x[:, i] = parameter.sign * across[:, parameter.column]
        y[:, i] = parameter.sign * along[:, parameter.column]
    tilts = [i for i, parameter in enumerate(PARAMETERS) if parameter.effect == "tilt"]
    y[:, tilts] *= np.where(at.el > math.pi / 2, -1.0, 1.0)[:, None]
    y[at.el < 0, -1] = 1.0  # p12: what Hjump answers below the horizon is taken for a yes
    return x, y


def approximate_offsets(
    az_south: ArrayLike, altitude: ArrayLike, p: ArrayLike
) -> tuple[Array, Array]:
    """Return the offsets of routine ModelA, encoder minus true [rad].

    Arguments and result as in :func:`pyport.pointing.exact.exact_offsets`. Not to
    be used within about 0.1 deg of the zenith. The same as the columns above times p,
    for many points.
    """
    return swift.approximate(az_south, altitude, p)
