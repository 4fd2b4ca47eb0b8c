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
from pyport.pointing.jump import has_jumped, jump_altitude

#: Points of a block: a dozen arrays of them fit into a core's second cache.
BLOCK = 16384
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
    parameters = [float(one) for one in np.asarray(p, dtype=float)]
    if len(shape) == 2 and az.shape == (shape[0], 1) and alt.shape[-1] == alt.size:
        return _grid(form, az.reshape(-1), alt.reshape(-1, 1), parameters)
    d_az, d_alt = np.empty(shape), np.empty(shape)
    az, alt = (np.broadcast_to(one, shape).reshape(-1) for one in (az, alt))
    flat = d_az.reshape(-1), d_alt.reshape(-1)
    for block in _slices(len(az), BLOCK):
        out = flat[0][block], flat[1][block]
        form(Axis.of(az[block]), Axis.of_altitudes(alt[block]), parameters, *out)
    return wrapped(d_az)[()], d_alt[()]


def _grid(form: _Form, az: Array, alt: Array, parameters: list[float]) -> tuple[Array, Array]:
    """Return the offsets of a grid; in memory azimuths lie together, being the more usually."""
    columns, rows = Axis.of(az), Axis.of_altitudes(alt)
    d_az, d_alt = np.empty((2, len(alt), len(az)))
    for block in _slices(len(alt), max(1, BLOCK // max(1, len(az)))):
        form(columns, rows[block], parameters, d_az[block], d_alt[block])
    return wrapped(d_az).T, d_alt.T


def _slices(count: int, size: int) -> Iterator[slice]:
    for low in range(0, count, size):
        yield slice(low, low + size)


def wrapped(angle: Array) -> Array:
    """Bring angles [rad] into [-pi, pi), in place; those that are there stay as they are."""
    # put so that a single NaN does not hide what else is beyond
    if not (angle.max(initial=0.0) < np.pi and angle.min(initial=0.0) >= -np.pi):
        beyond = (angle >= np.pi) | (angle < -np.pi)
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
    plunges = alt.cosine.min(initial=0.0) < 0

    along = level * (south * az.cosine + west * az.sine)
    m = along * (1 / (1 + c))
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
    if plunges:
        cosine *= facing
    np.arctan2(turn, dot, out=turn)
    # the tilted mount counts from where it sees the south point
    toward = np.arctan2(west, south)
    sin_t, cos_t = np.sin(toward), np.cos(toward)
    zero = np.arctan2(sin_t * cos_t * (1 - c), cos_t**2 * c + sin_t**2)
    turn += zero * facing if plunges else zero
    return turn, sine, cosine


def _skewed(
    alt: Axis, sine: Array, cosine: Array, sigma: float, beta: float
) -> tuple[Array, Array]:
    """Return the turn of azimuth and the change of altitude by skew and box.

    `sine` and `cosine` are those of the altitude that the tilted mount reads;
    both are used up.
    """
    sin_s, cos_s, sin_b, cos_b = np.sin(sigma), np.cos(sigma), np.sin(beta), np.cos(beta)
    sin_turn = sine * (sin_s / cos_s)
    sin_turn += sin_b / cos_s
    sin_turn /= cosine
    # where no setting reaches the source the azimuth stops, and its sine is no sine
    reached = sin_turn.max(initial=0.0) <= 1 and sin_turn.min(initial=0.0) >= -1
    if not reached:
        stops = np.nonzero(np.abs(sin_turn) > 1)
        np.clip(sin_turn, -1.0, 1.0, out=sin_turn)
        true = [np.broadcast_to(one, sine.shape)[stops] for one in (alt.sine, alt.cosine)]
        read = sine[stops], cosine[stops], sin_turn[stops]
    turn = np.arcsin(sin_turn)
    down = sin_turn * sin_turn
    np.subtract(1.0, down, out=down)
    np.sqrt(down, out=down)
    down *= cosine
    # elsewhere up and down are a sine and a cosine times that of beta, by which the beam is off
    up = sine
    up += sin_s * sin_b
    up *= 1 / cos_s
    # the angle from the true altitude to the one that is set, not their difference
    rise = up * alt.cosine
    np.multiply(down, alt.sine, out=cosine)
    rise -= cosine
    rise *= 1 / cos_b
    np.arcsin(rise, out=rise)
    if not reached:
        rise[stops] = _rise_of_stopped(true, read, sin_s, cos_s)
    return turn, rise


def _rise_of_stopped(
    true: list[Array], read: tuple[Array, Array, Array], sin_s: float, cos_s: float
) -> Array:
    """Return the change of altitude where the azimuth stops a quarter turn off.

    Given are sine and cosine of the true altitude, those of the one that is read and the
    sine of the turn.
    """
    sine, cosine, sin_turn = read
    up = sine * cos_s + cosine * sin_s * sin_turn
    down = cosine * np.sqrt(1 - sin_turn * sin_turn)
    return np.asarray(np.arctan2(up * true[1] - down * true[0], up * true[0] + down * true[1]))


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
    if alt.ndim == 2:
        # below the horizon the step is there whatever the azimuth, on it nowhere
        height = np.where(alt > 0, alt, np.where(alt < 0, np.inf, -np.inf))
        d_alt += jump * (height >= jump_altitude(az))
        return
    may = np.flatnonzero((alt < 0) | (alt > _BELOW_THE_JUMP))
    d_alt[may] += jump * has_jumped(az[may], alt[may])
