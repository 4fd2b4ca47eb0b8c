"""Where recordings say that an array's antennas stand, and whether a survey agrees.

An antenna that stands further east than the place its offsets were computed for
meets every hour angle early, and its vertical leans east: both are the same
curve, in all sources and on both axes but for the azimuth encoder's zero. So an
implied displacement is a lean toward east times the Earth's radius, and a mount
that leans of its own looks the same. Only a survey tells: leans that grow with
distance are the wrong site, what scatters about that is mechanical.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array
from pyport.diagnosis.arrays.lasting import Lasting
from pyport.effects.base import Site
from pyport.errors import BadInput
from pyport.recordings.files import Survey
from pyport.thresholds import ENOUGH_ANTENNAS, SIGNIFICANT, WORSE

#: Equatorial radius [m] and squared eccentricity of the Earth (WGS 84).
_RADIUS_M, _ECCENTRICITY_SQUARED = 6378137.0, 6.69437999014e-3


@dataclass(frozen=True)
class Places:
    """What recordings imply of the places of A antennas.

    Attributes
    ----------
    antennas
        Names.
    east_m, covariance_m2
        Implied displacement toward east of the median usable antenna, shape (A,), and its
        covariance without any lean of the mounts themselves, (A, A).
    usable
        Which antennas are known well enough, by their errors alone, shape (A,).
    radius_m
        Metres of displacement for a radian of lean.
    """

    antennas: tuple[str, ...]
    east_m: Array
    covariance_m2: Array
    usable: NDArray[np.bool_]
    radius_m: float

    @property
    def sigma_m(self) -> Array:
        """Return the one-sigma errors, shape (A,)."""
        return np.sqrt(np.diag(self.covariance_m2))


@dataclass(frozen=True)
class Comparison:
    """Implied displacements beside surveyed ones, over n antennas.

    Attributes
    ----------
    antennas
        Names of those compared.
    implied_m, surveyed_m
        Shape (n,), each about its mean.
    sigma_m
        Errors of the implied ones with the mounts' own leans in them, shape (n,).
    correlation, correlation_of_all
        Of the two; and with the antennas that are known too poorly to be used.
    slope, slope_sigma
        Implied over surveyed, by generalised least squares.
    lean_m
        Scatter of the mounts' own leans, as metres, by restricted maximum likelihood.
    delta_bic
        What the slope gains over leans alone.
    p_value
        Chance of so large a slope where there is none.
    unseen_m
        Rms of what each antenna implies, and of what is left of it when the slope comes from
        all others.
    missing
        Usable antennas that the survey lacks.
    """

    antennas: tuple[str, ...]
    implied_m: Array
    surveyed_m: Array
    sigma_m: Array
    correlation: float
    correlation_of_all: float
    slope: float
    slope_sigma: float
    lean_m: float
    delta_bic: float
    p_value: float
    unseen_m: tuple[float, float]
    missing: tuple[str, ...]

    @property
    def misses(self) -> Array:
        """Return how many of its sigmas each antenna is off the line, shape (n,)."""
        return (self.implied_m - self.slope * self.surveyed_m) / self.sigma_m

    @property
    def is_the_site(self) -> bool:
        """Tell whether leans grow with distance as those of displaced antennas do."""
        grows = self.slope > SIGNIFICANT * self.slope_sigma and self.delta_bic > 0
        return bool(grows and abs(self.slope - 1) <= SIGNIFICANT * self.slope_sigma)


def metres_per_radian(site: Site) -> float:
    """Return the radius of curvature along east [m]: metres for a radian of lean."""
    flattened = np.sqrt(1 - _ECCENTRICITY_SQUARED * np.sin(site.latitude) ** 2)
    return float(_RADIUS_M / flattened + site.height_m)


def places(parts: Lasting, lean: int, site: Site) -> Places:
    """Return the displacements toward east that an array's leans (shape number `lean`) imply."""
    radius = metres_per_radian(site)
    sigma = np.sqrt(np.diag(parts.own_covariance(lean)))
    usable = sigma <= WORSE * np.median(sigma)
    # errors about the centre of the usable ones, which all leans are counted from
    about = np.eye(len(usable)) - usable / usable.sum()
    value = parts.own[:, lean] - np.median(parts.own[usable, lean])
    covariance = about @ parts.own_covariance(lean) @ about.T
    return Places(parts.antennas, value * radius, covariance * radius**2, usable, radius)


def compare(found: Places, survey: Survey) -> Comparison | None:
    """Hold implied displacements against a survey; None with too few antennas in both.

    Raises
    ------
    BadInput
        The survey holds none of these antennas.
    """
    surveyed = dict(zip(survey.names, survey.east_m.tolist(), strict=True))
    if not surveyed.keys() & set(found.antennas):
        some = ", ".join(found.antennas[:3])
        raise BadInput(f"none of the recorded antennas is there, expected {some}, ...", survey.file)
    every = [n for n, name in enumerate(found.antennas) if name in surveyed]
    both = [n for n in every if found.usable[n]]
    if len(both) < ENOUGH_ANTENNAS:
        return None
    names = tuple(found.antennas[n] for n in both)
    implied, place = found.east_m[both], np.array([surveyed[name] for name in names])
    if np.ptp(place) == 0:
        return None
    implied, place = implied - implied.mean(), place - place.mean()
    covariance = found.covariance_m2[np.ix_(both, both)]
    lean = _own_scatter(np.stack([np.ones(len(place)), place], axis=1), implied, covariance)
    total = covariance + lean**2 * np.eye(len(place))
    line = _line(place, implied, total)
    return Comparison(
        names,
        implied,
        place,
        np.sqrt(np.diag(total)),
        float(np.corrcoef(implied, place)[0, 1]),
        float(np.corrcoef(found.east_m[every], [surveyed[found.antennas[n]] for n in every])[0, 1]),
        line[0],
        line[1],
        lean,
        _gain(place, implied, covariance),
        _chance(line, len(place)),
        _unseen(place, implied, total),
        tuple(found.antennas[n] for n in np.flatnonzero(found.usable) if n not in both),
    )


def _line(place: Array, implied: Array, covariance: Array) -> tuple[float, float]:
    """Return slope and sigma of a line with a free zero."""
    columns = np.stack([np.ones(len(place)), place / np.abs(place).max()], axis=1)
    weighted = np.linalg.solve(covariance, columns)
    inverse = np.linalg.inv(columns.T @ weighted)
    value = inverse @ (weighted.T @ implied) / np.abs(place).max()
    return float(value[1]), float(np.sqrt(inverse[1, 1]) / np.abs(place).max())


def _own_scatter(columns: Array, value: Array, covariance: Array) -> float:
    """Return the scatter beyond a covariance and some columns that is most likely (REML)."""
    from scipy.optimize import minimize_scalar

    unit = columns / np.linalg.norm(columns, axis=0)
    scale = float(np.sqrt(np.mean(value**2) + np.trace(covariance) / len(value)))
    eye = np.eye(len(value))

    def misfit(log_scatter: float) -> float:
        total = covariance + np.exp(2 * log_scatter) * eye
        return _log_likelihood(unit, value, total, restricted=True) * -2

    best = minimize_scalar(misfit, bounds=(np.log(scale) - 8, np.log(scale) + 2), method="bounded")
    return float(np.exp(best.x))


def _log_likelihood(columns: Array, value: Array, covariance: Array, *, restricted: bool) -> float:
    """Return the log likelihood of values about the best of some columns, constants left out."""
    solved = np.linalg.solve(covariance, columns)
    normal = columns.T @ solved
    left = value - columns @ np.linalg.solve(normal, solved.T @ value)
    total = float(left @ np.linalg.solve(covariance, left)) + np.linalg.slogdet(covariance)[1]
    if restricted:
        total += np.linalg.slogdet(normal)[1]
    return float(-total / 2)


def _gain(place: Array, implied: Array, covariance: Array) -> float:
    """Return by how much a slope lowers the BIC below leans alone, each at its best scatter."""
    one = np.ones((len(place), 1))
    misfits = []
    for columns in (one, np.concatenate([one, place[:, None]], axis=1)):
        scatter = _own_scatter(columns, implied, covariance)
        total = covariance + scatter**2 * np.eye(len(place))
        misfits.append(-2 * _log_likelihood(columns, implied, total, restricted=False))
    return misfits[0] - misfits[1] - float(np.log(len(place)))


def _chance(line: tuple[float, float], antennas: int) -> float:
    """Return the chance of a slope so many sigmas from zero."""
    from scipy.stats import t

    return float(2 * t.sf(abs(line[0] / line[1]), antennas - 2))


def _unseen(place: Array, implied: Array, covariance: Array) -> tuple[float, float]:
    """Return the rms about the others' mean, and about the line through all others."""
    left = np.zeros((2, len(place)))
    for n in range(len(place)):
        others = np.flatnonzero(np.arange(len(place)) != n)
        about_place, about = place[others].mean(), implied[others].mean()
        slope, _ = _line(
            place[others] - about_place, implied[others], covariance[np.ix_(others, others)]
        )
        left[:, n] = implied[n] - about
        left[1, n] -= slope * (place[n] - about_place)
    before, after = np.sqrt(np.mean(left**2, axis=1))
    return float(before), float(after)
