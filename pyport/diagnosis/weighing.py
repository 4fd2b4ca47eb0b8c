"""Weighing: the noise that a choice of effects leaves, and everything whitened by it.

While the search goes on every candidate is held against one noise. What changes with time can
pass for noise and noise for it, so before a change is accepted both worlds are fitted whole: one
where nights, sources and drifts do it all, and one with the change and what is left for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
from pyport.diagnosis.candidates import Candidate
from pyport.diagnosis.case import Chosen, Problem, confounded
from pyport.diagnosis.evidence import Evidence, at_best, shown
from pyport.least_squares.gram import spanned
from pyport.least_squares.robust import Refit
from pyport.noise import common_mode
from pyport.noise.covariance import Covariance
from pyport.noise.estimate import estimate, reweighed
from pyport.noise.series import Noise
from pyport.runs.stages import stage
from pyport.runs.workers import side_by_side
from pyport.thresholds import ENOUGH_ANTENNAS

DRAWS = 300


@dataclass(frozen=True)
class WhitenedData:
    """The evidence, weighed with the noise that a choice of effects leaves.

    Attributes
    ----------
    covariance
        Of the readings.
    white
        All columns and the data, whitened, shape (M, K + 1): see `Covariance.whiten`.
    evidence
        Their products.
    """

    covariance: Covariance
    white: Array
    evidence: Evidence

    @property
    def noises(self) -> tuple[Noise, ...]:
        """Return the noise of each series."""
        return self.covariance.noises

    @property
    def weights(self) -> Array:
        """Return the robust weights of the readings, shape (m,)."""
        return self.covariance.weights

    @property
    def used(self) -> NDArray[np.bool_]:
        """Tell which readings are no outliers, shape (m,)."""
        return self.covariance.used


@stage("whitening")
def weigh(setup: Problem, chosen: Sequence[Chosen] = (), *, searching: bool = True) -> WhitenedData:
    """Fit the noise that is left beside the model and some effects, and weigh everything by it.

    See `noise` for `searching`.
    """
    covariance = noise(setup, chosen, searching=searching)
    return _weighed(setup, chosen, covariance, covariance.whiten(setup.whole))


@stage("whitening")
def weigh_model(
    setup: Problem, chosen: Sequence[Chosen] = (), *, searching: bool = True
) -> WhitenedData:
    """Return what `weigh` does for what looks at the model and the data alone.

    No other column is whitened: they are zero. An array's common mode asks for all.
    """
    if setup.blocks.antennas >= ENOUGH_ANTENNAS:
        return weigh(setup, chosen, searching=searching)
    covariance = noise(setup, chosen, searching=searching)
    white = whiten_model(setup, covariance, (*setup.base, *chosen))
    return _weighed(setup, chosen, covariance, white)


def whiten_model(setup: Problem, covariance: Covariance, choices: Sequence[Chosen]) -> Array:
    """Return some choices' columns and the data, whitened, all others zero, (M, K + 1)."""
    size = setup.size
    columns = [np.zeros(0, np.intp), *(one.candidate.columns for one in choices)]
    own = np.unique(np.concatenate(columns))
    data = np.concatenate([setup.picked(own), setup.residual[:, None]], axis=1)
    # Column by column in memory: no page of those that stay zero is touched.
    white = np.zeros((covariance.means.stop, size + 1), order="F")
    white[:, np.append(own, size)] = covariance.whiten(data)
    return white


def _weighed(
    setup: Problem, chosen: Sequence[Chosen], covariance: Covariance, white: Array
) -> WhitenedData:
    evidence = Evidence(
        white,
        np.resize(setup.block, len(white)),
        np.resize(setup.stack.is_y, len(white)).astype(np.intp),
        setup.blocks,
        common=_common_excess(setup, (*setup.base, *chosen), white, covariance),
        pointings=len(np.unique(setup.pointing * 2 + setup.stack.is_y)),
        draws=DRAWS,
        dof=np.array([covariance.dof[one] for one in np.unique(setup.blocks.antenna)]),
        rng=np.random.default_rng(setup.seed),
    )
    return WhitenedData(covariance, white, evidence)


@stage("whitening")
def weigh_alike(setup: Problem, chosen: Sequence[Chosen], known: Covariance) -> WhitenedData:
    """Return what `weigh` does with the noise that is known; only outliers are looked for anew."""
    design = setup.expanded([*setup.base, *chosen])
    covariance = reweighed(known, setup.residual, design, setup.frame)
    setup.known[_key(chosen, searching=True)] = tuple(chosen), covariance
    return weigh(setup, chosen)


def _key(chosen: Sequence[Chosen], *, searching: bool) -> tuple[object, ...]:
    return (searching, *sorted((id(one.candidate), one.scope) for one in chosen))


@stage("fitting noise")
def noise(setup: Problem, chosen: Sequence[Chosen], *, searching: bool = True) -> Covariance:
    """Estimate the noise beside some effects, or remember it.

    Columns that join the design later do not touch it. While a search goes on, what its
    candidates could explain is no noise; in a final fit (`searching` false) it is.
    """
    key = _key(chosen, searching=searching)
    if key not in setup.known:
        design = setup.expanded([*setup.base, *chosen])
        shapes = setup.possible if searching else None
        covariance = estimate(setup.residual, design, setup.frame, shapes)
        # The choices are kept as long as the key that their identities make.
        setup.known[key] = tuple(chosen), covariance
    return setup.known[key][1]


def _noise_alike(
    setup: Problem, chosen: Sequence[Chosen], like: Sequence[Chosen], *, departing: bool = True
) -> Covariance:
    """Estimate the noise beside some effects, outliers and tails as beside others.

    Beside what is `departing` the likeliest drift; where nothing is, all drifts that are likely
    must do together what departures would.
    """
    key = (departing, *_key(like, searching=False), *_key(chosen, searching=False))
    if key not in setup.known:
        design = setup.expanded([*setup.base, *chosen])
        frame = setup.frame if departing else replace(setup.frame, departures=())
        known = noise(setup, like, searching=False)
        found = estimate(setup.residual, design, frame, like=known, averaged=not departing)
        setup.known[key] = (*like, *chosen), found
    return setup.known[key][1]


def _common_excess(
    setup: Problem, fitted: Sequence[Chosen], white: Array, covariance: Covariance
) -> common_mode.Excess:
    """Return how much more scans scatter in common than independent antennas would."""
    if setup.blocks.antennas < ENOUGH_ANTENNAS:
        return common_mode.Excess()
    columns = setup.expanded(fitted, of=white)
    left = Refit(columns, white[:, -1]).residual(np.ones(len(white)))
    means = covariance.means
    one = covariance.whiten(np.ones((len(setup.residual), 1)))[means, 0]
    return common_mode.excess(left[means], one, white[means, :-1], setup.scan)


@dataclass(frozen=True)
class View:
    """Weighted readings with a model projected out, each as if alone: drifts are passed over.

    Attributes
    ----------
    rows
        The readings that count, shape (n,).
    root
        Root of their weights, shape (n,).
    basis
        Orthonormal columns that span the model, shape (n, p).
    left
        What the model leaves of the data, weighted, shape (n,).
    """

    rows: Codes
    root: Array
    basis: Array
    left: Array


def plain_view(setup: Problem, weighed: WhitenedData, chosen: Sequence[Chosen]) -> View:
    """Return the readings beside a model, outliers left out."""
    scatter = weighed.covariance.scatter
    rows = np.flatnonzero(weighed.used)
    root = np.sqrt(weighed.weights[rows]) / scatter[rows]
    model = setup.expanded((*setup.base, *chosen))[rows] * root[:, None]
    basis = spanned(model)[0]
    data = setup.residual[rows] * root
    return View(rows, root, basis, data - basis @ (basis.T @ data))


def shown_beside(
    setup: Problem, weighed: WhitenedData, chosen: Sequence[Chosen], candidates: Sequence[Candidate]
) -> list[tuple[Array, Array]]:
    """Return what the data show of each candidate beside the model and what is chosen: `shown`."""
    model = setup.expanded((*setup.base, *chosen), of=weighed.white)
    places = [one.columns for one in candidates]
    own = weighed.covariance.whiten(setup.picked(np.concatenate(places)))
    both = np.concatenate([own, weighed.white[:, -1:]], axis=1)
    left = both - model @ np.linalg.lstsq(model, both, rcond=1e-9)[0]
    length = np.linalg.norm(own, axis=0)
    starts = np.cumsum([0, *map(len, places)])
    return [shown(left[:, low:up], length[low:up], left[:, -1]) for low, up in pairwise(starts)]


@stage("confirming")
def confirmed(setup: Problem, others: Sequence[Chosen], one: Chosen, price: float) -> float:
    """Return twice the log of how much likelier the data are with an effect than without.

    The coefficients of the effect come from one normal of the best width, those of everything
    else from a flat prior; scatter, drift and departures are estimated in either world, outliers
    and tails are those of the world with the effect.

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
    value, after = setup.residual, (*others, one)
    noises = [
        noise(setup, after, searching=False),
        *side_by_side(lambda chosen: _noise_alike(setup, chosen, after), (after, tuple(others))),
    ]
    if noises[-1].departures:
        # What walks on from night to night may have been taken for nights that depart.
        noises.append(_noise_alike(setup, others, after, departing=False))
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
    """Return what it costs that an effect is one of many.

    Changes with time are among each other, a source's place is among them too, and all else is
    among all else.
    """
    own = one.candidate.effect
    ids = {
        effect.id
        for effect in (each.effect for each in setup.candidates)
        if confounded(setup, effect) == confounded(setup, own)
        and (own.belongs_to or not effect.belongs_to)
    }
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
    basis, strength, length = spanned(model)
    left = value - basis @ (basis.T @ value)
    lack = (
        covariance.log_determinant
        + _improbable(covariance)
        + 2 * float(np.log(strength).sum())
        + float(left @ left)
    )
    return lack + 2 * float(np.log(length[length > 0]).sum()), basis, left
