"""Changes with time, confirmed: what the noise, estimated anew, cannot do as well."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from pyport.diagnosis.case import Chosen, Problem
from pyport.diagnosis.evidence import Projection
from pyport.diagnosis.searching.changes import proposed
from pyport.diagnosis.searching.contenders import Contender, evidence_anew, refined, waves_of
from pyport.diagnosis.shapes import oscillations
from pyport.diagnosis.trial import CandidateFit
from pyport.effects.empirical.oscillations import OSCILLATION
from pyport.noise.covariance import Covariance
from pyport.thresholds import CONVINCING


@dataclass(frozen=True)
class Changes:
    """The changes with time that are looked for in a turn.

    Attributes
    ----------
    problem, chosen
        The case, and what stands in the turn.
    present
        The noise of the turn.
    trials
        All that was tried there.
    banned
        Effects that are not proposed.
    known
        What was confirmed before, by what it was to exceed.
    """

    problem: Problem
    present: Covariance
    chosen: tuple[Chosen, ...]
    trials: Sequence[CandidateFit]
    banned: Collection[str] = ()
    known: dict[float, list[Contender]] = field(default_factory=dict)

    def nearest(self) -> Contender | None:
        """Return the change that is likelier than not and does not convince; None where none is."""
        likely = [one for one in self.confirmed(-np.inf) if 0 < one.trial.evidence <= CONVINCING]
        return max(likely, key=lambda one: one.trial.evidence, default=None)

    def confirmed(self, above: float) -> list[Contender]:
        """Return each with its evidence beside noise estimated anew.

        Those that promise more than `above` beside noise that holds still. They are remembered:
        a turn that finds nothing asks for the same ones again.
        """
        if above not in self.known:
            self.known[above] = self._confirmed(above)
        return self.known[above]

    def _confirmed(self, above: float) -> list[Contender]:
        waves = self._waves(above)
        # What wins must be distinguished from a wave: its columns stand in the case of every one.
        every = self._refined_in(waves[0].problem) if waves else self._refined
        least = max(CONVINCING, above)
        moved = [one for one in every if one.trial.evidence > least]
        beside = waves[0].beside if waves else None
        sure_of = partial(self._sure_of, beside)
        found = [sure_of(one) for one in moved if not one.effect.consists_of]
        standing = {one.effect.on_altaz for one in found if one.trial.evidence > CONVINCING}
        wholes = [
            one
            for one in moved
            if standing.intersection(one.effect.consists_of) and _is_all_of_it(one, moved)
        ]
        return [*found, *map(sure_of, wholes), *waves]

    def _waves(self, above: float) -> list[Contender]:
        """Return the wave that is proposed, if any."""
        if OSCILLATION in self.banned:
            return []
        one = oscillations.proposed(self.problem, self.present, self.chosen, above)
        return waves_of(self.problem, self.chosen, one)

    @cached_property
    def _proposed(self) -> tuple[Covariance, list[CandidateFit]]:
        """Return the noise that holds still and what is worth a closer look beside it."""
        return proposed(self.problem, self.present, self.chosen, self.trials, self.banned)

    @cached_property
    def _refined(self) -> list[Contender]:
        """Return what is proposed, steps at their best moment, with no wave in the case."""
        return self._refined_in(self.problem)

    def _refined_in(self, problem: Problem) -> list[Contender]:
        # For hours beside its best moment a drift does as well as a step.
        still, best = self._proposed
        return [refined(problem, still, self.chosen, trial) for trial in best]

    def _sure_of(self, beside: Projection | None, one: Contender) -> Contender:
        # Beside noise that holds still it gained what the noise would have taken.
        sure = evidence_anew(one, self.chosen)
        trial = replace(one.trial, evidence=sure, gain=sure, delta_bic=sure)
        return replace(one, trial=trial, beside=beside, sure=sure)


def _is_all_of_it(one: Contender, moved: Sequence[Contender]) -> bool:
    """Tell whether what consists of other changes does what each does, beside still noise.

    A clock moves the tilt and the zero of azimuth together. One that fits the zero alone moves
    the tilt off, which noise whose nights lean differently forgives.
    """
    parts = [each for each in moved if each.effect.on_altaz in one.effect.consists_of]
    return one.trial.evidence >= max(each.trial.evidence for each in parts)
