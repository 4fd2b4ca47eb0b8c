"""What a residual's vote is worth: the document's cut, and three robust losses beside it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import ARCSEC, DEG, Array
from pyport.errors import BadInput
from pyport.least_squares import robust
from pyport.pointing import kernel
from pyport.recordings.schema import Recordings

#: 2004-01-01, after which the box offset was another [s, UTC since 1970].
_CHANGED_S = 1072915200.0

#: How much larger the box offset was before, to 0.001 deg as the document has it [deg].
BOX_STEP_DEG = 0.017


@dataclass(frozen=True)
class BoxStep:
    """What is done about the beam's having been moved."""

    earlier: NDArray[np.bool_]  #: which recordings were made before, shape (n,)
    step: float | None  #: the box offset before less that after [rad]; None to fit it


def box_step(recordings: Recordings, choice: str = "known") -> BoxStep:
    """Return the step to subtract, or to fit, where recordings lie on both sides of it.

    `recordings`: with times, or else they are taken to be of one campaign.
    `choice`: "known" for the document's 0.017 deg, "fit", or degrees as text.
    Raises `BadInput`: the choice is none of these.
    """
    if choice == "fit":
        step = None
    else:
        try:
            step = BOX_STEP_DEG * DEG if choice == "known" else float(choice) * DEG
        except ValueError:
            raise BadInput(
                f"the step of the box offset is {choice!r}, expected known, fit or degrees"
            ) from None
    earlier = np.zeros(len(recordings), bool)
    if "time" in recordings.at:
        earlier = np.asarray(recordings.at.column("time"), float) < _CHANGED_S
    if earlier.all():
        earlier = ~earlier
    return BoxStep(earlier, step)


#: The document's level: residuals beyond it lose their vote [rad].
LEVEL = 0.007 * DEG

#: No scatter is smaller, not that of offsets that a model draws to the last digit [rad].
LEAST = 1e-12

#: What is left of the weight of a residual beyond the level.
_DOWNWEIGHT = 1e-3

#: Huber's corner in sigmas: 95 % efficient where the noise is normal.
_HUBER_CORNER = 1.345

#: Degrees of freedom that Student's t may have; beyond it is a normal distribution.
_DEGREES = (1.0, 100.0)

#: The sizes of residuals that their distribution is read off at.
_QUANTILES = (np.arange(500) + 0.5) / 500


@dataclass(frozen=True)
class Tuned:
    """A loss whose scale is set."""

    #: Residuals [rad] -> weights of their squares, one where the vote is full.
    weight: Callable[[Array], Array]
    #: Residuals [rad], their weights -> the derivative of weight times residual, where it has one.
    slope: Callable[[Array, Array], Array]
    text: str  #: scale and shape, in words


#: Residuals [rad] -> the loss with its scale set by them.
Tune = Callable[[Array], Tuned]


def document(level: float) -> Tune:
    """Return the document's: one vote inside the level [rad], a thousandth of it beyond."""

    def weight(residual: Array) -> Array:
        return np.where(np.abs(residual) <= level, 1.0, _DOWNWEIGHT)

    # the steps at the level have no slope: `cut_factor` says what that hides
    tuned = Tuned(weight, lambda _, w: w, f"level {level / DEG:.4f} deg")
    return lambda residual: tuned  # noqa: ARG005 - the level is the user's, whatever the residuals


def soft_l1(residual: Array) -> Tuned:
    """Return 2 (sqrt(1 + u^2) - 1), u in robust sigmas: a square that goes over into a line."""
    sigma = robust.scale(residual, LEAST, middle=kernel.median)

    return Tuned(
        lambda r: 1 / np.sqrt(1 + (r / sigma) ** 2),
        lambda _, w: w * w * w,
        f"scale {sigma / ARCSEC:.1f} arcsec",
    )


def huber(residual: Array) -> Tuned:
    """Return Huber's: a square inside 1.345 robust sigmas, a line beyond."""
    corner = _HUBER_CORNER * robust.scale(residual, LEAST, middle=kernel.median)
    return Tuned(
        lambda r: corner / np.maximum(np.abs(r), corner),
        lambda r, _: (np.abs(r) <= corner).astype(float),
        f"corner {corner / ARCSEC:.1f} arcsec",
    )


def student_t(residual: Array) -> Tuned:
    """Return minus the logarithm of Student's t, its scale and degrees of freedom the likeliest."""
    sigma, nu = _likeliest_t(residual)
    return Tuned(
        lambda r: (nu + 1) / (nu + (r / sigma) ** 2),
        lambda r, _: (nu + 1) * (nu - (r / sigma) ** 2) / (nu + (r / sigma) ** 2) ** 2,
        f"scale {sigma / ARCSEC:.1f} arcsec, {nu:.1f} degrees of freedom",
    )


def _likeliest_t(residual: Array) -> tuple[float, float]:
    """Return scale [rad] and degrees of freedom of Student's t that are likeliest."""
    from scipy.optimize import minimize
    from scipy.special import gammaln

    start = robust.scale(residual, LEAST, middle=kernel.median)
    size = np.quantile(np.abs(residual), _QUANTILES) / start

    def unlikeliness(logs: Array) -> float:
        scale, nu = np.exp(logs)
        norm = gammaln((nu + 1) / 2) - gammaln(nu / 2) - 0.5 * np.log(nu * np.pi) - np.log(scale)
        tails = (nu + 1) / 2 * np.mean(np.log1p((size / scale) ** 2 / nu))
        return float(tails - norm)

    bounds = [(np.log(0.05), np.log(20.0)), tuple(np.log(_DEGREES))]
    found = minimize(unlikeliness, [0.0, np.log(4.0)], method="L-BFGS-B", bounds=bounds)
    return start * float(np.exp(found.x[0])), float(np.exp(found.x[1]))


#: Ways to fit by name, each made for the document's level [rad].
METHODS: dict[str, Callable[[float], Tune]] = {
    "document": document,
    "soft-l1": lambda level: soft_l1,  # noqa: ARG005 - these find their own scale
    "huber": lambda level: huber,  # noqa: ARG005
    "student-t": lambda level: student_t,  # noqa: ARG005
}


def variance(residual: Array, tuned: Tuned, prior: Array) -> float:
    """Return what the inverse of the weighted normal matrix is to be multiplied with [rad^2].

    mean(w) mean(g psi^2) / mean(psi')^2, psi = w r and g what a square counts
    before any vote: the variance of an M-estimate with independent errors. For
    the document's cut it is the weighted mean square of the kept residuals.
    """
    weight = tuned.weight(residual)
    psi = weight * residual
    return float(
        weight.mean() * np.mean(prior * psi**2) / tuned.slope(residual, weight).mean() ** 2
    )


def cut_factor(residual: Array, level: float) -> float:
    """Return by how much cutting at the level makes formal sigmas too small.

    A residual at the level votes or not depending on the fit itself, so the
    mean slope of the votes is the share of the kept residuals less 2 L f(L), f
    their density. It is counted within a fifth of the level around it.
    """
    size = np.abs(residual)
    kept = float((size <= level).sum())
    near = float((np.abs(size - level) <= 0.2 * level).sum()) / 0.4
    return kept / (kept - near) if near < kept else float("inf")
