"""The final set of findings: each must predict unseen data better with it than without it.

The search tests each effect as it joins; what joins later may make it useless, and the sum may
predict worse than its parts. So the whole is fitted once more, and whatever does not pay on data
left out, in the scheme that suits it, is dropped and listed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pyport.angles import Array, Codes
from pyport.diagnosis import holdout
from pyport.diagnosis.case import Chosen, Problem, WhitenedData, temporal, weigh
from pyport.diagnosis.confirm import likeliest
from pyport.diagnosis.finding import HeldOut
from pyport.diagnosis.identify import TIE
from pyport.diagnosis.joint import rms
from pyport.diagnosis.steps import Outcome
from pyport.diagnosis.winner import trials_of
from pyport.least_squares import robust
from pyport.stages import stage
from pyport.thresholds import GROSS, OUT_OF_REACH

#: Stretches left out that tell how far a held-out rms may be off.
FEWEST_STRETCHES = 3
#: Members of a family that are tried beside noise of their own, at most.
MOST_NOISES = 3


@dataclass(frozen=True)
class Dropped:
    """An effect that was looked at and dropped: what it was, and why."""

    effect: str
    variant: str
    reason: str


@dataclass(frozen=True)
class Unseen:
    """Residuals of readings that the fit had not seen, before and after [rad], shape (m,) each.

    `stretch` (m,) numbers what was left out together: a fold within a session; `counted` (m,)
    tells which readings were predicted by both and are no gross errors.
    """

    partition: holdout.Folds
    stretch: Codes
    before: Array
    after: Array
    counted: NDArray[np.bool_]

    def rms(self) -> tuple[float, float]:
        """Return the plain rms before and after, over all readings that count [rad]."""
        return rms(self.before[self.counted]), rms(self.after[self.counted])

    def compared(self, rows: NDArray[np.bool_], floor: Array) -> HeldOut:
        """Return the plain rms over some rows (m,), and that of the scatter alone (m,)."""
        both = rows & self.counted
        return HeldOut(
            self.partition.scheme,
            rms(self.before[both]),
            rms(self.after[both]),
            rms(floor[both]),
            self._fall_sigma(both),
            int((rows & ~self.counted).sum()),
        )

    def _fall_sigma(self, rows: NDArray[np.bool_]) -> float | None:
        """Return the error of the fall of the rms [rad], its stretches drawn independently."""
        stretch = np.unique(self.stretch[rows], return_inverse=True)[1]
        count = int(stretch.max(initial=-1)) + 1
        if count < FEWEST_STRETCHES:
            return None
        before, after = self.before[rows], self.after[rows]
        share = before**2 / max(rms(before), 1e-300) - after**2 / max(rms(after), 1e-300)
        # The derivative of each rms by its mean square is one over twice the rms.
        share = (share - share.mean()) / (2 * len(share))
        sums = np.bincount(stretch, share, count)
        return float(np.sqrt(count / (count - 1) * np.sum(sums**2)))


def unseen(
    setup: Problem,
    weighed: tuple[WhitenedData, WhitenedData],
    before: tuple[Chosen, ...],
    after: tuple[Chosen, ...],
    partition: holdout.Folds,
) -> Unseen:
    """Predict what was left out with and without some effects, each under its own noise.

    A reading is a gross error when both predictions miss it by more than `GROSS` times the
    scatter that the readings of the other folds have about theirs.
    """
    first = holdout.residuals(setup, weighed[0], before, partition, after if before else ())
    second = holdout.residuals(setup, weighed[1], after, partition)
    finite = np.isfinite(first) & np.isfinite(second)
    nearest = np.where(finite, np.minimum(np.abs(first), np.abs(second)), np.inf)
    counted = finite.copy()
    antenna = np.unique(setup.blocks.antenna, return_inverse=True)[1][setup.block]
    series = antenna * 2 + setup.stack.is_y
    for one in np.unique(series):
        for fold in np.unique(partition.fold[series == one]):
            own = (series == one) & (partition.fold == fold)
            others = (series == one) & (partition.fold != fold) & finite
            if others.any():
                counted[own] &= nearest[own] <= GROSS * robust.scale(nearest[others])
    stretch = np.unique([setup.session, partition.fold], axis=1, return_inverse=True)[1].ravel()
    return Unseen(partition, stretch, first, second, counted)


@stage("settling findings")
def settled(outcome: Outcome) -> tuple[Outcome, tuple[Dropped, ...]]:
    """Weigh with the final noise, and drop what does not predict unseen data better.

    One at a time; then, while the whole predicts worse than the model alone, the weakest.
    """
    outcome = _of_families(outcome)
    dropped: list[Dropped] = []
    while True:
        weighed = weigh(outcome.setup, outcome.chosen, searching=False)
        outcome = replace(outcome, weighed=weighed)
        worst = _worst(outcome)
        if worst is None:
            return _held_to_the_end(outcome), tuple(dropped)
        one, reason = worst
        effect = one.candidate.effect
        dropped.append(Dropped(effect.id, effect.variant, reason))
        outcome = outcome.without(one)


def _held_to_the_end(outcome: Outcome) -> Outcome:
    """Hold each lasting effect against its rivals once more, beside the final noise.

    The noise in which it was found had grown to hold what it explains, and told it from its
    rivals less well than the noise that is left.
    """
    setup, weighed, steps = outcome.setup, outcome.weighed, []
    for step in outcome.steps:
        one = step.chosen
        refined = one.candidate is not step.winner.candidate
        effect = one.candidate.effect
        if refined or not effect.physical or effect.changes_with or setup.blocks.antennas > 1:
            steps.append(step)
            continue
        others = outcome.others(one)
        beside = weighed.evidence.beside([setup.part(each) for each in (*setup.base, *others)])
        own = beside.trials([(one.candidate, one.scope)])
        if own:
            trials = tuple(trials_of(setup, beside))
            step = replace(  # noqa: PLW2901 - the same turn beside the final noise
                step, winner=own[0], trials=trials, before=others, beside=beside
            )
        steps.append(step)
    return replace(outcome, steps=tuple(steps))


def _of_families(outcome: Outcome) -> Outcome:
    """Choose the members of families anew, each beside the noise that it leaves.

    The search holds all members against one noise, which may have grown to hold what the right
    one explains.
    """
    setup = outcome.setup
    for one in outcome.chosen:
        step = outcome.step_of(one)
        if one.candidate is not step.winner.candidate or one.candidate.choices == 1:
            continue
        if temporal(setup, one.candidate.effect):
            continue
        same = [
            each
            for each in step.trials
            if each.candidate.effect.id == one.candidate.effect.id
            and each.scope == one.scope
            and each.evidence > step.winner.evidence - OUT_OF_REACH
        ]
        same.sort(key=lambda each: -round(each.evidence, TIE))
        members = [Chosen(each.candidate, each.scope) for each in same[:MOST_NOISES]]
        members = [one, *(each for each in members if each.candidate is not one.candidate)]
        best = likeliest(setup, outcome.others(one), members) if len(members) > 1 else one
        if best is not one:
            winner = next(each for each in same if each.candidate is best.candidate)
            new = replace(step, winner=winner, chosen=best)
            outcome = replace(
                outcome,
                chosen=tuple(best if each is one else each for each in outcome.chosen),
                steps=tuple(new if each is step else each for each in outcome.steps),
            )
    return outcome


def _worst(outcome: Outcome) -> tuple[Chosen, str] | None:
    """Return the choice that is to be dropped, and why; None where all of them pay.

    Of several that do harm the one with the least evidence: the others may do it through it.
    """
    setup, weighed, chosen = outcome.setup, outcome.weighed, outcome.chosen
    gains = []
    for one in chosen:
        partition = holdout.folds(setup, weighed, (one,))
        found = unseen(setup, (weighed, weighed), outcome.others(one), chosen, partition)
        before, after = found.rms()
        gains.append((before - after) / max(before, 1e-300))
    harm = [n for n, gain in enumerate(gains) if gain <= 0]
    if harm:
        worst = min(harm, key=lambda n: outcome.step_of(chosen[n]).winner.evidence)
        return chosen[worst], (
            f"data left out are predicted worse with it, by {-100 * gains[worst]:.2g} per cent"
        )
    if chosen and (weakest := _harm_to_all(outcome)) is not None:
        return weakest, "with everything found data left out are predicted worse than by the model"
    return None


def _harm_to_all(outcome: Outcome) -> Chosen | None:
    """Return the choice that all others do best without, where all do no better than the model."""
    setup, weighed, chosen = outcome.setup, outcome.weighed, outcome.chosen
    alone = weigh(setup, (), searching=False)
    partition = holdout.folds(setup, weighed, chosen)

    def rms_with(some: tuple[Chosen, ...]) -> tuple[float, float]:
        return unseen(setup, (alone, weighed), (), some, partition).rms()

    before, after = rms_with(chosen)
    if after < before:
        return None
    return min(chosen, key=lambda one: rms_with(outcome.others(one))[1])
