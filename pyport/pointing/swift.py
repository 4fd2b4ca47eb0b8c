"""The RT32's offsets for many points: sines once an axis, and no more arcs than the geometry needs.

The formulae are those of `exact` and `approximate`, rearranged so that every
point costs two arctangents and an arcsine (the approximate form: none) and a
few dozen products. Azimuths are counted from where the mount leans: a lean has
then one component. Work goes block by block, so that what stands between the
first sine and the offset stays in the processor's cache. A grid is given by its
two axes, azimuths (n, 1) and altitudes (m,): its sines are those of the axes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from pyport.angles import Array, wrap
from pyport.pointing import kernel
from pyport.pointing.jump import has_jumped, jump_altitude
from pyport.pointing.leaning import Axis, Leaning

#: Points of a block, and arrays that its work needs: together they fit into a core's second cache.
BLOCK, _ROOMS = 16384, 10


#: Columns that are not all zero, (n,) each, by the number of their parameter, counted from zero.
Columns = dict[int, Array]
#: (azimuth from where the mount leans, altitude, parameters, the two offsets' place, room to
#: work) -> None; what depends on both angles is written.
_Form = Callable[[Axis, Axis, Leaning, tuple[Array, Array], Array], None]


def exact(az_south: ArrayLike, altitude: ArrayLike, p: ArrayLike) -> tuple[Array, Array]:
    """Return what :func:`pyport.pointing.exact.exact_offsets` does, within 1e-15/cos(alt) rad."""
    return _by_blocks(_exact, az_south, altitude, Leaning.of(p, exact=True))


def approximate(az_south: ArrayLike, altitude: ArrayLike, p: ArrayLike) -> tuple[Array, Array]:
    """Return what :func:`pyport.pointing.approximate.approximate_offsets` does."""
    return _by_blocks(_approximate, az_south, altitude, Leaning.of(p, exact=False))


def approximate_columns(az: Axis, alt: Axis) -> tuple[Columns, Columns]:
    """Return the offsets on the sky for one radian of each parameter, across and along, (n,) each.

    What :func:`pyport.pointing.approximate.approximate_columns` adds up from its effects, of the
    parameters that an axis has anything of.
    """
    double_sine, double_cosine = 2 * az.sine * az.cosine, 1 - 2 * az.sine * az.sine
    facing = np.where(alt.angle > np.pi / 2, -1.0, 1.0)
    one, jumped = np.ones(len(az.angle)), has_jumped(az.angle, alt.angle).astype(float)
    across = {0: alt.cosine, 2: alt.sine, 3: one}
    across |= {4: az.sine * alt.sine, 5: -az.cosine * alt.sine}
    across |= {8: double_sine * alt.cosine, 9: double_cosine * alt.cosine}
    along = {1: one, 4: az.cosine * facing, 5: az.sine * facing}
    along |= {6: alt.cosine, 7: alt.sine, 10: double_sine, 11: jumped}
    return across, along


def _by_blocks(
    form: _Form, az_south: ArrayLike, altitude: ArrayLike, p: Leaning
) -> tuple[Array, Array]:
    az, alt = np.asarray(az_south, dtype=float), np.asarray(altitude, dtype=float)
    compiled = kernel.offsets(az, alt, p, exact=form is _exact)
    if compiled is not None:
        return compiled
    shape = np.broadcast_shapes(az.shape, alt.shape)
    if len(shape) == 2 and az.shape == (shape[0], 1) and alt.shape[-1] == alt.size:
        return _grid(form, az.reshape(-1), alt.reshape(-1, 1), p)
    d_az, d_alt = np.empty(shape), np.empty(shape)
    az, alt = (np.broadcast_to(one, shape).reshape(-1) for one in (az, alt))
    room = np.empty((_ROOMS, min(BLOCK, len(az))))
    for block in _slices(len(az), BLOCK):
        across, along = d_az.reshape(-1)[block], d_alt.reshape(-1)[block]
        work = room[:, : len(across)]
        axes = Axis.of(az[block], p.toward, work[:2]), Axis.of_altitudes(alt[block], work[2:4])
        form(*axes, p, (across, along), work[4:])
        waves = work[4:7]
        _waves(axes[0], p, waves)
        across += waves[0]
        along += waves[1]
        along += _sags(axes[1], p, work[4:6])
        _wrap(across)
        if p.jump != 0:
            along += p.jump * has_jumped(az[block], alt[block])
    return d_az[()], d_alt[()]


def _grid(form: _Form, az: Array, alt: Array, p: Leaning) -> tuple[Array, Array]:
    """Return the offsets of a grid; in memory azimuths lie together, being the more usually."""
    columns, rows = Axis.of(az, p.toward), Axis.of_altitudes(alt)
    waves, sags = np.empty((3, len(az))), np.empty((2, *alt.shape))
    _waves(columns, p, waves)
    _sags(rows, p, sags)
    # below the horizon the step is there whatever the azimuth, on it nowhere
    height = np.where(alt > 0, alt, np.where(alt < 0, np.inf, -np.inf))
    curve = jump_altitude(az)
    d_az, d_alt = np.empty((2, len(alt), len(az)))
    size = max(1, BLOCK // max(1, len(az)))
    room = np.empty((_ROOMS, size, len(az)))
    for block in _slices(len(alt), size):
        across, along = d_az[block], d_alt[block]
        form(columns, rows[block], p, (across, along), room[:, : len(across)])
        across += waves[0]
        along += waves[1]
        along += sags[0, block]
        _wrap(across)
        if p.jump != 0:
            along += p.jump * (height[block] >= curve)
    return d_az.T, d_alt.T


def _slices(count: int, size: int) -> Iterator[slice]:
    for low in range(0, count, size):
        yield slice(low, low + size)


def _waves(az: Axis, p: Leaning, room: Array) -> None:
    """Write what depends on azimuth alone to two arrays, with a third to work in.

    Zeros of both axes, encoders and rail.
    """
    waves = zip(room[:2], (p.az0 + p.south, p.alt0), (p.in_az, p.in_alt), strict=True)
    for place, zero, (by_sine, by_cosine) in waves:
        # the cosine of twice the azimuth is 1 - 2 sin^2
        wave = np.multiply(az.cosine, 2 * by_sine, out=place)
        wave -= np.multiply(az.sine, 2 * by_cosine, out=room[2])
        wave *= az.sine
        wave += zero + by_cosine


def _sags(alt: Axis, p: Leaning, room: Array) -> Array:
    """Return what depends on altitude alone, written to the first of two arrays."""
    np.multiply(alt.cosine, p.sag, out=room[0])
    room[0] += np.multiply(alt.sine, p.sag_sine, out=room[1])
    return room[0]


def _some_below(values: Array) -> bool:
    """Tell whether some values are, or may be, negative: a single NaN hides what else is."""
    return not values.min(initial=0.0) >= 0


def _wrap(angle: Array) -> None:
    """Bring angles [rad] into [-pi, pi), in place; those that are there stay as they are."""
    # put so that a single NaN does not hide what else is beyond
    if not (angle.max(initial=0.0) < np.pi and angle.min(initial=0.0) >= -np.pi):
        beyond = (angle >= np.pi) | (angle < -np.pi)
        angle[beyond] = wrap(angle[beyond])


def _exact(az: Axis, alt: Axis, p: Leaning, out: tuple[Array, Array], room: Array) -> None:
    """Write the exact form's arcs, eqs. 1 to 4, 15 and 16."""
    facing = np.copysign(1.0, alt.cosine) if _some_below(alt.cosine) else None
    _tilted(az, alt, p, facing, out[0], room)
    _skewed(alt, p, facing, out, room)
    if facing is not None:
        across = out[0]
        across += p.south * (facing - 1)


def _tilted(
    az: Axis, alt: Axis, p: Leaning, facing: Array | None, d_az: Array, room: Array
) -> None:
    """Write the turn of azimuth by a tilt.

    Sine and squared cosine of the altitude that the mount reads are left in the first
    two rooms. With the lean q, along the south of these azimuths, its sign turned in
    plunge, a direction (v, z) reads (w, q.v + z c), w = v - m q, m = q.v/(1 + c) + z,
    c the lean's cosine. The angle from v to w is the turn of azimuth, |w| the cosine
    of the altitude that is read, so that neither has to be found as an angle.
    """
    sine, m, along, dot, turn = room[:5]
    spare = room[5] if alt.sine.shape == d_az.shape else None
    c = p.upright
    leaning = np.multiply(alt.cosine, p.lean, out=spare)
    np.multiply(leaning, az.sine, out=turn)
    np.multiply(leaning, az.cosine, out=along)
    if facing is not None:
        along *= facing
    np.multiply(along, 1 / (1 + c), out=m)
    m += alt.sine
    np.add(along, np.multiply(alt.sine, c, out=spare), out=sine)
    along *= m
    turn *= m
    np.subtract(np.multiply(alt.cosine, alt.cosine, out=spare), along, out=dot)
    np.arctan2(turn, dot, out=d_az)
    m *= m
    m *= p.lean**2
    m -= along
    m += dot


def _skewed(
    alt: Axis, p: Leaning, facing: Array | None, out: tuple[Array, Array], room: Array
) -> None:
    """Add the turn of azimuth and write the change of altitude by skew and box.

    The first two rooms hold sine and squared cosine of the altitude that the tilted mount
    reads.
    """
    sine, square, across, level, rise = room[:5]
    spare = room[5] if alt.sine.shape == level.shape else None
    cos_s, tan_s = math.cos(p.sigma), math.tan(p.sigma)
    sin_b, cos_b = math.sin(p.beta), math.cos(p.beta)
    np.multiply(sine, tan_s, out=across)
    across += sin_b / cos_s
    np.multiply(across, across, out=level)
    np.subtract(square, level, out=level)
    # where no setting reaches the source the azimuth stops
    stops = np.nonzero(level < 0) if _some_below(level) else None
    if stops is not None:
        reach = np.copysign(np.sqrt(np.maximum(square[stops], 0.0)), across[stops])
        up = sine[stops] + tan_s * reach
        true = [np.broadcast_to(one, level.shape)[stops] for one in (alt.cosine, alt.sine)]
        level[stops] = 0.0
    np.sqrt(level, out=level)
    if facing is not None:
        level *= facing
    # the angle from the true altitude to the one that is set, not their difference
    np.add(sine, sin_b * cos_s * tan_s, out=rise)
    rise *= np.multiply(alt.cosine, 1 / (cos_s * cos_b), out=spare)
    rise -= np.multiply(level, np.multiply(alt.sine, 1 / cos_b, out=spare), out=sine)
    d_az, d_alt = out
    np.arcsin(rise, out=d_alt)
    if stops is not None:
        d_alt[stops] = np.arctan2(up * true[0], up * true[1])
    with np.errstate(divide="ignore"):
        across /= level
    d_az += np.arctan(across, out=across)


def _approximate(
    az: Axis,
    alt: Axis,
    p: Leaning,
    out: tuple[Array, Array],
    room: Array,  # noqa: ARG001 - the exact form needs it
) -> None:
    """Write what depends on both angles in the approximate form, eqs. 18 and 19."""
    across, along = out
    np.multiply(az.sine, p.lean, out=across)
    across += p.sigma
    across *= alt.sine
    across += p.beta
    across /= alt.cosine
    np.multiply(az.cosine, p.lean, out=along)
    # put so that a NaN does not hide what else is beyond
    if not alt.angle.max(initial=0.0) <= np.pi / 2:
        along *= np.where(alt.angle > np.pi / 2, -1.0, 1.0)
