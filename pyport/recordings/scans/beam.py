"""A beam in power against time, and when the antenna looked at the source."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pyport.angles import Array

#: Exponent of a Gaussian in units of its full width at half maximum.
SHAPE = 4 * np.log(2)

#: A peak is one from this many sigmas of its height on.
DETECTED = 5.0

#: Unknowns of the fit: height, time, width, and the baseline's level and slope.
UNKNOWNS = 5


@dataclass(frozen=True)
class Peak:
    """A beam's crossing."""

    #: `time_s`, `sigma_s`: when it was at its height, on the samples' clock, and the one-sigma
    #: error [s].
    time_s: float
    sigma_s: float
    width_s: float  #: full width at half maximum [s]
    #: `height`, `noise`: in the unit of the power: the beam's height, the scatter of a sample.
    height: float
    noise: float


def fit_peak(time_s: Array, power: Array) -> Peak | str:
    """Fit a Gaussian and a straight baseline to power against time.

    `time_s`, `power`: samples of one scan, shape (n,); NaN where a sample is missing.
    Returns the peak, or why there is none.
    """
    good = np.isfinite(time_s) & np.isfinite(power)
    if good.sum() <= 2 * UNKNOWNS:
        return f"{good.sum()} samples, expected more than {2 * UNKNOWNS}"
    t, p = time_s[good], power[good]
    span, scale = float(np.ptp(t)), float(np.ptp(p))
    if span == 0 or scale == 0:
        return f"no peak: the {'power' if span else 'time'} is constant"
    # times from -1/2 to 1/2 and powers of order 1, so that all unknowns are alike
    middle = float(t.min() + t.max()) / 2
    u, v = (t - middle) / span, (p - np.median(p)) / scale
    (height, centre, width), (sigma_height, sigma_centre), noise = _bell(u, v)
    if height < DETECTED * sigma_height:
        return f"no peak: {height / sigma_height:.1f} sigmas high"
    if abs(centre) > 0.5:
        return "no peak within the scan"
    if not 2 * np.median(np.diff(np.sort(u))) < width < 1:
        return "no peak: its width is not a beam's"
    return Peak(
        middle + span * centre, span * sigma_centre, span * width, scale * height, scale * noise
    )


def _bell(u: Array, v: Array) -> tuple[tuple[float, float, float], tuple[float, float], float]:
    """Return height, centre and width; the sigmas of the first two; and the noise."""
    from scipy.optimize import least_squares

    def left(unknowns: Array) -> Array:
        height, centre, width, base, slope = unknowns
        return height * np.exp(-SHAPE * ((u - centre) / width) ** 2) + base + slope * u - v

    def jacobian(unknowns: Array) -> Array:
        height, centre, width, _, _ = unknowns
        apart = (u - centre) / width
        bell = np.exp(-SHAPE * apart**2)
        steep = 2 * SHAPE * height * bell * apart / width
        return np.stack([bell, steep, steep * apart, np.ones_like(u), u], axis=1)

    found = least_squares(left, _start(u, v), jacobian, method="lm")
    noise = float(np.sqrt(2 * found.cost / (len(u) - UNKNOWNS)))
    variance = np.diag(np.linalg.pinv(found.jac.T @ found.jac)) * noise**2
    height, centre, width = (float(one) for one in found.x[:3])
    sigmas = [max(float(np.sqrt(one)), 1e-300) for one in variance[:2]]
    return (height, centre, abs(width)), (sigmas[0], sigmas[1]), noise


def _start(u: Array, v: Array) -> Array:
    """Return the bell of a grid of centres and widths that takes most out of the power."""
    line = np.linalg.qr(np.stack([np.ones_like(u), u], axis=1))[0]
    rest = v - line @ (line.T @ v)
    best, start = 0.0, np.array([0.0, 0.0, 0.1, 0.0, 0.0])
    for width in (0.04, 0.1, 0.2, 0.4):
        centres = np.arange(-0.48, 0.5, width / 4)
        bells = np.exp(-SHAPE * ((u[:, None] - centres) / width) ** 2)
        bells -= line @ (line.T @ bells)
        size = np.maximum((bells**2).sum(axis=0), 1e-12)
        heights = rest @ bells / size
        gains = np.where(heights > 0, heights**2 * size, 0)
        one = int(gains.argmax())
        if gains[one] > best:
            best = float(gains[one])
            start = np.array([heights[one], centres[one], width, 0.0, 0.0])
    return start
