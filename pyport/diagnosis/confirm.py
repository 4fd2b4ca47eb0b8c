"""Confirmation: the evidence for a change with time, the noise estimated with it and without it.

While the search goes on every candidate is held against one noise. What changes with time can
pass for noise and noise for it, so before a change is accepted both worlds are fitted whole: one
where nights, sources and drifts do it all, and one with the change and what is left for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.case import Chosen, Problem, noise, temporal
from pyport.diagnosis.evidence import at_best, shown
from pyport.noise.covariance import Covariance
from pyport.noise.estimate import estimate
from pyport.stages import stage
from pyport.threads import side_by_side


@stage("confirming")
def confirmed(setup: Problem, others: Sequence[Chosen], one: Chosen, price: float) -> float:
    """Return twice the log of how much likelier the data are with an effect than without.

    The coefficients of the effect come from one normal of the best width, those of everything
    else from a flat prior; the variances of scatter, drift and departures are the likeliest in
    either world, outliers and tails those of the world with the effect.

    Parameters
    ----------
    setup
        The case.
    others, one
        What else is fitted, and the effect.
    price
        What its choice among its family costs.
    """
    model = setup.expanded((*setup.base, *others))
    own = setup.expanded([one])
    whole = noise(setup, (*others, one), searching=False)
    value = setup.residual
    worlds = np.concatenate([model, own], axis=1), model
    noises = [
        whole,
        *side_by_side(lambda world: estimate(value, world, setup.frame, like=whole), worlds),
    ]
    noises += [replace(one, departures=()) for one in noises if one.departures]
    # Either world has the likeliest of them: what one estimate misses is no evidence.
    found = [_lack(covariance, model, own, value) for covariance in noises]
    without = min(lack for lack, _ in found)
    with_it = min(lack - gained for lack, gained in found)
    return without - with_it - price - _among(setup, one)


def likeliest(setup: Problem, others: Sequence[Chosen], members: Sequence[Chosen]) -> Chosen:
    """Return the member of a family that makes the data likeliest, each beside its own noise."""
    model = setup.expanded((*setup.base, *others))

    def worth(one: Chosen) -> float:
        whole = noise(setup, (*others, one), searching=False)
        lack, gained = _lack(whole, model, setup.expanded([one]), setup.residual)
        return gained - lack

    return max(members, key=worth)


def _among(setup: Problem, one: Chosen) -> float:
    """Return what it costs that an effect is one of many: changes with time, or all the others."""
    kind = temporal(setup, one.candidate.effect)
    ids = {each.effect.id for each in setup.candidates if temporal(setup, each.effect) == kind}
    return 2 * float(np.log(max(len(ids), 1)))


def _improbable(covariance: Covariance) -> float:
    """Return minus twice the log of the prior of the departures' standard deviations.

    Half-Cauchy, as wide as the scatter from pointing to pointing (Gelman 2006, Bayesian
    Analysis 1, 515): of four nights three of which agree one has changed, rather than that all
    nights scatter by what it changed.
    """
    usual = float(np.mean([one.between**2 + one.within**2 for one in covariance.noises]))
    return sum(2 * float(np.log1p(one.sigma**2 / usual)) for one in covariance.departures)


def _lack(covariance: Covariance, model: Array, own: Array, value: Array) -> tuple[float, float]:
    """Return minus twice the restricted log-likelihood beside a model, and an effect's evidence."""
    white = covariance.whiten(np.concatenate([model, own, value[:, None]], axis=1))
    p = model.shape[1]
    lack, basis, left = beside_model(covariance, white[:, :p], white[:, -1])
    rest = white[:, p:-1] - basis @ (basis.T @ white[:, p:-1])
    size = np.linalg.norm(white[:, p:-1], axis=0)
    return lack, at_best(*shown(rest, size, left))[0]


def beside_model(covariance: Covariance, model: Array, value: Array) -> tuple[float, Array, Array]:
    """Return minus twice the restricted log-likelihood of a noise, and what a model leaves.

    Parameters
    ----------
    covariance
        The noise.
    model, value
        The model's columns (M, p) and the data (M,), whitened by it.

    Returns
    -------
    lack
        With the departures' prior.
    basis, left
        Orthonormal directions of the model, and the data without them, shape (M,).
    """
    length = np.linalg.norm(model, axis=0)
    basis, strength, _ = np.linalg.svd(
        model / np.where(length > 0, length, 1.0), full_matrices=False
    )
    kept = strength > 1e-9 * strength.max(initial=1e-300)
    basis = basis[:, kept]
    left = value - basis @ (basis.T @ value)
    lack = (
        covariance.log_determinant
        + _improbable(covariance)
        + 2 * float(np.log(strength[kept]).sum())
        + float(left @ left)
    )
    return lack + 2 * float(np.log(length[length > 0]).sum()), basis, left
