"""The RT32's offsets for many points: sines once an axis, and no more arcs than the geometry needs.

The formulae are those of `exact` and `approximate`, rearranged so that every
point costs two arctangents and an arcsine (the approximate form: none) and a
few dozen products. Work goes block by block, so that what stands between the
first sine and the offset stays in the processor's cache. A grid is given by its
two axes, azimuths (n, 1) and altitudes (m,): its sines are those of the axes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pyport.angles import DEG, Array, wrap
from pyport.pointing.jump import has_jumped

#: Points of a block: a dozen arrays of them fit into a core's second cache.
BLOCK = 8192
#: Between the horizon and this altitude nothing has jumped. [rad]
_BELOW_THE_JUMP = 54 * DEG
#: A quarter turn, and what a double leaves of it. [rad]
_QUARTER, _QUARTER_LOW = np.pi / 2, 6.123233995736766e-17


@dataclass(frozen=True)
class Axis:
    """An angle and its sine and cosine, from one tangent of the half angle.

    Both come out within 3e-16: a tangent costs a fifth of a sine where the
    processor computes eight at a time.
    """

    angle: Array
    sine: Array
    cosine: Array

    @classmethod
    def of(cls, angle: Array) -> Axis:
        """Return an axis of angles [rad]."""
        t = np.tan(angle / 2)
        scale = 1 / (1 + t * t)
        return cls(angle, 2 * t * scale, (1 - t) * (1 + t) * scale)

    @classmethod
    def of_altitudes(cls, altitude: Array) -> Axis:
        """Return an axis of altitudes [rad], whose cosines matter near the zenith.

        They come from the zenith distance, pi/2 taken to twice the digits.
        """
        zenith = cls.of((_QUARTER - altitude) + _QUARTER_LOW)
        return cls(altitude, zenith.cosine, zenith.sine)

    def __getitem__(self, rows: slice) -> Axis:
        """Return some rows of it."""
        return Axis(self.angle[rows], self.sine[rows], self.cosine[rows])


#: (azimuth, altitude, parameters, the two offsets' place) -> None
_Form = Callable[[Axis, Axis, list[float], Array, Array], None]


def exact(az_south: ArrayLike, altitude: ArrayLike, p: ArrayLike) -> tuple[Array, Array]:
    """Return what :func:`pyport.pointing.exact.exact_offsets` does, within 1e-15/cos(alt) rad."""
    return _by_blocks(_exact, az_south, altitude, p)


def approximate(az_south: ArrayLike, altitude: ArrayLike, p: ArrayLike) -> tuple[Array, Array]:
    """Return what :func:`pyport.pointing.approximate.approximate_offsets` does."""
    return _by_blocks(_approximate, az_south, altitude, p)


def _by_blocks(
    form: _Form, az_south: ArrayLike, altitude: ArrayLike, p: ArrayLike
) -> tuple[Array, Array]:
    az, alt = np.asarray(az_south, dtype=float), np.asarray(altitude, dtype=float)
    shape = np.broadcast_shapes(az.shape, alt.shape)
    d_az, d_alt = np.empty(shape), np.empty(shape)
    parameters = [float(one) for one in np.asarray(p, dtype=float)]
    if len(shape) == 2 and az.shape == (shape[0], 1) and alt.shape[-1] == alt.size:
        _grid(form, az, alt.reshape(-1), parameters, d_az, d_alt)
    else:
        az, alt = (np.broadcast_to(one, shape).reshape(-1) for one in (az, alt))
        flat = d_az.reshape(-1), d_alt.reshape(-1)
        for block in _slices(len(az), BLOCK):
            out = flat[0][block], flat[1][block]
            form(Axis.of(az[block]), Axis.of_altitudes(alt[block]), parameters, *out)
    return wrapped(d_az)[()], d_alt[()]


def _grid(
    form: _Form, az: Array, alt: Array, parameters: list[float], d_az: Array, d_alt: Array
) -> None:
    columns, rows = Axis.of(az), Axis.of_altitudes(alt)
    for block in _slices(len(az), max(1, BLOCK // max(1, len(alt)))):
        form(columns[block], rows, parameters, d_az[block], d_alt[block])


def _slices(count: int, size: int) -> Iterator[slice]:
    for low in range(0, count, size):
        yield slice(low, low + size)


def wrapped(angle: Array) -> Array:
    """Bring angles [rad] into [-pi, pi), in place; those that are there stay as they are."""
    beyond = (angle >= np.pi) | (angle < -np.pi)
    if beyond.any():
        angle[beyond] = wrap(angle[beyond])
    return angle


def tilted(az: Axis, alt: Axis, xi: float, zeta: float) -> tuple[Array, Array, Array]:
    """Return the change of azimuth, and sine and cosine of the altitude that a tilted mount reads.

    With the lean q = (sin xi, sin zeta), its sign turned in plunge, a direction
    (v, z) reads (w, q.v + z c), w = v - m q, m = q.v/(1 + c) + z, c the lean's
    cosine. The angle from v to w is the turn of azimuth, |w| the cosine of the
    altitude that is read, so that neither has to be found as an angle.
    """
    south, west = np.sin(xi), np.sin(zeta)
    lean = south * south + west * west
    c = np.sqrt(1 - lean)
    level = np.abs(alt.cosine)
    facing = np.copysign(1.0, alt.cosine)

    along = level * (south * az.cosine + west * az.sine)
    m = along / (1 + c)
    m += alt.sine
    sine = c * alt.sine + along
    along *= m
    # alt.cosine is level, its sign that of the turn in plunge
    turn = alt.cosine * (south * az.sine - west * az.cosine)
    turn *= m
    dot = level * level - along
    m *= m
    m *= lean
    m -= along
    m += dot
    cosine = np.sqrt(m, out=m)
    cosine *= facing
    np.arctan2(turn, dot, out=turn)
    # the tilted mount counts from where it sees the south point
    toward = np.arctan2(west, south)
    sin_t, cos_t = np.sin(toward), np.cos(toward)
    turn += facing * np.arctan2(sin_t * cos_t * (1 - c), cos_t**2 * c + sin_t**2)
    return turn, sine, cosine


def _skewed(alt: Axis, sine: Array, cosine: Array, sigma: float, beta: float) -> list[Array]:
    """Return the turn of azimuth and the change of altitude by skew and box.

    `sine` and `cosine` are those of the altitude that the tilted mount reads;
    both are used up.
    """
    sin_turn = sine * (np.sin(sigma) / np.cos(sigma))
    sin_turn += np.sin(beta) / np.cos(sigma)
    sin_turn /= cosine
    if sin_turn.max(initial=0.0) > 1 or sin_turn.min(initial=0.0) < -1:
        np.clip(sin_turn, -1.0, 1.0, out=sin_turn)
    turn = np.arcsin(sin_turn)
    down = sin_turn * sin_turn
    np.subtract(1.0, down, out=down)
    np.sqrt(down, out=down)
    down *= cosine
    up = sine
    up *= np.cos(sigma)
    cosine *= sin_turn
    cosine *= np.sin(sigma)
    up += cosine
    # the angle from the true altitude to the one that is set, not their difference
    rise = up * alt.cosine
    np.multiply(down, alt.sine, out=cosine)
    rise -= cosine
    up *= alt.sine
    down *= alt.cosine
    up += down
    return [turn, np.arctan2(rise, up, out=rise)]


def _exact(az: Axis, alt: Axis, p: list[float], d_az: Array, d_alt: Array) -> None:
    """Write the exact offsets of a block of points, eqs. 1 to 4 and 15 to 19."""
    az0, alt0, sigma, beta, xi, zeta, sag, sag_sine, sin_2a, cos_2a, nod, jump = p
    turn_of_tilt, sine, cosine = tilted(az, alt, xi, zeta)
    turn, rise = _skewed(alt, sine, cosine, sigma, beta)
    double_sine = 2 * az.sine * az.cosine
    double_cosine = (az.cosine - az.sine) * (az.cosine + az.sine)
    np.add(turn, turn_of_tilt, out=d_az)
    d_az += az0 + sin_2a * double_sine + cos_2a * double_cosine
    np.add(rise, alt0 + sag * alt.cosine + sag_sine * alt.sine, out=d_alt)
    d_alt += nod * double_sine
    _step(az.angle, alt.angle, jump, d_alt)


def _approximate(az: Axis, alt: Axis, p: list[float], d_az: Array, d_alt: Array) -> None:
    """Write the approximate offsets of a block of points, eqs. 18 and 19."""
    az0, alt0, sigma, beta, xi, zeta, sag, sag_sine, sin_2a, cos_2a, nod, jump = p
    double_sine = 2 * az.sine * az.cosine
    double_cosine = (az.cosine - az.sine) * (az.cosine + az.sine)
    np.multiply(sigma + (xi * az.sine - zeta * az.cosine), alt.sine / alt.cosine, out=d_az)
    d_az += beta / alt.cosine
    d_az += az0 + sin_2a * double_sine + cos_2a * double_cosine
    facing = np.where(alt.angle > np.pi / 2, -1.0, 1.0)
    np.multiply(xi * az.cosine + zeta * az.sine, facing, out=d_alt)
    d_alt += alt0 + sag * alt.cosine + sag_sine * alt.sine
    d_alt += nod * double_sine
    _step(az.angle, alt.angle, jump, d_alt)


def _step(az: Array, alt: Array, jump: float, d_alt: Array) -> None:
    """Add the jump where there is one; of scattered points those alone that could have it."""
    if jump == 0:
        return
    if az.ndim == 2:
        d_alt += jump * has_jumped(az, alt)
        return
    may = np.flatnonzero((alt < 0) | (alt > _BELOW_THE_JUMP))
    d_alt[may] += jump * has_jumped(az[may], alt[may])
