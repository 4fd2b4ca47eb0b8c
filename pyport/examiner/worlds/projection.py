"""What the classical seven terms leave of an offset: the examiner's own least squares.

The seven columns are not formulae: they are what a mount of rotations does
when one thing in it is askew by a second of arc.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, Array, wrap
from pyport.examiner.worlds.mount import Mount, axes, readings

#: The seven terms, as parts of a mount that are askew.
BASE = (
    "azimuth_zero",
    "elevation_zero",
    "beam_left",
    "skew",
    "tilt_north",
    "tilt_east",
    "sag_cosine",
)


def altaz_columns(az: Array, el: Array) -> tuple[Array, Array]:
    """Return (x, y) of the seven terms per radian, shape (n, 7) each."""
    x, y = [], []
    for name in BASE:
        mount = Mount(**{name: ARCSEC})  # type: ignore[arg-type]
        encoder_az, encoder_el = readings(mount, *axes(mount, az, el))
        x.append(wrap(encoder_az - az) * np.cos(el) / ARCSEC)
        y.append((encoder_el - el) / ARCSEC)
    return np.stack(x, axis=1), np.stack(y, axis=1)


class Base:
    """The altaz base at the pointings of a case, each antenna with its own seven.

    Parameters
    ----------
    az, el
        True positions [rad], shape (n,).
    antenna
        Whose pointings they are.
    has_x, has_y
        Which rows measured which axis.
    sigma_x, sigma_y
        Weights [rad].
    """

    def __init__(
        self,
        az: Array,
        el: Array,
        antenna: NDArray[np.str_],
        has_x: NDArray[np.bool_],
        has_y: NDArray[np.bool_],
        sigma_x: float,
        sigma_y: float,
    ):
        self.has_x, self.has_y = has_x, has_y
        self.sigma_x, self.sigma_y = sigma_x, sigma_y
        x, y = altaz_columns(az, el)
        own = antenna[:, None] == np.unique(antenna)[None, :]

        def spread(columns: Array) -> Array:
            return (own[:, :, None] * columns[:, None, :]).reshape(len(az), -1)

        stacked = self.stack(spread(x), spread(y))
        left, size, _ = np.linalg.svd(stacked, full_matrices=False)
        self._orthonormal = left[:, size > 1e-9 * size[0]]

    def stack(self, x: Array, y: Array) -> Array:
        """Return measured values of both axes, in units of the noise, one after the other."""
        return np.concatenate([x[self.has_x] / self.sigma_x, y[self.has_y] / self.sigma_y])

    def rho(self, x: Array, y: Array, *, projected: bool = True) -> tuple[float, float]:
        """Return the rms over the noise of an offset, per axis, 0 where none was measured.

        With `projected` it is the rms of what the base leaves of it.
        """
        stacked = self.stack(x, y)
        if projected:
            stacked = stacked - self._orthonormal @ (self._orthonormal.T @ stacked)
        count = int(self.has_x.sum())
        return _rms(stacked[:count]), _rms(stacked[count:])


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0
