"""The turns of a search, and its end."""

from __future__ import annotations

from dataclasses import dataclass

from pyport.diagnosis.case import Chosen, Setup, Weighed
from pyport.diagnosis.evidence import Beside, Trial


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
    """

    winner: Trial
    chosen: Chosen
    trials: tuple[Trial, ...]
    before: tuple[Chosen, ...]
    beside: Beside
    p_value: float


@dataclass(frozen=True)
class Outcome:
    """The end of a search: what was chosen in which turn, and the evidence weighed with all of it.

    `setup` is the case with the columns of what was refined added to it.
    `p_value` is that of the first turn: is there any mismatch at all?
    `last` holds the trials of the turn that found nothing more.
    """

    setup: Setup
    chosen: tuple[Chosen, ...]
    steps: tuple[Step, ...]
    weighed: Weighed
    p_value: float
    last: tuple[Trial, ...]
