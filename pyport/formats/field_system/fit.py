"""The Field System's fit of a pointing model, as its program `error` makes it.

Weighted least squares, with a noise of its own for each axis added until the
weighted residuals scatter by one: the errors that come with the data say only
how well each source was measured.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array
from pyport.effects import Circumstances
from pyport.errors import BadInput
from pyport.models.terms import field_system


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


#: So often the added noise is found anew.
ROUNDS = 10
#: It has come to rest when it changes by less than this share.
SETTLED = 0.01
#: Halvings of the interval that it is looked for in, and how near to one the scatter has to come.
HALVINGS, NEAR_ONE = 64, 0.001
#: The least upper end of that interval [rad].
WIDEST = 2 * DEG


@dataclass(frozen=True)
class Data:
    """Pointing data as the Field System has them: azimuth as a coordinate, radians, (n,) each.

    `sky_noise` tells whether the noise added to azimuth is one on the sky.
    """

    az: Array
    el: Array
    d_az: Array
    d_el: Array
    sigma_az: Array
    sigma_el: Array
    used: NDArray[np.bool_]
    sky_noise: bool = True


@dataclass(frozen=True)
class ParameterFit:
    """A fit of some of P1..P30."""

    numbers: tuple[int, ...]  #: which parameters were fitted
    #: `value`, `sigma`: [rad], shape (p,).
    value: Array
    sigma: Array
    correlation: Array  #: shape (p, p)
    #: Condition number of the normal matrix scaled to a unit diagonal, in the 1-norm.
    condition: float
    #: By how much each sigma is larger than without the other parameters, shape (p,).
    inflation: Array
    noise: tuple[float, float]  #: what was added to the errors in azimuth and elevation [rad]
    scatter: tuple[float, float, float]  #: reduced chi, and its parts in azimuth and elevation
    free: int  #: degrees of freedom
    rounds: int  #: after how many the noise had come to rest; 0 when it did not
    #: `left_az`, `left_el`: residuals of all data [rad], shape (n,).
    left_az: Array
    left_el: Array
    #: `after_az`, `after_el`: the one-sigma errors of the residuals [rad], negative where the fit
    #: is worse known than the data, shape (n,).
    after_az: Array
    after_el: Array


def columns(data: Data, numbers: Sequence[int], phi_deg: float) -> tuple[Array, Array]:
    """Return what one of each parameter adds to azimuth (a coordinate) and elevation, (n, p)."""
    at = Circumstances(data.az, data.el)
    cos_el = np.cos(data.el)
    found = np.zeros((2, len(data.az), len(numbers)))
    for place, number in enumerate(numbers):
        word = field_system.word(f"P{number}", phi_deg)
        if word is not None and word.parts:
            x, y = word.columns(at)
            found[0, :, place], found[1, :, place] = x / cos_el, y
    return found[0], found[1]


def fit(
    data: Data, numbers: Sequence[int], phi_deg: float = field_system.ALTAZ_PHI_DEG
) -> ParameterFit:
    """Fit parameters to data that no model was taken off.

    Raises `BadInput`: there are too few data in use for so many parameters, or these data cannot
      distinguish them.
    """
    across, along = columns(data, numbers, phi_deg)
    empty = [
        f"P{n}"
        for n, a, b in zip(numbers, across.T, along.T, strict=True)
        if not (a.any() or b.any())
    ]
    if empty:
        raise BadInput(f"{', '.join(empty)} moves nothing here and cannot be fitted: set it to 0")
    noise, rounds = _settled(data, across, along)
    value, covariance, condition, inflation = _solve(data, across, along, noise)
    left = _left(data, across, along, value)
    used = int(data.used.sum())
    free = 2 * used - int((inflation > 0.01).sum())
    variance = _variances(data, noise)
    chi = [
        float((one[data.used] ** 2 / own[data.used]).sum())
        for one, own in zip(left, variance, strict=True)
    ]
    scatter = math.sqrt(sum(chi) / free), math.sqrt(chi[0] / used), math.sqrt(chi[1] / used)
    sigma = np.sqrt(np.diag(covariance))
    after = [
        scatter[0] * np.sign(spare) * np.sqrt(np.abs(spare))
        for own, basis in zip(variance, (across, along), strict=True)
        for spare in (own - np.einsum("ni,ij,nj->n", basis, covariance, basis),)
    ]
    return ParameterFit(
        numbers=tuple(numbers),
        value=value,
        sigma=scatter[0] * sigma,
        correlation=covariance / np.outer(sigma, sigma),
        condition=condition,
        inflation=inflation,
        noise=noise,
        scatter=scatter,
        free=free,
        rounds=rounds,
        left_az=left[0],
        left_el=left[1],
        after_az=after[0],
        after_el=after[1],
    )


def _settled(data: Data, across: Array, along: Array) -> tuple[tuple[float, float], int]:
    """Return the noise to add, and after how many rounds it came to rest: none (0) if never."""
    noise = (0.0, 0.0)
    for rounds in range(2, ROUNDS + 1):
        value = _solve(data, across, along, noise)[0]
        found = _noise(data, _left(data, across, along, value))
        if all(abs(a - b) <= SETTLED * abs(a) for a, b in zip(found, noise, strict=True)):
            return noise, rounds
        noise = found
    return (0.0, 0.0), 0


def _left(data: Data, across: Array, along: Array, value: Array) -> tuple[Array, Array]:
    return data.d_az - across @ value, data.d_el - along @ value


def _variances(data: Data, noise: tuple[float, float]) -> tuple[Array, Array]:
    """Return the variances of azimuth and elevation offsets with the noise added."""
    per = np.cos(data.el) ** 2 if data.sky_noise else 1.0
    added = [np.sign(one) * one**2 for one in noise]
    return data.sigma_az**2 + added[0] / per, data.sigma_el**2 + added[1]


def _solve(
    data: Data, across: Array, along: Array, noise: tuple[float, float]
) -> tuple[Array, Array, float, Array]:
    """Return values, covariance, condition number and inflation of a weighted fit."""
    used = data.used
    weight = np.concatenate([1 / one[used] for one in _variances(data, noise)])
    design = np.concatenate([across[used], along[used]])
    measured = np.concatenate([data.d_az[used], data.d_el[used]])
    if len(measured) <= design.shape[1]:
        raise BadInput(f"{len(measured)} offsets cannot determine {design.shape[1]} parameters")
    normal = (design * weight[:, None]).T @ design
    scale = 1 / np.sqrt(np.diag(normal))
    scaled = normal * np.outer(scale, scale)
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(scaled))
    except np.linalg.LinAlgError:
        raise BadInput("these data cannot distinguish the fitted parameters: drop some") from None
    inverse = inverse.T @ inverse
    value = scale * (inverse @ (scale * (design.T @ (weight * measured))))
    condition = float(np.linalg.norm(scaled, 1) * np.linalg.norm(inverse, 1))
    return value, inverse * np.outer(scale, scale), condition, np.sqrt(np.diag(inverse))


def _noise(data: Data, left: tuple[Array, Array]) -> tuple[float, float]:
    """Return the noise to add to each axis for the weighted residuals to scatter by one.

    Both are halved in until both are near enough; negative takes away.
    """
    used = data.used
    sky = np.cos(data.el[used]) if data.sky_noise else np.ones(int(used.sum()))
    least = float((data.sigma_az[used] * sky).min()), float(data.sigma_el[used].min())
    low, high = np.array([-one for one in least]), np.maximum(WIDEST, 5 * np.array(least))
    for _ in range(HALVINGS):
        middle = low + 0.5 * (high - low)
        variance = _variances(data, (float(middle[0]), float(middle[1])))
        with np.errstate(invalid="ignore", divide="ignore"):
            rms = np.array(
                [
                    np.sqrt(np.mean(one[used] ** 2 / own[used]))
                    for one, own in zip(left, variance, strict=True)
                ]
            )
        if (np.abs(rms - 1) < NEAR_ONE).all():
            return float(middle[0]), float(middle[1])
        low = np.where(rms > 1, middle, low)
        high = np.where(rms < 1, middle, high)
    return 0.0, 0.0
