"""Calibration: what statistics come to where nothing is hidden, in every kind of noise.

One case gives three of them: the p-value of the first turn of the search, the most evidence that an
effect has beside noise estimated anew, and how many sigmas fitted coefficients are from the truth.
The noise is estimated from each case alone, as it is from recordings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from pyport.diagnosis.preparing import prepare
from pyport.diagnosis.searching.confirmed_changes import Changes
from pyport.diagnosis.searching.contenders import evidence_anew
from pyport.diagnosis.searching.turns import family_p_value
from pyport.diagnosis.searching.winner import lasting_effects, trials_of
from pyport.diagnosis.weighing import projection, weigh
from pyport.examiner import program
from pyport.examiner.nulls import nulls
from pyport.examiner.scores import Share, clustered, counted
from pyport.formats.models import load
from pyport.recordings.from_table import from_table

#: What each statistic is held against: name -> levels.
LEVELS: dict[str, tuple[float, ...]] = {
    "FAMILY_ERROR": (0.003, 0.01, 0.03, 0.1, 0.5),
    "CONVINCING": (2.0, 4.0, 6.0, 8.0, 10.0),
    "coverage": (1.0, 2.0, 3.0),
}
_SAYS = {
    "FAMILY_ERROR": "share of cases with a p-value of the first turn up to",
    "CONVINCING": "share of cases in which an effect has more evidence than",
    "coverage": "share of coefficients within so many sigma of the truth",
}


def examine(case: nulls.Case) -> dict[str, Any]:
    """Draw a case and return its statistics."""
    world = nulls.draw(case)
    recordings = from_table(world.table, dict(world.header))
    problem = prepare(recordings, load("altaz").on(recordings.at.mount), None, 0)
    weighed = weigh(problem)
    beside = projection(problem, weighed, ())
    trials = trials_of(problem, beside)
    changes = Changes(problem, weighed.covariance, (), trials).confirmed(-np.inf)
    lasting = lasting_effects(problem, weighed, (), trials, (), lambda *_: 0.0, beside)
    sure = [one.sure for one in changes] + [
        min(evidence_anew(one, ()), one.trial.evidence) for one in lasting
    ]
    return vars(case) | {
        "program": program.version(),
        "p_value": family_p_value(trials),
        "evidence": max(sure, default=None),
        "z": nulls.of_fit(world),
    }


def text(name: str, outcomes: Iterable[dict[str, Any]]) -> str:
    """Return a table of one statistic: a kind of noise a row, a level a column."""
    outcomes = list(outcomes)
    levels = LEVELS[name]
    lines = [f"{name}: {_SAYS[name]}", _row("kind", "cases", *(f"{one:g}" for one in levels))]
    for kind in (*dict.fromkeys(one["kind"] for one in outcomes), "all"):
        own = [one for one in outcomes if kind in ("all", one["kind"])]
        shares = [_SHARES[name](own, level) for level in levels]
        lines.append(_row(kind, str(len(own)), *map(str, shares)))
    return "\n".join(lines)


def _row(*cells: str) -> str:
    first, *others = cells
    return f"{first:20}" + "".join(f"{one:>20}" for one in others)


_SHARES: dict[str, Callable[[list[dict[str, Any]], float], Share]] = {
    "FAMILY_ERROR": lambda some, level: counted([one["p_value"] <= level for one in some]),
    "CONVINCING": lambda some, level: counted(
        [one["evidence"] is not None and one["evidence"] > level for one in some]
    ),
    "coverage": lambda some, level: clustered(
        [[abs(z) <= level for z in one["z"].values()] for one in some]
    ),
}
