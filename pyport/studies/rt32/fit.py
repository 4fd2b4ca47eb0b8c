"""The document's fit: both axes as one list, votes weighed anew until they settle.

Azimuth offsets are taken times cos H, which makes them offsets on the sky, and
both axes share the tilts (and, in the exact form, skew and box offset too). The
document weighted the squares of its azimuth offsets, not those on the sky, by
cos H; the robust methods weight both axes alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pyport.angles import DEG, Array, Codes
from pyport.errors import BadInput
from pyport.fitting.soundness import doubts
from pyport.least_squares.gram import inverse_of, inverted
from pyport.pointing import PARAMETERS, Rt32Model, kernel
from pyport.pointing.model import linear_columns
from pyport.recordings.schema import Recordings, Stack, group, stack
from pyport.runs.workers import one_thread
from pyport.studies.rt32.losses import LEVEL, METHODS, BoxStep, Tune, Tuned, variance

#: The document's weights are no larger than at this cosine of altitude.
_LEAST_COSINE = 0.01

#: Linearisations of the exact form: from zero a fourth one changes millionths of a sigma.
_LINEARISATIONS = 3
#: Most rounds of weighing, on the way and at the end; votes within this of each other have settled.
_ROUGH, _ROUNDS = 2, 60
_SETTLED = 1e-4


@dataclass(frozen=True)
class Rt32Fit:
    """The fitted parameters of the RT32, and what they leave."""

    #: `recordings`, `stack`: what was fitted.
    recordings: Recordings
    stack: Stack
    #: `method`, `level`, `exact`: how: a name out of `METHODS`, the document's level [rad], the
    #: form of the model.
    method: str
    level: float
    exact: bool
    #: Box offset of the earlier campaign that was subtracted [rad], NaN where it was fitted, zero
    #: where there is one campaign only.
    step: float
    #: `values`, `covariance`: p1..p12 [rad] and, where it was fitted, the step of the box offset
    #: last; sigmas are formal: errors independent, no vote in doubt.
    values: Array
    covariance: Array
    columns: Array  #: offsets of one radian of each, shape (m, P)
    #: `residual`, `weight`: what is left [rad] and its vote, shape (m,).
    residual: Array
    weight: Array
    prior: Array  #: what a square on the sky counts before any vote, shape (m,)
    tuned: Tuned  #: the loss with its scale
    rounds: int  #: how often votes were weighed before they settled
    condition: float  #: condition number of the weighted columns, scaled to unit length
    settled: bool  #: whether the votes came to rest

    @property
    def sigmas(self) -> Array:
        """Return the formal standard errors [rad], NaN where the data leave a parameter open."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Array:
        """Return the correlations of the parameters."""
        sigma = np.where(self.sigmas > 0, self.sigmas, np.nan)
        return self.covariance / np.outer(sigma, sigma)

    @property
    def doubts(self) -> list[str]:
        """Return what is wrong with the fit as a whole."""
        known = np.isfinite(self.values)
        voting = self.inside if self.method == "document" else self.weight > 0
        return list(
            doubts(
                condition=self.condition,
                covariance=self.covariance[np.ix_(known, known)],
                numbers=int(voting.sum()),
                rank=int(known.sum()),
                settled=self.settled,
            )
        )

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Return which residuals lie within the level."""
        return np.abs(self.residual) <= self.level

    @property
    def rms(self) -> float:
        """Return the rms of the residuals within the level [rad]."""
        inside = self.residual[self.inside]
        return float(np.sqrt(np.mean(inside**2))) if len(inside) else float("nan")


@one_thread
def fit_rt32(
    recordings: Recordings,
    *,
    exact: bool = True,
    method: str = "document",
    level: float = LEVEL,
    box: BoxStep | None = None,
) -> Rt32Fit:
    """Fit p1..p12 to recordings of one telescope.

    `recordings`: offsets on either or both axes.
    `exact`: which form of the model.
    `method`: one of `METHODS`.
    `level`: beyond which the document's method takes the vote from a residual [rad].
    `box`: the step of the box offset between campaigns; None where there is none.
    Raises `BadInput`: there is no such method, there are fewer offsets (or, by the document's
      method, fewer within the level) than parameters, or more antennas than one.
    """
    if method not in METHODS:
        raise BadInput(f"no method is called {method!r}, expected one of {', '.join(METHODS)}")
    antennas = len(np.unique(recordings.label("antenna")))
    if antennas > 1:
        raise BadInput(f"{antennas} antennas, expected one telescope's offsets", recordings.file)
    data = stack(recordings)
    none = np.zeros(len(recordings))
    stepped = data.spread(none if box is None else box.earlier.astype(float), none)
    step = box.step if box is not None and stepped.any() else 0.0
    size = len(PARAMETERS) + (step is None)
    if len(data) < size:
        raise BadInput(
            f"{len(data)} measured offsets cannot determine {size} parameters", recordings.file
        )
    tune = METHODS[method](level)
    prior = np.ones(len(data))
    if method == "document":
        cosine = np.cos(recordings.at.el[data.row])
        prior = np.where(data.is_y, 1.0, 1 / np.maximum(cosine, _LEAST_COSINE))
    p = np.zeros(size)
    linear = linear_columns(recordings.at)
    start: Array | None = None
    turns = _LINEARISATIONS if exact else 1
    for turn in range(turns):
        # On the way votes go on from where they were; at the end they settle from equal ones.
        last = turn == turns - 1
        if turn == 0:
            # both forms are the same about zero, where all offsets are zero
            columns, left = data.spread(*linear), data.value
        else:
            model = Rt32Model(p[: len(PARAMETERS)], exact)
            with np.errstate(invalid="ignore"):  # a lean that no mount can have, see below
                columns = data.spread(*model.columns(recordings.at, linear))
                left = data.value - data.spread(*model.offsets(recordings.at))
        if not (np.isfinite(left).all() and np.isfinite(columns).all()):
            raise BadInput(
                "the fit does not converge: it asks for parameters that no telescope can have",
                recordings.file,
            )
        left = left - (p[-1] if step is None else step) * stepped
        if step is None:
            columns = np.column_stack([columns, stepped])
        change, tuned, rounds, settled = settle(
            columns,
            left,
            data.is_y,
            tune,
            prior,
            None if last else start,
            _ROUNDS if last else _ROUGH,
        )
        p = p + change
        start = tuned.weight(left - columns @ change)
    residual = left - columns @ change
    inside = int((np.abs(residual) <= level).sum())
    if method == "document" and inside < size:
        raise BadInput(
            f"{inside} offsets within {level / DEG:g} deg of the fit cannot determine {size}"
            " parameters, expected a larger level",
            recordings.file,
        )
    weight = tuned.weight(residual)
    normal, _ = kernel.gram(np.ascontiguousarray(columns.T), weight * prior, residual)
    inverse, _, condition, known = inverted(normal)
    open_or_not = np.where(known, 1.0, np.nan)
    return Rt32Fit(
        recordings, data, method, level, exact, np.nan if step is None else step,
        p * open_or_not,
        inverse * variance(residual, tuned, prior) * np.outer(open_or_not, open_or_not),
        columns, residual, weight, prior, tuned, rounds, condition, settled,
    )  # fmt: skip


def settle(
    columns: Array,
    value: Array,
    is_y: NDArray[np.bool_],
    tune: Tune,
    times: Array,
    start: Array | None = None,
    most: int = _ROUNDS,
) -> tuple[Array, Tuned, int, bool]:
    """Return the coefficients at which votes and residuals agree, and how that came about.

    With them come the loss, the rounds it took, and whether votes had settled by then.

    `columns`, `value`: the design (m, P) and the data (m,).
    `is_y`: which axis each datum is of, cross-elevations first as a stack has them, shape (m,).
    `tune`: what sets the votes by the residuals.
    `times`: how often each datum counts, shape (m,).
    `start`: votes to begin with, shape (m,); all are equal when not given.
    `most`: rounds after which it ends whether votes have settled or not.
    """
    weight = np.ones(len(value)) if start is None else start
    halves = _halves(columns, is_y)
    solution, residual, slope = np.zeros(columns.shape[1]), value, weight
    for rounds in range(1, most + 1):
        normal, right = np.zeros((len(solution),) * 2), np.zeros(len(solution))
        heavy, target = slope * times, weight * times * residual
        for rows, which, own in halves:
            products, sums = kernel.gram(own, heavy[rows], target[rows])
            normal[np.ix_(which, which)] += products
            right[which] += sums
        solution = solution + inverse_of(normal)[0] @ right
        residual = np.concatenate(
            [value[rows] - solution[which] @ own for rows, which, own in halves]
        )
        tuned = tune(residual)
        new = tuned.weight(residual)
        if np.max(np.abs(new - weight)) < _SETTLED:
            return solution, tuned, rounds, True
        weight = new
        # near the end Newton's steps: they know that votes change as residuals do
        slope = weight if rounds == 1 else np.maximum(tuned.slope(residual), weight / 4)
    return solution, tuned, most, False


def _halves(columns: Array, is_y: NDArray[np.bool_]) -> list[tuple[slice, Codes, Array]]:
    """Return the rows of either axis, the columns that move it, and these turned, (k, rows)."""
    first = int((~is_y).sum())
    found = []
    for rows in (slice(0, first), slice(first, len(columns))):
        which = np.flatnonzero(columns[rows].any(axis=0))
        found.append((rows, which, np.ascontiguousarray(columns[rows][:, which].T)))
    return found


_DAY_S = 86400.0


def bootstrap(fit: Rt32Fit, draws: int = 300, seed: int = 0) -> Array:
    """Return the parameters of `draws` campaigns made of sessions of this one, shape (draws, P).

    Errors that last as long as a session make formal sigmas too small; sessions,
    drawn with replacement, are as independent as anything that was measured. The
    model is taken as linear about the fit, the scale of the loss is held, votes
    are weighed anew.

    Raises `BadInput`: there are fewer than two sessions.
    """
    session = sessions(fit.recordings)[fit.stack.row]
    count = int(session.max()) + 1
    if count < 2:
        raise BadInput("one session: expected two or more to draw from", fit.recordings.file)
    rng = np.random.default_rng(seed)
    drawn = np.empty((draws, len(fit.values)))
    for k in range(draws):
        times = np.bincount(rng.integers(count, size=count), minlength=count)[session]
        change, _, _, _ = settle(
            fit.columns, fit.residual, fit.stack.is_y, lambda _: fit.tuned, times * fit.prior
        )
        drawn[k] = fit.values + change
    return drawn


def honest_sigmas(fit: Rt32Fit) -> Array:
    """Return how far drawn parameters scatter [rad], shape (P,); NaN with one session only."""
    if sessions(fit.recordings).max() == 0:
        return np.full(len(fit.values), np.nan)
    return bootstrap(fit).std(axis=0, ddof=1)


def sessions(recordings: Recordings) -> Codes:
    """Return the number of each recording's session, or of its day; all are one without times."""
    if "session" in recordings.at or "time" not in recordings.at:
        return group(recordings, ("session",))[0]
    day = np.floor(recordings.at.numbers("time") / _DAY_S)
    return np.unique(day, return_inverse=True)[1]
