"""A diagnosis from recordings to findings, the steps in their order."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

import numpy as np

from pyport.angles import DEG, Array
from pyport.diagnosis import joint
from pyport.diagnosis.candidates import Untestable
from pyport.diagnosis.case import Problem, measurements
from pyport.diagnosis.disagreements import Disagreement, disagreements
from pyport.diagnosis.folds import folds
from pyport.diagnosis.holdout import Unseen, unseen
from pyport.diagnosis.naming import findings as reading
from pyport.diagnosis.naming import guards
from pyport.diagnosis.naming import scene as scenes
from pyport.diagnosis.naming.finding import Finding, HeldOut
from pyport.diagnosis.preparing import prepare
from pyport.diagnosis.searching.confirming import among
from pyport.diagnosis.searching.search import resumed, search
from pyport.diagnosis.searching.settling import Dropped, settled
from pyport.diagnosis.searching.turns import Outcome, Step, family_p_value, gain_needed
from pyport.diagnosis.searching.winner import trials_of
from pyport.diagnosis.shapes.edge_paths import averaged
from pyport.diagnosis.trial import CandidateFit
from pyport.diagnosis.weighing import WhitenedData, projection, weigh, weigh_model
from pyport.effects.base import Effect
from pyport.effects.empirical.fields import UNKNOWN
from pyport.errors import BadInput
from pyport.fitting.combinations import Combination
from pyport.fitting.misread import Fitted, misread
from pyport.models.model import Model
from pyport.recordings.schema import Recordings
from pyport.runs.stages import stage
from pyport.runs.workers import one_thread
from pyport.thresholds import CONVINCING

TINY = 1e-200
#: What would have to be as large as this [rad] cannot be seen: nothing points so far off.
NO_OFFSET = 10 * DEG


@dataclass(frozen=True)
class Diagnosis:
    """What was found in some recordings.

    Attributes
    ----------
    problem, weighed
        The case and its last weighing; noise, weights and blocks are there.
    findings
        Strongest first; empty where nothing is missing.
    p_value
        Chance that noise alone would look like this, over the whole search.
    detection_limits
        For each testable effect the rms size that would have been seen [rad].
    untestable
        Effects that these recordings cannot show, and why.
    before, after
        Fits of the model alone and of the model with everything found.
    share
        How much each reading counts in an rms, shape (m,): one for most, less in antennas
        that are noisier than usual, zero for outliers and where noise drowns everything.
    noisy
        Antennas that drown in noise.
    heldout
        Predictions of unseen readings by both fits.
    unseen
        Residuals behind `heldout`.
    dropped
        Effects that the search found and that do not predict unseen data.
    steps
        The turns of the search, each with everything that was tried in it.
    two_axes
        Effects of the model that come out different from each axis alone.
    too_few
        Set where there were too few recordings to look for anything.
    combinations
        What is known of coefficients that are not known alone, the model's and those found.
    misread
        How the file may have been misread, if another reading of it fits much better.
    nearest
        The change with time that is likelier than not and does not convince, if there is one.
    """

    problem: Problem
    weighed: WhitenedData
    findings: tuple[Finding, ...]
    p_value: float
    detection_limits: dict[str, float]
    untestable: tuple[Untestable, ...]
    before: joint.Joint
    after: joint.Joint
    share: Array
    noisy: tuple[str, ...]
    heldout: HeldOut
    unseen: Unseen
    dropped: tuple[Dropped, ...] = ()
    steps: tuple[Step, ...] = ()
    two_axes: tuple[Disagreement, ...] = ()
    combinations: tuple[Combination, ...] = ()
    too_few: guards.TooFew | None = None
    misread: str | None = None
    nearest: Dropped | None = None

    @property
    def mismatch(self) -> bool:
        """Tell whether anything is missing from the model."""
        return bool(self.findings)

    def left(self, fit: joint.Joint) -> Array:
        """Return the residuals of a fit [rad], shape (m,)."""
        return self.problem.residual - fit.predicted


@one_thread
@stage("searching")
def diagnose(
    recordings: Recordings,
    model: Model,
    *,
    refit: Collection[str] | None = None,
    seed: int = 0,
    tell: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Find, name and model what a pointing model leaves out of recordings.

    Parameters
    ----------
    recordings
        The measurements.
    model
        The model whose gaps are looked for.
    refit
        Ids of the model's effects that are fitted together with every
        candidate; None for all, an empty collection for none.
    seed
        Of everything that is drawn: same input and seed, same result.
    tell
        Called with a line whenever there is news.

    Raises
    ------
    BadInput
        There is no recording.
    """
    model = model.on(recordings.at.mount)
    problem = prepare(recordings, model, refit, seed)
    if not len(problem.residual):
        raise BadInput("no offset that can be used, expected some", recordings.file)
    few = guards.too_few(problem)
    outcome, dropped = (_unsearched(problem, few), ()) if few else searched(problem, tell)
    if few is None and not outcome.chosen:
        outcome = _nothing_stands(outcome)
    problem, weighed = outcome.problem, outcome.weighed
    alone = weigh_model(problem, (), searching=False) if outcome.chosen else weighed
    before = joint.fit(problem, alone, ())
    after = joint.fit(problem, weighed, outcome.chosen)
    scene = scenes.scene(problem, outcome, after)
    tell("holding data out")
    partition = folds(problem, weighed, outcome.chosen)
    held = unseen(problem, (alone, weighed), (), outcome.chosen, partition)
    return Diagnosis(
        problem=problem,
        weighed=weighed,
        findings=tuple(reading.collect(scene)),
        p_value=outcome.chance,
        detection_limits=_limits(problem, outcome),
        untestable=problem.untestable,
        before=before,
        after=after,
        share=scene.share,
        noisy=tuple(scenes.noisy_antennas(problem, scene.floor)),
        heldout=held.compared(np.ones(len(problem.residual), bool), weighed.covariance.floor),
        unseen=held,
        dropped=dropped,
        steps=outcome.steps,
        two_axes=() if few else disagreements(problem, weighed, outcome.chosen),
        combinations=scene.combinations,
        too_few=few,
        misread=_misread(problem, weighed, after, refit),
        nearest=_nearest(outcome),
    )


def _misread(
    problem: Problem, weighed: WhitenedData, after: joint.Joint, refit: Collection[str] | None
) -> str | None:
    """Return how the file may have been misread; what has no name is no other explanation."""
    found = after.choices[len(problem.base) :]
    named = tuple(one for one in found if one.candidate.effect.physical)
    fits = after if named == found else joint.fit(problem, weighed, named), after
    of_names, of_all = (
        Fitted(
            problem.residual - fit.predicted,
            sum(problem.part(one).size for one in some),
            sum(one.candidate.effect.physical for one in some),
        )
        for fit, some in zip(fits, (named, found), strict=True)
    )
    other = misread(problem.recordings, problem.model, refit, weighed.used, of_names, of_all)
    return None if other is None else other.of_findings


def searched(problem: Problem, tell: Callable[[str], None]) -> tuple[Outcome, tuple[Dropped, ...]]:
    """Return what was found and stands, and what was dropped.

    Names that a field, or a change, stood in place of get their place back where it is dropped, if
    data left out are predicted better with them.
    """
    outcome, dropped = settled(averaged(search(problem, tell)))
    lost = {one.effect for one in dropped}
    changes = {one.effect.id for one in problem.candidates if one.effect.is_change} & lost
    if changes or UNKNOWN in lost:
        without = replace(outcome, banned=outcome.banned | changes)
        again, more = settled(averaged(resumed(without, tell)))
        dropped = tuple(dict.fromkeys((*dropped, *more)))
        partition = folds(again.problem, again.weighed, again.chosen)
        both = outcome.weighed, again.weighed
        before, after = unseen(again.problem, both, outcome.chosen, again.chosen, partition).rms()
        outcome = again if after < before else outcome
    return outcome, dropped


def _nearest(outcome: Outcome) -> Dropped | None:
    """Return the change with time that came nearest to being found, beside what was."""
    one = outcome.nearest
    if one is None or any(one.effect.id == each.candidate.effect.id for each in outcome.chosen):
        return None
    odds, needed = (float(np.exp(each / 2)) for each in (one.sure, CONVINCING))
    return Dropped(
        one.effect.id,
        one.effect.variant,
        f"odds of {odds:.2g} to 1 against drifts and nights that differ, {needed:.2g} are needed",
    )


def _nothing_stands(outcome: Outcome) -> Outcome:
    """Return an outcome without findings: what noise alone does is what the whole noise does."""
    left = projection(outcome.problem, outcome.weighed, ())
    last = tuple(trials_of(outcome.problem, left))
    return replace(outcome, p_value=family_p_value(last), last=last)


def _unsearched(problem: Problem, few: guards.TooFew) -> Outcome:
    """Return the end of a search that was not made: what would have been seen is known."""
    weighed = weigh(problem, (), searching=False)
    last: tuple[CandidateFit, ...] = ()
    if few.scatter_known:
        last = tuple(trials_of(problem, projection(problem, weighed, ())))
    return Outcome(problem, (), (), weighed, 1.0, last)


def _limits(problem: Problem, outcome: Outcome) -> dict[str, float]:
    """Return the size [rad] at which each effect would have been seen in half of the cases.

    The rms over the readings that it acts on, of the middle one of the members of its family.
    """
    sizes: dict[str, list[float]] = {}
    for trial in outcome.last:
        known = float(np.trace(trial.information))
        # What is seen by rounding alone has no size at which it would have been seen.
        if not trial.candidate.effect.physical or "antenna" in trial.scope or known < TINY:
            continue
        own = trial.candidate
        asked = CONVINCING + own.price + among(problem, own.effect)
        gain = gain_needed(trial, asked, *_departing(problem, own.effect))
        columns = problem.picked(own.columns)
        touched = np.count_nonzero(columns.any(axis=1))
        size = float(np.sqrt(gain * (columns**2).sum() / (known * touched)))
        sizes.setdefault(own.effect.id, []).append(size)
    limits = {name: float(np.median(each)) for name, each in sizes.items()}
    return {name: size for name, size in limits.items() if size < NO_OFFSET}


def _departing(problem: Problem, effect: Effect) -> tuple[int, float]:
    """Return how many sessions or sources may do what an effect does, and the readings of each."""
    if problem.blocks.antennas > 1 or not (effect.is_change or effect.belongs_to):
        return 1, np.inf
    of = "source" if effect.belongs_to else "session"
    counts = [len(set(one.labels)) for one in problem.frame.departures if one.of == of]
    count = max(counts, default=1)
    return count, len(np.unique(measurements(problem))) / count
