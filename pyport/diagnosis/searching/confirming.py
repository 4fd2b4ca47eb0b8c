"""Confirming: an effect against the noise that would do without it, either estimated anew."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.case import Chosen, Problem, confounded
from pyport.diagnosis.trial import at_best, shown
from pyport.diagnosis.weighing import by_columns, key_of, noise
from pyport.effects import Effect
from pyport.least_squares.gram import spanned
from pyport.noise.covariance import Covariance
from pyport.noise.estimation.estimate import TURNS, estimate
from pyport.runs.stages import stage
from pyport.thresholds import CONVINCING


def _noise_alike(
    problem: Problem, chosen: Sequence[Chosen], like: Sequence[Chosen], *, departing: bool = True
) -> Covariance:
    """Estimate the noise beside some effects, outliers and tails as beside others.

    Beside what is `departing` the likeliest drift; where nothing is, all drifts that are likely
    must do together what departures would.
    """

    def estimated() -> Covariance:
        design = problem.expanded([*problem.base, *by_columns(chosen)])
        frame = problem.frame if departing else replace(problem.frame, departures=())
        known = noise(problem, like, searching=False)
        # What an effect leaves behind passes from departures to drift and back.
        turns = TURNS if departing and len(chosen) < len(like) else 1
        return estimate(
            problem.residual, design, frame, like=known, averaged=not departing, turns=turns
        )

    key = departing, *key_of(like, searching=False), *key_of(chosen, searching=False)
    return problem.remembered(key, (*like, *chosen), estimated)


@stage("confirming")
def confirmed(problem: Problem, others: Sequence[Chosen], one: Chosen, price: float) -> float:
    """Return twice the log of how much likelier the data are with an effect than without.

    The coefficients of the effect come from one normal of the best width, those of everything
    else from a flat prior; scatter, drift and departures are estimated in either world. Outliers
    and tails are those of the world with the effect, which favours it: few readings may have very
    different ones without it. So where that convinces, what lasts has the mean of its evidence
    beside these and beside those. Of a change with time they are what it looks like.

    Parameters
    ----------
    problem
        The case.
    others, one
        What else is fitted, and the effect.
    price
        What its choice among its family costs.
    """
    paid = price + among(problem, one.candidate.effect)
    found = _gained(problem, others, one, like=(*others, one)) - paid
    if found > CONVINCING and not confounded(problem, one.candidate.effect):
        found = (found + _gained(problem, others, one, like=others) - paid) / 2
    return found


def _gained(
    problem: Problem, others: Sequence[Chosen], one: Chosen, *, like: Sequence[Chosen]
) -> float:
    """Return twice the log of how much likelier the data are, outliers and tails as beside some."""
    model = problem.expanded((*problem.base, *others))
    own = problem.expanded([one])
    value, after = problem.residual, (*others, one)
    noises = [
        noise(problem, like, searching=False),
        *(_noise_alike(problem, chosen, like) for chosen in (after, others)),
    ]
    if noises[-1].departures:
        # What walks on from night to night may have been taken for nights that depart.
        noises.append(_noise_alike(problem, others, like, departing=False))
    # Either world has the likeliest of them: what one estimate misses is no evidence.
    known = problem.precision([one])
    found = [_lack(covariance, model, own, value, known) for covariance in noises]
    without = min(lack for lack, _ in found)
    with_it = min(lack - gained for lack, gained in found)
    return without - with_it


def likeliest(problem: Problem, others: Sequence[Chosen], members: Sequence[Chosen]) -> Chosen:
    """Return the member of a family that makes the data likeliest, each beside its own noise."""
    best, *rest = members
    for one in rest:
        if lead(problem, others, best, one) < 0:
            best = one
    return best


def lead(problem: Problem, others: Sequence[Chosen], one: Chosen, other: Chosen) -> float:
    """Return twice the log of how much likelier the data are with an effect than with another.

    Each is beside the noise that it leaves, its price paid; `others` is what else is fitted. The
    outliers and tails of one world would excuse what they hold, so both worlds have those of
    either, and the mean counts.
    """
    found = [
        _worth(problem, others, one, like) - _worth(problem, others, other, like)
        for like in (one, other)
    ]
    return sum(found) / 2


def _worth(problem: Problem, others: Sequence[Chosen], one: Chosen, like: Chosen) -> float:
    """Return twice the log of how likely an effect makes the data, up to a constant."""
    if one is like:
        whole = noise(problem, (*others, one), searching=False)
    else:
        whole = _noise_alike(problem, (*others, one), (*others, like))
    model = problem.expanded((*problem.base, *others))
    own, known = problem.expanded([one]), problem.precision([one])
    lack, gained = _lack(whole, model, own, problem.residual, known)
    return gained - lack - one.candidate.price


def among(problem: Problem, own: Effect) -> float:
    """Return what it costs that an effect is one of many.

    Changes with time are among each other, a source's place is among them too, and all else is
    among all else. What consists of other changes is looked for where they stand: they do not pay
    for it.
    """
    alike = [
        effect
        for effect in problem.named
        if confounded(problem, effect) == confounded(problem, own)
        and (own.belongs_to or not effect.belongs_to)
        and (own.consists_of or not effect.consists_of)
    ]
    return 2 * float(np.log(max(len(alike), 1)))


def _improbable(covariance: Covariance) -> float:
    """Return minus twice the log of the prior of the departures' standard deviations.

    Half-Cauchy, as wide as the scatter from pointing to pointing (Gelman 2006, Bayesian
    Analysis 1, 515): of four nights three of which agree one has changed, rather than that all
    nights scatter by what it changed.
    """
    usual = float(np.mean([one.between**2 + one.within**2 for one in covariance.noises]))
    return sum(2 * float(np.log1p(one.sigma**2 / usual)) for one in covariance.departures)


def _lack(
    covariance: Covariance, model: Array, own: Array, value: Array, precision: Array | float
) -> tuple[float, float]:
    """Return minus twice the restricted log-likelihood beside a model, and an effect's evidence.

    The effect's coefficients have equal precision beforehand, each column measured by its length,
    or that which is known of them, `precision` (k,), up to a factor.
    """
    white = covariance.whiten(np.concatenate([model, own, value[:, None]], axis=1))
    p = model.shape[1]
    lack, basis, left = beside_model(covariance, white[:, :p], white[:, -1])
    rest = white[:, p:-1] - basis @ (basis.T @ white[:, p:-1])
    length = np.linalg.norm(white[:, p:-1], axis=0)
    return lack, at_best(*shown(rest, length, left, precision))[0]


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
    basis, strength, length = spanned(model)
    left = value - basis @ (basis.T @ value)
    lack = (
        covariance.log_determinant
        + _improbable(covariance)
        + 2 * float(np.log(strength).sum())
        + float(left @ left)
    )
    return lack + 2 * float(np.log(length[length > 0]).sum()), basis, left
