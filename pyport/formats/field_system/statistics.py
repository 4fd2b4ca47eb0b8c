"""The line of weighted means and scatters below each section of an err file."""

from __future__ import annotations

import numpy as np

from pyport.angles import Array
from pyport.formats.field_system.fit import Data


def statistics(data: Data, d_az: Array, d_el: Array, noise: tuple[float, float]) -> str:
    """Return mean and scatter in azimuth and elevation, on the sky, and in cross-elevation.

    Offsets in radians, weighed by their errors with `noise` added; degrees in
    the line, with the numbers of recordings used and in all before the last two.
    """
    used = data.used
    cos_el = np.cos(data.el[used])
    sky = cos_el**2 if data.sky_noise else np.ones_like(cos_el)
    az_noise, el_noise = (np.sign(one) * one**2 for one in noise)
    az_variance = data.sigma_az[used] ** 2 + az_noise / sky
    el_variance = data.sigma_el[used] ** 2 + el_noise
    across, along = d_az[used], d_el[used]
    az_mean, az_rms = _mean_and_scatter(across, 1 / az_variance)
    el_mean, el_rms = _mean_and_scatter(along, 1 / el_variance)
    cross_mean, cross_rms = _mean_and_scatter(across * cos_el, 1 / (az_variance * cos_el**2))
    weight = 1 / (az_variance * cos_el**2 + el_variance)
    square = np.average((across * cos_el) ** 2 + along**2, weights=weight)
    on_sky = np.sqrt(square * _spread(len(across)))
    values = np.degrees([az_mean, az_rms, el_mean, el_rms, on_sky])
    first = " ".join(f"{one:10.5f}" for one in values)
    cross = " ".join(f"{one:10.5f}" for one in np.degrees([cross_mean, cross_rms]))
    return f"    {first}  {int(used.sum()):5d}  {len(used):5d} {cross}"


def _mean_and_scatter(values: Array, weight: Array) -> tuple[float, float]:
    mean = float(np.average(values, weights=weight))
    variance = abs(float(np.average(values**2, weights=weight)) - mean**2)
    return mean, float(np.sqrt(variance * _spread(len(values))))


def _spread(number: int) -> float:
    """Return n / (n - 1), 0 for a single recording."""
    return number / (number - 1) if number > 1 else 0.0
