"""The turns of a search, and its end."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pyport.diagnosis.case import Chosen, Problem, WhitenedData
from pyport.diagnosis.evidence import CandidateFit, Projection


@dataclass(frozen=True)
class Step:
    """One turn of the search.

    Attributes
    ----------
    winner, chosen
        The trial that won, and what was added: the winner with its moment or edge refined.
    trials
        Everything that was tried beside the model of that turn.
    before
        The model of that turn, without the winner.
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
    before: tuple[Chosen, ...]
    beside: Projection
    p_value: float
    price: float = 0.0


@dataclass(frozen=True)
class Outcome:
    """The end of a search: what was chosen in which turn, and the evidence weighed with all of it.

    `setup` is the case with the columns of what was refined added to it.
    `p_value` is that of the first turn: is there any mismatch at all?
    `last` holds the trials of the turn that found nothing more.
    """

    setup: Problem
    chosen: tuple[Chosen, ...]
    steps: tuple[Step, ...]
    weighed: WhitenedData
    p_value: float
    last: tuple[CandidateFit, ...]

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
