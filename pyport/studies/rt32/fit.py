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
from pyport.least_squares.gram import inverted
from pyport.pointing import PARAMETERS, Rt32Model
from pyport.pointing.model import Linear
from pyport.recordings.schema import Recordings, Stack, group, stack
from pyport.runs.workers import one_thread
from pyport.studies.rt32.losses import LEVEL, METHODS, BoxStep, Tuned, variance
from pyport.studies.rt32.settle import ROUNDS, Design, settle

#: The document's weights are no larger than at this cosine of altitude.
_LEAST_COSINE = 0.01

#: Linearisations of the exact form: from zero a fourth one changes millionths of a sigma.
_LINEARISATIONS = 3
#: Most rounds of weighing on the way.
_ROUGH = 2


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
    design: Design  #: offsets of one radian of each
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
    earlier = none if box is None else box.earlier.astype(float)
    stepped = data.spread(earlier, none)
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
    # both forms are the same about zero, where all offsets are zero
    linear, left = Linear.of(recordings.at), data.value
    start: Array | None = None
    turns = _LINEARISATIONS if exact else 1
    for turn in range(turns):
        # On the way votes go on from where they were; at the end they settle from equal ones.
        last = turn == turns - 1
        x, y = linear.x, linear.y
        if turn > 0:
            model = Rt32Model(p[: len(PARAMETERS)], exact)
            with np.errstate(invalid="ignore"):  # a lean that no mount can have, see below
                x, y = model.slopes(recordings.at, linear)
                left = data.value - data.spread(*model.offsets(recordings.at))
        if step is None:
            x = x | {len(PARAMETERS): earlier}
        design = Design.of(data, x, y, size)
        if not (np.isfinite(left).all() and design.finite):
            raise BadInput(
                "the fit does not converge: it asks for parameters that no telescope can have",
                recordings.file,
            )
        left = left - (p[-1] if step is None else step) * stepped
        found = settle(
            design, left, tune, prior, None if last else start, ROUNDS if last else _ROUGH
        )
        p, start = p + found.values, found.weight
    residual, weight, tuned = found.residual, found.weight, found.tuned
    inside = int((np.abs(residual) <= level).sum())
    if method == "document" and inside < size:
        raise BadInput(
            f"{inside} offsets within {level / DEG:g} deg of the fit cannot determine {size}"
            " parameters, expected a larger level",
            recordings.file,
        )
    inverse, _, condition, known = inverted(design.products(weight * prior, residual)[0])
    open_or_not = np.where(known, 1.0, np.nan)
    return Rt32Fit(
        recordings, data, method, level, exact, np.nan if step is None else step,
        p * open_or_not,
        inverse * variance(residual, tuned, prior) * np.outer(open_or_not, open_or_not),
        design, residual, weight, prior, tuned, found.rounds, condition, found.settled,
    )  # fmt: skip


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
        found = settle(fit.design, fit.residual, lambda _: fit.tuned, times * fit.prior)
        drawn[k] = fit.values + found.values
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
