"""Turns of a search: how sure each is, and what it added."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from pyport.angles import Array
from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.evidence import Projection
from pyport.diagnosis.naming.classes import Name, name
from pyport.diagnosis.searching.contenders import Contender
from pyport.diagnosis.trial import CandidateFit
from pyport.diagnosis.weighing import WhitenedData
from pyport.runs.stages import stage


@stage("significance")
def family_p_value(trials: Sequence[CandidateFit]) -> float:
    """Return the probability that pure noise gives a search as good as the best of these.

    Each trial is scored by the chance of its gain under the F distribution; the
    best score is compared with the best score of every draw. Beyond the last
    draw the chance is that of the best trial alone times the number of
    independent trials that the draws show.
    """
    if not trials:
        return 1.0
    best = float(_log_chance(trials, np.array([[trial.gain] for trial in trials]))[0])
    drawn = _log_chance(trials, np.stack([trial.drawn for trial in trials]))
    above = (1 + int((drawn <= best).sum())) / (1 + len(drawn))
    if above > 5 / (1 + len(drawn)):
        return float(above)
    independent = max(1.0, np.log(2) / -np.log1p(-np.exp(float(np.median(drawn)))))
    return float(min(above, -np.expm1(-independent * np.exp(best))))


def _log_chance(trials: Sequence[CandidateFit], gains: Array) -> Array:
    """Return the least log-chance of gains (trials, draws) at least this large, shape (draws,).

    The F distribution's tail is an incomplete beta function; where that
    underflows its leading term stands for it. Of trials with as many
    coefficients and deviations the largest gain has the least chance.
    """
    from scipy.special import betainc, betaln

    half = np.array([[trial.dof / 2] for trial in trials])
    rest = np.array([[min(trial.noise_dof, 1e6) / 2] for trial in trials])
    alike, kind = np.unique(np.hstack([half, rest]), axis=0, return_inverse=True)
    gains = np.stack([gains[kind == n].max(axis=0) for n in range(len(alike))])
    half, rest = alike[:, :1], alike[:, 1:]
    x = rest / (rest + gains / 2)
    chance = betainc(rest, half, x)
    # Where x is one the chance is one, and its leading term, no number then, is not asked.
    with np.errstate(divide="ignore", invalid="ignore"):
        leading = rest * np.log(x) + (half - 1) * np.log1p(-x) - np.log(rest) - betaln(rest, half)
        log = np.where(chance > 1e-250, np.log(np.maximum(chance, 1e-300)), leading)
    return np.asarray(log.min(axis=0))


def gain_needed(
    trial: CandidateFit, evidence: float, departing: int = 1, readings: float = np.inf
) -> float:
    """Return the gain at which a trial's coefficients, all equally well known, have some evidence.

    At its best prior variance a gain t of k coefficients has t - k - k log(t / k). Of noise whose
    scale is known from n deviations a gain of n (exp(t / n) - 1) is worth no more than that. What
    sessions or sources that are `departing` may do as well is worth what is beyond theirs: as many
    coefficients of one variance, whose prior is as wide as the scatter of each one's `readings`.
    Infinite where no gain is enough.
    """
    from scipy.special import lambertw

    known = -trial.dof * float(lambertw(-np.exp(-1 - evidence / trial.dof), -1).real)
    if departing > 1:
        known = _beyond_departures(trial.dof, evidence, departing, readings)
    rest = min(trial.noise_dof, 1e6)
    return float(rest * np.expm1(known / rest))


#: A gain that is called out of reach: a hundred sigma.
MOST_GAIN = 1e4


def _beyond_departures(count: int, evidence: float, departing: int, readings: float) -> float:
    """Return the gain of some coefficients that has some evidence beyond that of departures."""
    from scipy.optimize import brentq

    others = count * (departing - 1)

    def lacks(log_gain: float) -> float:
        gain = float(np.exp(log_gain))
        wide = 2 * float(np.log1p(max(gain / others - 1, 0.0) / readings))
        return _worth(gain, count) - max(_worth(gain, others) - wide, 0.0) - evidence

    if lacks(most := float(np.log(MOST_GAIN))) < 0:
        return np.inf
    return float(np.exp(brentq(lacks, float(np.log(count)), most)))


def _worth(gain: float, count: int) -> float:
    """Return the evidence of a gain of some coefficients at their best prior variance."""
    return gain - count - count * float(np.log(gain / count)) if gain > count > 0 else 0.0


@dataclass(frozen=True)
class Step:
    """One turn of the search.

    Attributes
    ----------
    winner, chosen
        The trial that won, and what was added: the winner with its moment or edge refined.
    trials
        Everything that was tried beside the model of that turn.
    beside
        The evidence as it was weighed in that turn, with that model projected out.
    p_value
        Chance that noise alone gives a search as good as this, over all trials.
    price
        What the choice of the winner among its family cost, in twice the log odds.
    """

    winner: CandidateFit
    chosen: Chosen
    trials: tuple[CandidateFit, ...]
    beside: Projection
    p_value: float
    price: float = 0.0

    @cached_property
    def called(self) -> Name:
        """Return what the winner may be called."""
        return name(self.winner, self.trials, self.beside)


@dataclass(frozen=True)
class Outcome:
    """The end of a search: what was chosen in which turn, and the evidence weighed with all of it.

    `problem` is the case with the columns of what was refined added to it.
    `p_value` is that of the first turn: is there any mismatch at all?
    `last` holds the trials of the turn that found nothing more.
    `banned` are effects of known size that came out with another one: they are not found again.
    `nearest` is a change with time that is likelier than not and did not convince in that turn.
    """

    problem: Problem
    chosen: tuple[Chosen, ...]
    steps: tuple[Step, ...]
    weighed: WhitenedData
    p_value: float
    last: tuple[CandidateFit, ...]
    banned: frozenset[str] = frozenset()
    nearest: Contender | None = None

    @property
    def chance(self) -> float:
        """Return the chance that noise alone looks like the surest of what stands."""
        return min((self.step_of(one).p_value for one in self.chosen), default=self.p_value)

    def step_of(self, one: Chosen) -> Step:
        """Return the last turn in which something was chosen."""
        return next(step for step in reversed(self.steps) if step.chosen is one)

    def others(self, one: Chosen) -> tuple[Chosen, ...]:
        """Return what else was chosen."""
        return tuple(each for each in self.chosen if each is not one)

    def without(self, one: Chosen) -> Outcome:
        """Return the end with something dropped, its turn too; nothing is weighed anew."""
        steps = tuple(step for step in self.steps if step.chosen is not one)
        return replace(self, chosen=self.others(one), steps=steps)

    def exchanged(self, old: Chosen, new: Chosen, **turn: Any) -> Outcome:  # noqa: ANN401
        """Return the end with one choice in place of another; nothing is weighed anew.

        `turn`: what else becomes another in the turn of the old one, by the names of `Step`.
        """
        chosen = tuple(new if one is old else one for one in self.chosen)
        steps = tuple(
            replace(one, chosen=new, **turn) if one.chosen is old else one for one in self.steps
        )
        return replace(self, chosen=chosen, steps=steps)
