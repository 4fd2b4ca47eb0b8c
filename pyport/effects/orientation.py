"""How the Earth really turned: the pole's wandering and UT1, from the IERS series C04."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.effects.base import Circumstances, MissingColumn
from pyport.effects.celestial import days, timed

#: The Unix epoch as a modified Julian date.
_UNIX_EPOCH_MJD = 40587.0


def pole(at: Circumstances) -> tuple[Array, Array]:
    """Return the pole's coordinates x_p, y_p [arcsec] at the time of each row."""
    time, row, series = _around(at)
    x_p, y_p = (np.interp(time, series[:, 0], series[:, k])[row] for k in (1, 2))
    return x_p, y_p


def ut1_minus_utc(at: Circumstances) -> Array:
    """Return UT1-UTC [s] at the time of each row."""
    time, row, series = _around(at)
    # Between two days of a leap second UT1 runs on smoothly: unwrap it before interpolating.
    smooth = np.unwrap(series[:, 3], period=1.0)
    value = np.interp(time, series[:, 0], smooth)
    day = np.searchsorted(series[:, 0], time, side="right") - 1
    return timed(at, (value - smooth[day] + series[day, 3])[row])[0]


def _around(at: Circumstances) -> tuple[Array, NDArray[np.intp], Array]:
    """Return distinct times [MJD], which is each row's, and the days of the series around them.

    Raises `MissingColumn`: no times, or times that the series does not cover.
    """
    time, row = np.unique(days(at) + _UNIX_EPOCH_MJD, return_inverse=True)
    series = _series()
    if time[0] < series[0, 0] or time[-1] >= series[-1, 0]:
        raise MissingColumn("Earth orientation at these dates")
    first, last = np.searchsorted(series[:, 0], time[[0, -1]])
    return time, row, series[max(first - 1, 0) : last + 2]


@functools.cache
def _series() -> Array:
    """Read the C04 series that comes with astropy: MJD, x_p, y_p [arcsec], UT1-UTC [s].

    It is read once: the file does not change while the program runs.
    """
    from astropy_iers_data import IERS_B_FILE

    series = np.loadtxt(IERS_B_FILE, usecols=(4, 5, 6, 7))
    series.flags.writeable = False
    return series
